/* FMI 2.0: its types and functions, see https://fmi-standard.org */

#ifdef FMI2_FUNCTION_PREFIX
#define FMI(name) JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*Logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

typedef struct {
    Logger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

static void tell(const Instance *m, int status, const char *category, const char *text)
{
    if (m->logger != NULL) {
        ((Logger)m->logger)(m->environment, m->name, (fmi2Status)status, category, text);
    }
}

EXPORT const char *FMI(fmi2GetTypesPlatform)(void)
{
    return "default";
}

EXPORT const char *FMI(fmi2GetVersion)(void)
{
    return "2.0";
}

/* Errors are logged even if debug logging is off; only naming their category switches them off. */
EXPORT fmi2Status FMI(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean loggingOn, size_t n,
                                           const fmi2String categories[])
{
    return (fmi2Status)set_logging(c, "fmi2SetDebugLogging", loggingOn != 0, n, categories,
                                   (loggingOn != 0) ? ALL : EVENTS);
}

EXPORT fmi2Component FMI(fmi2Instantiate)(fmi2String instanceName, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean loggingOn)
{
    fmi2Component made = NULL;
    const char *name = (instanceName != NULL) ? instanceName : "";
    const Logger logger = (functions != NULL) ? functions->logger : NULL;
    fmi2ComponentEnvironment environment = (functions != NULL) ? functions->componentEnvironment : NULL;
    const char *why = NULL;
    (void)resources;
    (void)visible;
    if (name[0] == '\0') {
        why = "fmi2Instantiate: the instance has no name: give it one";
    } else if (type != fmi2CoSimulation) {
        why = "fmi2Instantiate: this FMU supports co-simulation only";
    } else if ((guid == NULL) || (strcmp(guid, TOKEN) != 0)) {
        why = "fmi2Instantiate: the guid does not match this binary: use the modelDescription.xml of the same FMU";
    } else {
        made = instance(name, (loggingOn != 0) ? ALL : ERRORS, environment, (void (*)(void))logger);
        why = (made == NULL) ? "fmi2Instantiate: there is no memory left" : NULL;
    }
    if ((why != NULL) && (logger != NULL)) {
        logger(environment, name, fmi2Error, error_category, why);
    }
    return made;
}

EXPORT void FMI(fmi2FreeInstance)(fmi2Component c)
{
    free(c);
}

EXPORT fmi2Status FMI(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                                           fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    Instance *m = c;
    int status = expect(m, INSTANTIATED, "fmi2SetupExperiment");
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    if ((status == DONE) && !is_number(startTime)) {
        status = refuse(m, "fmi2SetupExperiment", "the start time must be a finite number");
    }
    if (status == DONE) {
        m->now.time = startTime;
    }
    return (fmi2Status)status;
}

EXPORT fmi2Status FMI(fmi2EnterInitializationMode)(fmi2Component c)
{
    Instance *m = c;
    return (fmi2Status)enter_initialisation(m, "fmi2EnterInitializationMode", (m != NULL) ? m->now.time : 0.0);
}

EXPORT fmi2Status FMI(fmi2ExitInitializationMode)(fmi2Component c)
{
    return (fmi2Status)exit_initialisation(c, "fmi2ExitInitializationMode");
}

EXPORT fmi2Status FMI(fmi2Terminate)(fmi2Component c)
{
    return (fmi2Status)terminate(c, "fmi2Terminate");
}

EXPORT fmi2Status FMI(fmi2Reset)(fmi2Component c)
{
    return (fmi2Status)reset(c, "fmi2Reset");
}

/* Values */

EXPORT fmi2Status FMI(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return (fmi2Status)get_reals(c, "fmi2GetReal", vr, n, value);
}

EXPORT fmi2Status FMI(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    return (fmi2Status)set_reals(c, "fmi2SetReal", vr, n, value);
}

#define NO_VARIABLES(type)                                                                                             \
    EXPORT fmi2Status FMI(fmi2Get##type)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##type value[]) \
    {                                                                                                                  \
        (void)vr;                                                                                                      \
        (void)value;                                                                                                   \
        return (fmi2Status)no_variables(c, "fmi2Get" #type, n);                                                        \
    }                                                                                                                  \
    EXPORT fmi2Status FMI(fmi2Set##type)(fmi2Component c, const fmi2ValueReference vr[], size_t n,                     \
                                         const fmi2##type value[])                                                     \
    {                                                                                                                  \
        (void)vr;                                                                                                      \
        (void)value;                                                                                                   \
        return (fmi2Status)no_variables(c, "fmi2Set" #type, n);                                                        \
    }

NO_VARIABLES(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

/* The state of the FMU as a whole */

EXPORT fmi2Status FMI(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    return (fmi2Status)get_whole(c, "fmi2GetFMUstate", state);
}

EXPORT fmi2Status FMI(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    return (fmi2Status)set_whole(c, "fmi2SetFMUstate", state);
}

EXPORT fmi2Status FMI(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    return (fmi2Status)free_whole(c, "fmi2FreeFMUstate", state);
}

EXPORT fmi2Status FMI(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    return (fmi2Status)state_size(c, "fmi2SerializedFMUstateSize", state, size);
}

EXPORT fmi2Status FMI(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return (fmi2Status)serialise(c, "fmi2SerializeFMUstate", state, bytes, size);
}

EXPORT fmi2Status FMI(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *state)
{
    return (fmi2Status)deserialise(c, "fmi2DeSerializeFMUstate", bytes, size, state);
}

/* Steps */

EXPORT fmi2Status FMI(fmi2DoStep)(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                                  fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    return (fmi2Status)step(c, "fmi2DoStep", currentCommunicationPoint, communicationStepSize);
}

EXPORT fmi2Status FMI(fmi2CancelStep)(fmi2Component c)
{
    return (fmi2Status)refuse(c, "fmi2CancelStep", "steps are synchronous: there is no step to cancel");
}

/* What is asked of steps that were not done at once, as all are here. */
static fmi2Status no_status(const Instance *m, const char *call)
{
    (void)refuse(m, call, "this status is not available: steps are synchronous");
    return fmi2Discard;
}

EXPORT fmi2Status FMI(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetStatus");
}

EXPORT fmi2Status FMI(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    const Instance *m = c;
    fmi2Status status = fmi2OK;
    if ((m != NULL) && (value != NULL) && (kind == fmi2LastSuccessfulTime)) {
        *value = m->now.time;
    } else {
        status = no_status(m, "fmi2GetRealStatus");
    }
    return status;
}

EXPORT fmi2Status FMI(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetIntegerStatus");
}

EXPORT fmi2Status FMI(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    fmi2Status status = fmi2OK;
    if ((c != NULL) && (value != NULL) && (kind == fmi2Terminated)) {
        *value = 0;
    } else {
        status = no_status(c, "fmi2GetBooleanStatus");
    }
    return status;
}

EXPORT fmi2Status FMI(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetStringStatus");
}

/* What this FMU says it cannot do */

EXPORT fmi2Status FMI(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                   const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr;
    (void)n;
    (void)order;
    (void)value;
    return (fmi2Status)refuse(c, "fmi2SetRealInputDerivatives",
                              "inputs are held from sample to sample, not interpolated");
}

EXPORT fmi2Status FMI(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                    const fmi2Integer order[], fmi2Real value[])
{
    (void)vr;
    (void)n;
    (void)order;
    (void)value;
    return (fmi2Status)refuse(c, "fmi2GetRealOutputDerivatives", "outputs are samples and have no derivatives");
}

EXPORT fmi2Status FMI(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[],
                                                    size_t nUnknown, const fmi2ValueReference known[], size_t nKnown,
                                                    const fmi2Real change[], fmi2Real derivative[])
{
    (void)unknown;
    (void)nUnknown;
    (void)known;
    (void)nKnown;
    (void)change;
    (void)derivative;
    return (fmi2Status)refuse(c, "fmi2GetDirectionalDerivative", "there are no directional derivatives");
}
