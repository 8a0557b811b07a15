/* What an instance is between calls, whatever the version of the standard */

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

/* A prefix of functions, where the compiler is given one, keeps several FMUs apart in one program. */
#define PASTED(a, b) a##b
#define JOINED(a, b) PASTED(a, b)

/* How far a step may be off a whole number of samples, as times are rounded [samples]. */
#define TOLERANCE 1e-4

/* How far an instance has come. */
typedef enum { INSTANTIATED = 1, INITIALISING = 2, STEPPING = 4, TERMINATED = 8 } Phase;

enum { ANY_TIME = 15, NOT_OVER = 7 };

/* How a call ends, in the numbers of the standard. */
enum { DONE = 0, REFUSED = 3 };

/* What is told to the logger. */
enum { NOTHING = 0, ERRORS = 1, EVENTS = 2, ALL = 3 };

static const char *const error_category = "logStatusError";
static const char *const event_category = "logEvents";

/* Only states that were set by hand lead there. */
static const char *const overflow =
    "output or state would be no finite number, because the state is too large: reset the instance, or set an earlier state";

/* All that can be kept and brought back later. */
typedef struct {
    char token[sizeof(TOKEN)];
    Phase phase;
    double time;
    double input[INPUTS];
    double gain[INPUTS];
    double offset[INPUTS];
    double output;
    State state;
} Course;

typedef struct {
    Course now;
    int told;
    void *environment;
    /* Of the type that the version of the standard gives it. */
    void (*logger)(void);
    char name[];
} Instance;

/* Hands a text to the logger; there is no percent sign in it. */
static void tell(const Instance *m, int status, const char *category, const char *text);

static int refuse(const Instance *m, const char *call, const char *why)
{
    if ((m != NULL) && ((m->told & ERRORS) != 0)) {
        char text[320];
        (void)snprintf(text, sizeof(text), "%s: %s", call, why);
        tell(m, REFUSED, error_category, text);
    }
    return REFUSED;
}

static int done(const Instance *m, const char *event)
{
    if ((m->told & EVENTS) != 0) {
        tell(m, DONE, event_category, event);
    }
    return DONE;
}

/* Refuses a call that comes at the wrong time. */
static int expect(const Instance *m, int phases, const char *call)
{
    int status = REFUSED;
    if ((m != NULL) && (((int)m->now.phase & phases) != 0)) {
        status = DONE;
    } else if (m != NULL) {
        const char *is = "instantiated but not initialised: enter and leave the initialisation mode first";
        if (m->now.phase == INITIALISING) {
            is = "being initialised: leave the initialisation mode first";
        } else if (m->now.phase == STEPPING) {
            is = "initialised already: reset it first";
        } else if (m->now.phase == TERMINATED) {
            is = "terminated: reset it first";
        }
        char why[160];
        (void)snprintf(why, sizeof(why), "this call is not allowed now, because the instance is %s", is);
        status = refuse(m, call, why);
    }
    return status;
}

/* Whether v is finite, in the precision of the model. */
static int is_number(double v)
{
    return (v >= -LARGEST) && (v <= LARGEST);
}

/* Whether all numbers of a state are finite. */
static int is_finite(const State *s)
{
    State copy = *s;
    int all = 1;
    for (unsigned int k = 0; k < VARIABLES - STATE; k++) {
        all = all && is_number((double)*place(&copy, k));
    }
    return all;
}

/* All as it is after instantiation. */
static void begin(Course *now)
{
    memset(now, 0, sizeof(*now));
    memcpy(now->token, TOKEN, sizeof(TOKEN));
    now->phase = INSTANTIATED;
    for (int k = 0; k < INPUTS; k++) {
        now->gain[k] = 1.0;
    }
    rest(&now->state);
}

static Instance *instance(const char *name, int told, void *environment, void (*logger)(void))
{
    const size_t length = strlen(name) + 1u;
    Instance *m = calloc(1u, sizeof(Instance) + length);
    if (m != NULL) {
        memcpy(m->name, name, length);
        m->told = told;
        m->environment = environment;
        m->logger = logger;
        begin(&m->now);
        (void)done(m, "instantiated");
    }
    return m;
}

/* Which categories are told from now on; where none is named, `unnamed` are meant. */
static int set_logging(Instance *m, const char *call, int on, size_t n, const char *const categories[], int unnamed)
{
    int status = expect(m, ANY_TIME, call);
    int meant = (n == 0u) ? unnamed : NOTHING;
    int known = 1;
    for (size_t k = 0; (k < n) && known; k++) {
        const char *category = (categories != NULL) ? categories[k] : NULL;
        if ((category != NULL) && (strcmp(category, error_category) == 0)) {
            meant |= ERRORS;
        } else if ((category != NULL) && (strcmp(category, event_category) == 0)) {
            meant |= EVENTS;
        } else {
            known = 0;
        }
    }
    if ((status == DONE) && !known) {
        status = refuse(m, call, "no such category: known are logStatusError and logEvents");
    }
    if (status == DONE) {
        m->told = on ? (m->told | meant) : (m->told & ~meant);
    }
    return status;
}

/* What enters the model: gain times input, plus offset. Whether it is all finite. */
static int entering(const Course *now, double enters[INPUTS])
{
    int all = 1;
    for (int k = 0; k < INPUTS; k++) {
        enters[k] = now->gain[k] * now->input[k] + now->offset[k];
        all = all && is_number(enters[k]);
    }
    return all;
}

/* The output; before the first step, what the state at hand answers to the input at hand, and stays where it is. */
static double output(const Course *now)
{
    double y = now->output;
    double enters[INPUTS];
    if (((now->phase == INSTANTIATED) || (now->phase == INITIALISING)) && entering(now, enters)) {
        State copy = now->state;
        y = sample(&copy, enters);
    }
    return y;
}

static int enter_initialisation(Instance *m, const char *call, double start)
{
    int status = expect(m, INSTANTIATED, call);
    if ((status == DONE) && !is_number(start)) {
        status = refuse(m, call, "the start time must be a finite number");
    }
    if (status == DONE) {
        m->now.time = start;
        m->now.phase = INITIALISING;
    }
    return status;
}

static int exit_initialisation(Instance *m, const char *call)
{
    int status = expect(m, INITIALISING, call);
    const double first = (status == DONE) ? output(&m->now) : 0.0;
    if ((status == DONE) && !is_number(first)) {
        status = refuse(m, call, overflow);
    }
    if (status == DONE) {
        m->now.output = first;
        m->now.phase = STEPPING;
        status = done(m, "initialised");
    }
    return status;
}

static int terminate(Instance *m, const char *call)
{
    int status = expect(m, STEPPING, call);
    if (status == DONE) {
        m->now.phase = TERMINATED;
        status = done(m, "terminated");
    }
    return status;
}

static int reset(Instance *m, const char *call)
{
    int status = expect(m, ANY_TIME, call);
    if (status == DONE) {
        begin(&m->now);
        status = done(m, "reset");
    }
    return status;
}

/* Runs the samples from one communication point to the next, the input held. */
static int step(Instance *m, const char *call, double from, double length)
{
    int status = expect(m, STEPPING, call);
    char why[240] = "";
    double enters[INPUTS];
    long samples = 0;
    if (status == DONE) {
        Course *now = &m->now;
        const double ratio = length / TS;
        const double ahead = from - now->time;
        if ((ratio >= 0.5) && (ratio < 1e9)) {
            samples = (long)(ratio + 0.5);
        }
        const double off = ratio - (double)samples;
        if ((samples == 0) || (off > TOLERANCE) || (off < -TOLERANCE)) {
            (void)snprintf(why, sizeof(why),
                           "a step of %.12g s is no whole number of samples: make it a multiple of %.12g s", length,
                           TS);
        } else if (!((ahead <= 0.5 * TS) && (ahead >= -0.5 * TS))) {
            (void)snprintf(why, sizeof(why),
                           "the step begins at %.12g s but the time of the instance is %.12g s: continue from that time", from,
                           now->time);
        } else if (!entering(now, enters)) {
            (void)snprintf(why, sizeof(why), "gain times input plus offset is no finite number: make them smaller");
        } else {
            State next = now->state;
            double y = now->output;
            for (long k = 0; k < samples; k++) {
                y = sample(&next, enters);
            }
            if (is_number(y) && is_finite(&next)) {
                now->state = next;
                now->output = y;
                now->time = from + length;
            } else {
                (void)snprintf(why, sizeof(why), "%s", overflow);
            }
        }
    }
    if (why[0] != '\0') {
        status = refuse(m, call, why);
    }
    return status;
}

static double value(Instance *m, unsigned int reference)
{
    Course *now = &m->now;
    double v = TS;
    if (reference == TIME) {
        v = now->time;
    } else if (reference < GAIN) {
        v = now->input[reference - INPUT];
    } else if (reference < OFFSET) {
        v = now->gain[reference - GAIN];
    } else if (reference < OUTPUT) {
        v = now->offset[reference - OFFSET];
    } else if (reference == OUTPUT) {
        v = output(now);
    } else if (reference != PERIOD) {
        v = (double)*place(&now->state, reference - STATE);
    }
    return v;
}

static int get_reals(Instance *m, const char *call, const unsigned int references[], size_t n, double values[])
{
    int status = expect(m, ANY_TIME, call);
    for (size_t k = 0; (k < n) && (status == DONE); k++) {
        if ((references == NULL) || (values == NULL) || (references[k] >= VARIABLES)) {
            status = refuse(m, call, "there is no such variable: take the value references of modelDescription.xml");
        }
    }
    for (size_t k = 0; (k < n) && (status == DONE); k++) {
        values[k] = value(m, references[k]);
        if (!is_number(values[k])) {
            status = refuse(m, call, overflow);
        }
    }
    return status;
}

/* Why a variable may not have this value now; NULL if it may. */
static const char *forbidden(const Course *now, unsigned int reference, double v)
{
    const char *why = NULL;
    if (reference >= VARIABLES) {
        why = "there is no such variable: take the value references of modelDescription.xml";
    } else if ((reference == TIME) || (reference == OUTPUT) || (reference == PERIOD)) {
        why = "time, output and sampling period cannot be set: set inputs, parameters and the initial state";
    } else if ((reference >= STATE) && (now->phase == STEPPING)) {
        why = "a state can be set before the initialisation ends: reset the instance, or set a whole FMU state";
    } else if (!is_number(v)) {
        why = "a value is not finite, or too large: every value must be a finite number";
    }
    return why;
}

/* Sets all of them, or none. */
static int set_reals(Instance *m, const char *call, const unsigned int references[], size_t n, const double values[])
{
    int status = expect(m, NOT_OVER, call);
    for (size_t k = 0; (k < n) && (status == DONE); k++) {
        const int given = (references != NULL) && (values != NULL);
        const char *why = given ? forbidden(&m->now, references[k], values[k]) : "there are no values to set";
        if (why != NULL) {
            status = refuse(m, call, why);
        }
    }
    for (size_t k = 0; (k < n) && (status == DONE); k++) {
        Course *now = &m->now;
        if (references[k] < GAIN) {
            now->input[references[k] - INPUT] = values[k];
        } else if (references[k] < OFFSET) {
            now->gain[references[k] - GAIN] = values[k];
        } else if (references[k] < OUTPUT) {
            now->offset[references[k] - OFFSET] = values[k];
        } else {
            *place(&now->state, references[k] - STATE) = (number)values[k];
        }
    }
    return status;
}

/* For variables of a type that there are none of. */
static int no_variables(const Instance *m, const char *call, size_t n)
{
    int status = expect(m, ANY_TIME, call);
    if ((status == DONE) && (n > 0u)) {
        status = refuse(m, call, "there are no variables of this type: all are real numbers");
    }
    return status;
}
