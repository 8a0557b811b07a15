/* Random calls of an FMU, in any order and with any arguments, against a second account of what must happen.

   Compiled with -DVERSION=2 or 3 and -DWRAPPER="\"NAME_fmiV_fmu.c\"". Every status, every value that is read and every
   output is compared. It ends with status 0 where all are right, else with 1 after the first difference. What it does
   not do: pointers that no FMU gave out, which the standard leaves undefined. */
#include WRAPPER
#include <math.h>

#define CALLS 500000
#define INSTANCES 3
#define KEPT 4

/* What must be known of an instance. */
typedef struct {
    int phase;
    double time;
    double input[INPUTS], gain[INPUTS], offset[INPUTS];
    double output;
    State state;
} Account;

static void *instances[INSTANCES];
static Account accounts[INSTANCES];
static void *kept[KEPT];
static Account kept_accounts[KEPT];
static int done_calls[40][2];
static unsigned long long seed = 1u;
static long call_number;

static unsigned int drawn(unsigned int below)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned int)(seed >> 33) % below;
}

static void check(int holds, const char *call, const char *what)
{
    if (!holds) {
        printf("call %ld, %s: %s\n", call_number, call, what);
        exit(1);
    }
}

static int finite_number(double v)
{
    return fabs(v) <= LARGEST;
}

static double any_value(void)
{
    static const double rare[] = {0.0, -0.0, 5e-324, -1e-310, 1e300, -1e300, 3e38, -1e38, 1e19, DBL_MAX, HUGE_VAL, -HUGE_VAL};
    const unsigned int kind = drawn(12);
    double v = ((double)drawn(60001) - 30000.0) / 1000.0;
    if (kind == 0u) {
        v = (double)NAN;
    } else if (kind <= 2u) {
        v = rare[drawn(sizeof(rare) / sizeof(rare[0]))];
    }
    return v;
}

#if VERSION == 2
static void told(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    check((environment == &seed) && (name != NULL) && (category != NULL) && (text[0] != '\0'), "logger", "arguments");
    (void)status;
}
static void *create(const char *name, const char *token, int wrong_kind, int silent)
{
    const fmi2CallbackFunctions functions = {silent ? NULL : told, NULL, NULL, NULL, &seed};
    return fmi2Instantiate(name, wrong_kind ? fmi2ModelExchange : fmi2CoSimulation, token, NULL,
                           (silent > 1) ? NULL : &functions, 0, (int)drawn(2));
}
#define V(name) fmi2##name
#define ENTER(c, start) (int)(isnan(start) ? fmi2Error : fmi2EnterInitializationMode(c))
#define SET(c, vr, n, v) (int)fmi2SetReal(c, vr, n, v)
#define GET(c, vr, n, v) (int)fmi2GetReal(c, vr, n, v)
#define STEP(c, from, length) (int)fmi2DoStep(c, from, length, 1)
#define KEEP fmi2GetFMUstate
#define BRING fmi2SetFMUstate
#define DROP fmi2FreeFMUstate
#define SIZE fmi2SerializedFMUstateSize
#define WRITE fmi2SerializeFMUstate
#define READ fmi2DeSerializeFMUstate
#else
static void told(void *environment, fmi3Status status, fmi3String category, fmi3String text)
{
    check((environment == &seed) && (category != NULL) && (text[0] != '\0'), "logger", "arguments");
    (void)status;
}
static void *create(const char *name, const char *token, int wrong_kind, int silent)
{
    return wrong_kind ? fmi3InstantiateModelExchange(name, token, NULL, false, true, &seed, silent ? NULL : told)
                      : fmi3InstantiateCoSimulation(name, token, NULL, false, drawn(2) == 0u, false, false, NULL, 0,
                                                    &seed, silent ? NULL : told, NULL);
}
#define V(name) fmi3##name
#define ENTER(c, start) (int)fmi3EnterInitializationMode(c, false, 0.0, start, false, 0.0)
#define SET(c, vr, n, v) (int)fmi3SetFloat64(c, vr, n, v, n)
#define GET(c, vr, n, v) (int)fmi3GetFloat64(c, vr, n, v, n)
#define STEP(c, from, length) (int)stepped(c, from, length)
#define KEEP fmi3GetFMUState
#define BRING fmi3SetFMUState
#define DROP fmi3FreeFMUState
#define SIZE fmi3SerializedFMUStateSize
#define WRITE fmi3SerializeFMUState
#define READ fmi3DeserializeFMUState
static fmi3Status stepped(void *c, double from, double length)
{
    bool event = true, end = true, early = true;
    double last = -1.0;
    const int none = drawn(10) == 0u;
    const fmi3Status status = fmi3DoStep(c, from, length, true, none ? NULL : &event, none ? NULL : &end,
                                         none ? NULL : &early, none ? NULL : &last);
    check(none || (!event && !end && !early), "fmi3DoStep", "an event out of nothing");
    return status;
}
#endif

static int enters(const Account *a, double v[INPUTS])
{
    int all = 1;
    for (int k = 0; k < INPUTS; k++) {
        v[k] = a->gain[k] * a->input[k] + a->offset[k];
        all = all && finite_number(v[k]);
    }
    return all;
}

/* The output that must be read now. */
static double expected_output(const Account *a)
{
    double v[INPUTS];
    double y = a->output;
    if ((a->phase <= 2) && enters(a, v)) {
        State copy = a->state;
        y = sample(&copy, v);
    }
    return y;
}

static void restart(Account *a)
{
    memset(a, 0, sizeof(*a));
    a->phase = 1;
    for (int k = 0; k < INPUTS; k++) {
        a->gain[k] = 1.0;
    }
    rest(&a->state);
}

static void expect_status(int status, int allowed, int what, const char *call)
{
    done_calls[what][allowed != 0]++;
    check((status == 0) == (allowed != 0), call, allowed ? "refused" : "not refused");
    check((status == 0) || (status == 3) || ((VERSION == 2) && (status == 2)), call, "an unknown status");
}

static void create_one(int k)
{
    static const char *const tokens[] = {TOKEN, TOKEN, TOKEN, TOKEN, NULL, "", "{0}", TOKEN "0"};
    const char *token = tokens[drawn(8)];
    const char *name = (drawn(8) == 0u) ? ((drawn(2) == 0u) ? NULL : "") : "actuator";
    const int wrong_kind = drawn(8) == 0u;
    void *made = create(name, token, wrong_kind, (int)drawn(3));
    const int right = (token != NULL) && (strcmp(token, TOKEN) == 0) && (name != NULL) && (name[0] != '\0') && !wrong_kind;
    check((made != NULL) == right, "instantiate", right ? "refused" : "not refused");
    instances[k] = made;
    if (right) {
        restart(&accounts[k]);
    }
}

static void set_some(void *c, Account *a)
{
    unsigned int references[4];
    double values[4];
    const size_t n = drawn(5);
    const int none = drawn(20) == 0u;
    int allowed = (c != NULL) && (a->phase <= 4) && (!none || (n == 0u));
    for (size_t k = 0; k < n; k++) {
        references[k] = (drawn(30) == 0u) ? ((drawn(2) == 0u) ? VARIABLES : 0xFFFFFFFFu) : drawn(VARIABLES);
        references[k] = (drawn(2) == 0u) ? INPUT + drawn(3u * INPUTS) : references[k];
        values[k] = any_value();
        const unsigned int r = references[k];
        allowed = allowed && (r >= INPUT) && (r < VARIABLES) && (r != OUTPUT) && (r != PERIOD) && finite_number(values[k]);
        allowed = allowed && ((r < STATE) || (a->phase <= 2));
    }
    expect_status(SET(c, none ? NULL : references, n, none ? NULL : values), allowed, 0, "set");
    for (size_t k = 0; allowed && (k < n); k++) {
        const unsigned int r = references[k];
        if (r < GAIN) {
            a->input[r - INPUT] = values[k];
        } else if (r < OFFSET) {
            a->gain[r - GAIN] = values[k];
        } else if (r < OUTPUT) {
            a->offset[r - OFFSET] = values[k];
        } else {
            *place(&a->state, r - STATE) = (number)values[k];
        }
    }
}

static void get_some(void *c, Account *a)
{
    unsigned int references[4];
    double values[4];
    double right[4];
    const size_t n = drawn(5);
    const int none = drawn(20) == 0u;
    int allowed = (c != NULL) && (!none || (n == 0u));
    for (size_t k = 0; (k < n) && (c != NULL); k++) {
        const unsigned int r = (drawn(30) == 0u) ? VARIABLES + drawn(9) : ((drawn(3) == 0u) ? OUTPUT : drawn(VARIABLES));
        references[k] = r;
        right[k] = TS;
        if (r >= VARIABLES) {
            allowed = 0;
        } else if (r == TIME) {
            right[k] = a->time;
        } else if (r < GAIN) {
            right[k] = a->input[r - INPUT];
        } else if (r < OFFSET) {
            right[k] = a->gain[r - GAIN];
        } else if (r < OUTPUT) {
            right[k] = a->offset[r - OFFSET];
        } else if (r == OUTPUT) {
            right[k] = expected_output(a);
        } else if (r >= STATE) {
            right[k] = (double)*place(&a->state, r - STATE);
        }
        allowed = allowed && finite_number(right[k]);
    }
    expect_status(GET(c, none ? NULL : references, n, none ? NULL : values), allowed, 1, "get");
    for (size_t k = 0; allowed && (k < n); k++) {
        check(memcmp(&values[k], &right[k], sizeof(double)) == 0, "get", "another value");
    }
}

static void step_some(void *c, Account *a)
{
    static const double lengths[] = {TS, TS, TS, TS, 3.0 * TS, 7.0 * TS, TS * (1.0 + 1e-9), 0.0, -TS, 1.5 * TS, 1e-300,
                                     1e300, HUGE_VAL, -HUGE_VAL};
    const unsigned int kind = drawn(15);
    const double length = (kind == 14u) ? (double)NAN : lengths[kind];
    const int right_length = kind <= 6u;
    double from = a->time;
    int right_time = 1;
    switch (drawn(12)) {
    case 0: from = a->time + 2.0 * TS; right_time = from - a->time <= 0.5 * TS; break;
    case 1: from = (double)NAN; right_time = 0; break;
    case 2: from = HUGE_VAL; right_time = 0; break;
    case 3: from = a->time + 0.25 * TS; break;
    default: break;
    }
    double v[INPUTS];
    int allowed = (c != NULL) && (a->phase == 4) && right_length && right_time && enters(a, v);
    State next = a->state;
    double y = 0.0;
    for (int k = 0; allowed && (k < (int)(length / TS + 0.5)); k++) {
        y = sample(&next, v);
    }
    allowed = allowed && finite_number(y);
    for (unsigned int k = 0; k < VARIABLES - STATE; k++) {
        allowed = allowed && finite_number((double)*place(&next, k));
    }
    expect_status(STEP(c, from, length), allowed, 2, "step");
    if (allowed) {
        a->state = next;
        a->output = y;
        a->time = from + length;
    }
}

/* States: kept, brought back, freed, written and read. */
static void states(void *c, Account *a)
{
    static char bytes[sizeof(Course) + 8u];
    const unsigned int j = drawn(KEPT);
    const int with = kept[j] != NULL;
    const int whole = with && (c != NULL);
    size_t size = 0;
    switch (drawn(8)) {
    case 0:
    case 1:
        expect_status((int)KEEP(c, &kept[j]), c != NULL, 3, "keep");
        kept_accounts[j] = (c != NULL) ? *a : kept_accounts[j];
        break;
    case 2: expect_status((int)KEEP(c, NULL), 0, 3, "keep"); break;
    case 3:
    case 4: {
        const int sound = whole && kept_accounts[j].phase != 0;
        const int status = (int)BRING(c, kept[j]);
        expect_status(status, sound, 4, "bring");
        if (status == 0) {
            *a = kept_accounts[j];
        }
        break;
    }
    case 5:
        expect_status((int)DROP(c, (drawn(4) == 0u) ? NULL : &kept[j]), c != NULL, 5, "free a state");
        break;
    case 6:
        expect_status((int)SIZE(c, kept[j], &size), whole, 6, "size");
        check(!whole || (size == sizeof(Course)), "size", "another size");
        expect_status((int)SIZE(c, kept[j], NULL), 0, 6, "size");
        break;
    default: {
        const unsigned int damage = drawn(6);
        const unsigned int i = drawn(KEPT);
        expect_status((int)WRITE(c, kept[j], NULL, sizeof(Course)), 0, 7, "write");
        expect_status((int)WRITE(c, kept[j], (void *)bytes, sizeof(Course) - 1u), 0, 7, "write");
        expect_status((int)WRITE(c, kept[j], (void *)bytes, sizeof(bytes)), whole, 7, "write");
        if (whole) {
            Course course;
            memcpy(&course, bytes, sizeof(Course));
            course.phase = (damage == 1u) ? (Phase)(int)(3u + 13u * drawn(2)) : course.phase;
            course.input[0] = (damage == 2u) ? (double)NAN : course.input[0];
            *place(&course.state, 0) = (damage == 3u) ? (number)HUGE_VAL : *place(&course.state, 0);
            memcpy(bytes, &course, sizeof(Course));
            bytes[3] ^= (damage == 4u) ? 1 : 0;
            const size_t given = sizeof(Course) - ((damage == 5u) ? 1u + drawn(sizeof(Course)) : 0u);
            expect_status((int)READ(c, (drawn(20) == 0u) ? NULL : (void *)bytes, given, NULL), 0, 8, "read");
            expect_status((int)READ(c, (void *)bytes, given, &kept[i]), damage == 0u, 8, "read");
            if (damage == 0u) {
                kept_accounts[i] = kept_accounts[j];
            }
        }
        break;
    }
    }
}

static void others(void *c)
{
    static const char *const categories[] = {"logStatusError", "logEvents", "nonsense", NULL};
    const unsigned int k = drawn(4);
    const unsigned int one = INPUT;
    switch (drawn(4)) {
    case 0:
        expect_status((int)V(SetDebugLogging)(c, drawn(2) == 0u, 1, &categories[k]), (c != NULL) && (k < 2u), 9, "logging");
        break;
    case 1: expect_status((int)V(SetDebugLogging)(c, drawn(2) == 0u, 0, NULL), c != NULL, 9, "logging"); break;
    case 2: expect_status((int)V(SetDebugLogging)(c, 1, (size_t)-1, NULL), 0, 9, "logging"); break;
    default: {
#if VERSION == 2
        expect_status((int)fmi2GetInteger(c, NULL, 0, NULL), c != NULL, 10, "integers");
        expect_status((int)fmi2SetBoolean(c, &one, 1, NULL), 0, 10, "booleans");
        expect_status((int)fmi2CancelStep(c), 0, 11, "cancel");
        expect_status((int)fmi2GetRealStatus(c, fmi2LastSuccessfulTime, NULL), 0, 11, "status");
        expect_status((int)fmi2GetDirectionalDerivative(c, NULL, 0, NULL, 0, NULL, NULL), 0, 11, "derivative");
#else
        double v = 0.0;
        expect_status((int)fmi3GetInt32(c, NULL, 0, NULL, 0), c != NULL, 10, "integers");
        expect_status((int)fmi3SetString(c, &one, 1, NULL, 1), 0, 10, "strings");
        expect_status((int)fmi3GetFloat64(c, &one, 1, &v, 2), 0, 11, "more values than variables");
        expect_status((int)fmi3SetFloat64(c, &one, 1, &v, 0), 0, 11, "fewer values than variables");
        expect_status((int)fmi3EnterEventMode(c), 0, 11, "event mode");
#endif
        break;
    }
    }
}

/* Calls that move from state to state. */
static void life(void *c, Account *a)
{
    const int there = c != NULL;
    const double start = (drawn(6) == 0u) ? any_value() : 0.25;
    switch (drawn(5)) {
#if VERSION == 2
    case 0: {
        const int allowed = there && (a->phase == 1) && finite_number(start);
        expect_status((int)fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0), allowed, 12, "set up");
        a->time = allowed ? start : a->time;
        break;
    }
#endif
    case 1:
    default: {
        const int allowed = there && (a->phase == 1) && ((VERSION == 2) ? !isnan(start) : finite_number(start));
        expect_status(ENTER(c, start), allowed, 13, "enter the initialisation");
        if (allowed) {
            a->time = (VERSION == 2) ? a->time : start;
            a->phase = 2;
        }
        break;
    }
    case 2: {
        const double y = there ? expected_output(a) : 0.0;
        const int allowed = there && (a->phase == 2) && finite_number(y);
        expect_status((int)V(ExitInitializationMode)(c), allowed, 14, "exit the initialisation");
        if (allowed) {
            a->output = y;
            a->phase = 4;
        }
        break;
    }
    case 3: {
        const int now = drawn(20) == 0u;
        const int allowed = there && (a->phase == 4);
        if (now) {
            expect_status((int)V(Terminate)(c), allowed, 15, "terminate");
            a->phase = allowed ? 8 : a->phase;
        }
        break;
    }
    case 4:
        if ((drawn(10) == 0u) || (there && (a->phase == 8))) {
            expect_status((int)V(Reset)(c), there, 16, "reset");
            if (there) {
                restart(a);
            }
        }
        break;
    }
}

int main(void)
{
    Account nobody;
    V(FreeInstance)(NULL);
    for (call_number = 0; call_number < CALLS; call_number++) {
        const unsigned int k = drawn(INSTANCES);
        const int without = drawn(50) == 0u;
        restart(&nobody);
        if (instances[k] == NULL) {
            create_one((int)k);
            continue;
        }
        void *c = without ? NULL : instances[k];
        Account *a = without ? &nobody : &accounts[k];
        switch (drawn(10)) {
        case 0: life(c, a); break;
        case 1:
        case 2: set_some(c, a); break;
        case 3:
        case 4: get_some(c, a); break;
        case 5: states(c, a); break;
        case 6: others(c); break;
        case 7:
            if (drawn(200) == 0u) {
                V(FreeInstance)(c);
                instances[k] = without ? instances[k] : NULL;
            }
            break;
        default: step_some(c, a); break;
        }
    }
    /* A state outlives the instance that it is of. */
    void *last = NULL;
    while (last == NULL) {
        last = create("last", TOKEN, 0, 2);
    }
    for (int j = 0; j < KEPT; j++) {
        check((int)DROP(last, &kept[j]) == 0, "free a state", "refused");
    }
    V(FreeInstance)(last);
    for (int k = 0; k < INSTANCES; k++) {
        V(FreeInstance)(instances[k]);
    }
    for (int what = 0; what < 17; what++) {
        const int both = (what != 11) && ((VERSION == 2) || (what != 12));
        check(!both || ((done_calls[what][0] > 5) && (done_calls[what][1] > 5)), "account", "a kind of call was hardly tried");
    }
    printf("%d calls, %d steps done, %d refused\n", CALLS, done_calls[2][1], done_calls[2][0]);
    return 0;
}
