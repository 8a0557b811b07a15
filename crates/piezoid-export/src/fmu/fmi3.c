/* FMI 3.0: its types and functions, see https://fmi-standard.org */

#ifdef FMI3_FUNCTION_PREFIX
#define FMI(name) JOINED(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

#include <stdbool.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;

typedef void (*Logger)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*ClockUpdate)(fmi3InstanceEnvironment);
typedef void (*IntermediateUpdate)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                   fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*Lock)(void);

static void tell(const Instance *m, int status, const char *category, const char *text)
{
    if (m->logger != NULL) {
        ((Logger)m->logger)(m->environment, (fmi3Status)status, category, text);
    }
}

EXPORT const char *FMI(fmi3GetVersion)(void)
{
    return "3.0";
}

EXPORT fmi3Status FMI(fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean loggingOn, size_t n,
                                           const fmi3String categories[])
{
    return (fmi3Status)set_logging(instance, "fmi3SetDebugLogging", loggingOn, n, categories, ALL);
}

EXPORT fmi3Instance FMI(fmi3InstantiateCoSimulation)(fmi3String instanceName, fmi3String token, fmi3String resourcePath,
                                                     fmi3Boolean visible, fmi3Boolean loggingOn,
                                                     fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                                     const fmi3ValueReference intermediate[], size_t nIntermediate,
                                                     fmi3InstanceEnvironment environment, Logger logMessage,
                                                     IntermediateUpdate intermediateUpdate)
{
    fmi3Instance made = NULL;
    const char *name = (instanceName != NULL) ? instanceName : "";
    const char *why = NULL;
    (void)resourcePath;
    (void)visible;
    (void)earlyReturnAllowed;
    (void)intermediate;
    (void)nIntermediate;
    (void)intermediateUpdate;
    if (name[0] == '\0') {
        why = "fmi3InstantiateCoSimulation: the instance has no name: give it one";
    } else if (eventModeUsed) {
        why = "fmi3InstantiateCoSimulation: this FMU has no event mode: set eventModeUsed to false";
    } else if ((token == NULL) || (strcmp(token, TOKEN) != 0)) {
        why = "fmi3InstantiateCoSimulation: the token does not match this binary: use the modelDescription.xml of the "
              "same FMU";
    } else {
        made = instance(name, loggingOn ? ALL : NOTHING, environment, (void (*)(void))logMessage);
        why = (made == NULL) ? "fmi3InstantiateCoSimulation: there is no memory left" : NULL;
    }
    if ((why != NULL) && loggingOn && (logMessage != NULL)) {
        logMessage(environment, fmi3Error, error_category, why);
    }
    return made;
}

/* Of a kind that this FMU is not. */
static fmi3Instance not_made(fmi3Boolean loggingOn, fmi3InstanceEnvironment environment, Logger logMessage)
{
    if (loggingOn && (logMessage != NULL)) {
        logMessage(environment, fmi3Error, error_category,
                   "this FMU is for co-simulation alone: call fmi3InstantiateCoSimulation");
    }
    return NULL;
}

EXPORT fmi3Instance FMI(fmi3InstantiateModelExchange)(fmi3String instanceName, fmi3String token,
                                                      fmi3String resourcePath, fmi3Boolean visible,
                                                      fmi3Boolean loggingOn, fmi3InstanceEnvironment environment,
                                                      Logger logMessage)
{
    (void)instanceName;
    (void)token;
    (void)resourcePath;
    (void)visible;
    return not_made(loggingOn, environment, logMessage);
}

EXPORT fmi3Instance FMI(fmi3InstantiateScheduledExecution)(fmi3String instanceName, fmi3String token,
                                                           fmi3String resourcePath, fmi3Boolean visible,
                                                           fmi3Boolean loggingOn, fmi3InstanceEnvironment environment,
                                                           Logger logMessage, ClockUpdate clockUpdate,
                                                           Lock lockPreemption, Lock unlockPreemption)
{
    (void)instanceName;
    (void)token;
    (void)resourcePath;
    (void)visible;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    return not_made(loggingOn, environment, logMessage);
}

EXPORT void FMI(fmi3FreeInstance)(fmi3Instance instance)
{
    free(instance);
}

EXPORT fmi3Status FMI(fmi3EnterInitializationMode)(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                                   fmi3Float64 tolerance, fmi3Float64 startTime,
                                                   fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    return (fmi3Status)enter_initialisation(instance, "fmi3EnterInitializationMode", startTime);
}

EXPORT fmi3Status FMI(fmi3ExitInitializationMode)(fmi3Instance instance)
{
    return (fmi3Status)exit_initialisation(instance, "fmi3ExitInitializationMode");
}

EXPORT fmi3Status FMI(fmi3Terminate)(fmi3Instance instance)
{
    return (fmi3Status)terminate(instance, "fmi3Terminate");
}

EXPORT fmi3Status FMI(fmi3Reset)(fmi3Instance instance)
{
    return (fmi3Status)reset(instance, "fmi3Reset");
}

/* Steps */

EXPORT fmi3Status FMI(fmi3DoStep)(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                                  fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                  fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                                  fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    const Instance *m = instance;
    const fmi3Status status =
        (fmi3Status)step(instance, "fmi3DoStep", currentCommunicationPoint, communicationStepSize);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (eventHandlingNeeded != NULL) {
        *eventHandlingNeeded = false;
    }
    if (terminateSimulation != NULL) {
        *terminateSimulation = false;
    }
    if (earlyReturn != NULL) {
        *earlyReturn = false;
    }
    if ((lastSuccessfulTime != NULL) && (m != NULL)) {
        *lastSuccessfulTime = m->now.time;
    }
    return status;
}

/* Values */

EXPORT fmi3Status FMI(fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                      fmi3Float64 values[], size_t nValues)
{
    int status = REFUSED;
    if (nValues == n) {
        status = get_reals(instance, "fmi3GetFloat64", vr, n, values);
    } else {
        status = refuse(instance, "fmi3GetFloat64", "there must be as many values as variables");
    }
    return (fmi3Status)status;
}

EXPORT fmi3Status FMI(fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                      const fmi3Float64 values[], size_t nValues)
{
    int status = REFUSED;
    if (nValues == n) {
        status = set_reals(instance, "fmi3SetFloat64", vr, n, values);
    } else {
        status = refuse(instance, "fmi3SetFloat64", "there must be as many values as variables");
    }
    return (fmi3Status)status;
}

#define NO_VARIABLES(type)                                                                                             \
    EXPORT fmi3Status FMI(fmi3Get##type)(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,               \
                                         fmi3##type values[], size_t nValues)                                          \
    {                                                                                                                  \
        (void)vr;                                                                                                      \
        (void)values;                                                                                                  \
        (void)nValues;                                                                                                 \
        return (fmi3Status)no_variables(instance, "fmi3Get" #type, n);                                                 \
    }                                                                                                                  \
    EXPORT fmi3Status FMI(fmi3Set##type)(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,               \
                                         const fmi3##type values[], size_t nValues)                                    \
    {                                                                                                                  \
        (void)vr;                                                                                                      \
        (void)values;                                                                                                  \
        (void)nValues;                                                                                                 \
        return (fmi3Status)no_variables(instance, "fmi3Set" #type, n);                                                 \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

/* The state of the FMU as a whole */

EXPORT fmi3Status FMI(fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    return (fmi3Status)get_whole(instance, "fmi3GetFMUState", state);
}

EXPORT fmi3Status FMI(fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state)
{
    return (fmi3Status)set_whole(instance, "fmi3SetFMUState", state);
}

EXPORT fmi3Status FMI(fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    return (fmi3Status)free_whole(instance, "fmi3FreeFMUState", state);
}

EXPORT fmi3Status FMI(fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    return (fmi3Status)state_size(instance, "fmi3SerializedFMUStateSize", state, size);
}

EXPORT fmi3Status FMI(fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return (fmi3Status)serialise(instance, "fmi3SerializeFMUState", state, bytes, size);
}

EXPORT fmi3Status FMI(fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                               fmi3FMUState *state)
{
    return (fmi3Status)deserialise(instance, "fmi3DeserializeFMUState", bytes, size, state);
}

/* Values of types that there are none of */

#define NONE_OF(name, parameters, unused)                                                                       \
    EXPORT fmi3Status FMI(name) parameters                                                                      \
    {                                                                                                           \
        unused;                                                                                                 \
        return (fmi3Status)no_variables(instance, #name, n);                                                    \
    }

NONE_OF(fmi3GetBinary,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary values[],
         size_t nValues),
        (void)vr; (void)sizes; (void)values; (void)nValues)
NONE_OF(fmi3SetBinary,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
         const fmi3Binary values[], size_t nValues),
        (void)vr; (void)sizes; (void)values; (void)nValues)
NONE_OF(fmi3GetClock,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]),
        (void)vr; (void)values)
NONE_OF(fmi3SetClock,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]),
        (void)vr; (void)values)
NONE_OF(fmi3GetIntervalDecimal,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 intervals[],
         fmi3IntervalQualifier qualifiers[]),
        (void)vr; (void)intervals; (void)qualifiers)
NONE_OF(fmi3GetIntervalFraction,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
         fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]),
        (void)vr; (void)counters; (void)resolutions; (void)qualifiers)
NONE_OF(fmi3GetShiftDecimal,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 shifts[]),
        (void)vr; (void)shifts)
NONE_OF(fmi3GetShiftFraction,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
         fmi3UInt64 resolutions[]),
        (void)vr; (void)counters; (void)resolutions)
NONE_OF(fmi3SetIntervalDecimal,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 intervals[]),
        (void)vr; (void)intervals)
NONE_OF(fmi3SetIntervalFraction,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[],
         const fmi3UInt64 resolutions[]),
        (void)vr; (void)counters; (void)resolutions)
NONE_OF(fmi3SetShiftDecimal,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 shifts[]),
        (void)vr; (void)shifts)
NONE_OF(fmi3SetShiftFraction,
        (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[],
         const fmi3UInt64 resolutions[]),
        (void)vr; (void)counters; (void)resolutions)

/* What this FMU says it cannot do: further modes, derivatives, and what belongs to model exchange */

#define UNSUPPORTED(name, parameters, unused)                                                                   \
    EXPORT fmi3Status FMI(name) parameters                                                                      \
    {                                                                                                           \
        unused;                                                                                                 \
        return (fmi3Status)refuse(instance, #name, "this FMU has no such function, as its description says");   \
    }

UNSUPPORTED(fmi3EnterEventMode, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3EnterConfigurationMode, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3ExitConfigurationMode, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3EnterStepMode, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3EnterContinuousTimeMode, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3EvaluateDiscreteStates, (fmi3Instance instance), (void)0)
UNSUPPORTED(fmi3UpdateDiscreteStates,
            (fmi3Instance instance, fmi3Boolean *needUpdate, fmi3Boolean *terminate, fmi3Boolean *nominalsChanged,
             fmi3Boolean *valuesChanged, fmi3Boolean *timeDefined, fmi3Float64 *time),
            (void)needUpdate; (void)terminate; (void)nominalsChanged; (void)valuesChanged; (void)timeDefined;
            (void)time)
UNSUPPORTED(fmi3ActivateModelPartition,
            (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time),
            (void)clock; (void)time)
UNSUPPORTED(fmi3GetNumberOfVariableDependencies,
            (fmi3Instance instance, fmi3ValueReference vr, size_t *n),
            (void)vr; (void)n)
UNSUPPORTED(fmi3GetVariableDependencies,
            (fmi3Instance instance, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[],
             size_t ofIndependents[], fmi3DependencyKind kinds[], size_t n),
            (void)dependent; (void)elements; (void)independents; (void)ofIndependents; (void)kinds; (void)n)
UNSUPPORTED(fmi3GetDirectionalDerivative,
            (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
             const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
             fmi3Float64 sensitivity[], size_t nSensitivity),
            (void)unknowns; (void)nUnknowns; (void)knowns; (void)nKnowns; (void)seed; (void)nSeed; (void)sensitivity;
            (void)nSensitivity)
UNSUPPORTED(fmi3GetAdjointDerivative,
            (fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
             const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
             fmi3Float64 sensitivity[], size_t nSensitivity),
            (void)unknowns; (void)nUnknowns; (void)knowns; (void)nKnowns; (void)seed; (void)nSeed; (void)sensitivity;
            (void)nSensitivity)
UNSUPPORTED(fmi3GetOutputDerivatives,
            (fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Int32 orders[],
             fmi3Float64 values[], size_t nValues),
            (void)vr; (void)n; (void)orders; (void)values; (void)nValues)
UNSUPPORTED(fmi3CompletedIntegratorStep,
            (fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
             fmi3Boolean *terminate),
            (void)noSetFMUStatePriorToCurrentPoint; (void)enterEventMode; (void)terminate)
UNSUPPORTED(fmi3SetTime, (fmi3Instance instance, fmi3Float64 time), (void)time)
UNSUPPORTED(fmi3SetContinuousStates,
            (fmi3Instance instance, const fmi3Float64 states[], size_t n),
            (void)states; (void)n)
UNSUPPORTED(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 states[], size_t n), (void)states; (void)n)
UNSUPPORTED(fmi3GetContinuousStateDerivatives,
            (fmi3Instance instance, fmi3Float64 derivatives[], size_t n),
            (void)derivatives; (void)n)
UNSUPPORTED(fmi3GetNominalsOfContinuousStates,
            (fmi3Instance instance, fmi3Float64 nominals[], size_t n),
            (void)nominals; (void)n)
UNSUPPORTED(fmi3GetEventIndicators,
            (fmi3Instance instance, fmi3Float64 indicators[], size_t n),
            (void)indicators; (void)n)
UNSUPPORTED(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *n), (void)n)
UNSUPPORTED(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *n), (void)n)
