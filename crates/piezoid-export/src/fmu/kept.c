/* States of the FMU as a whole: kept, brought back, written down and read */

/* Whether these bytes are a state of this very FMU, of finite numbers. */
static int is_course(const Course *kept)
{
    const int phase = (int)kept->phase;
    int fits = (phase == INSTANTIATED) || (phase == INITIALISING) || (phase == STEPPING) || (phase == TERMINATED);
    fits = fits && (memcmp(kept->token, TOKEN, sizeof(TOKEN)) == 0) && is_number(kept->time) && is_number(kept->output);
    for (int k = 0; k < INPUTS; k++) {
        fits = fits && is_number(kept->input[k]) && is_number(kept->gain[k]) && is_number(kept->offset[k]);
    }
    return fits && is_finite(&kept->state);
}

/* Keeps a course in *state, which is made if it is not there yet. */
static int keep(const Instance *m, const char *call, const Course *course, void **state)
{
    int status = DONE;
    if (state == NULL) {
        status = refuse(m, call, "the pointer to the state is NULL");
    } else {
        if (*state == NULL) {
            *state = calloc(1u, sizeof(Course));
        }
        if (*state == NULL) {
            status = refuse(m, call, "there is no memory left");
        } else {
            memcpy(*state, course, sizeof(Course));
        }
    }
    return status;
}

static int get_whole(const Instance *m, const char *call, void **state)
{
    int status = expect(m, ANY_TIME, call);
    if (status == DONE) {
        status = keep(m, call, &m->now, state);
    }
    return status;
}

static int set_whole(Instance *m, const char *call, const void *state)
{
    int status = expect(m, ANY_TIME, call);
    if ((status == DONE) && ((state == NULL) || !is_course(state))) {
        status = refuse(m, call, "this is no state of this FMU");
    }
    if (status == DONE) {
        memcpy(&m->now, state, sizeof(Course));
    }
    return status;
}

static int free_whole(const Instance *m, const char *call, void **state)
{
    int status = expect(m, ANY_TIME, call);
    if ((status == DONE) && (state != NULL)) {
        free(*state);
        *state = NULL;
    }
    return status;
}

static int state_size(const Instance *m, const char *call, const void *state, size_t *size)
{
    int status = expect(m, ANY_TIME, call);
    if ((status == DONE) && ((state == NULL) || (size == NULL))) {
        status = refuse(m, call, "there is no state, or no place for its size");
    }
    if (status == DONE) {
        *size = sizeof(Course);
    }
    return status;
}

static int serialise(const Instance *m, const char *call, const void *state, void *bytes, size_t size)
{
    int status = expect(m, ANY_TIME, call);
    if ((status == DONE) && ((state == NULL) || !is_course(state) || (bytes == NULL) || (size < sizeof(Course)))) {
        char why[160];
        (void)snprintf(why, sizeof(why), "there is no state, or less room than its %lu bytes",
                       (unsigned long)sizeof(Course));
        status = refuse(m, call, why);
    }
    if (status == DONE) {
        memcpy(bytes, state, sizeof(Course));
    }
    return status;
}

static int deserialise(const Instance *m, const char *call, const void *bytes, size_t size, void **state)
{
    int status = expect(m, ANY_TIME, call);
    if (status == DONE) {
        Course kept;
        const int fits = (bytes != NULL) && (size == sizeof(Course));
        if (fits) {
            memcpy(&kept, bytes, sizeof(Course));
        }
        if (fits && is_course(&kept)) {
            status = keep(m, call, &kept, state);
        } else {
            status = refuse(
                m, call,
                "these bytes are no state of this FMU: serialise one with the same FMU on the same kind of machine");
        }
    }
    return status;
}
