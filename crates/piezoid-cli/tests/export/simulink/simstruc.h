/* Stands in for the header of Simulink: what exported S-functions use of it, behaving as MathWorks document it. */
#ifndef SIMSTRUC_H
#define SIMSTRUC_H

#include <stddef.h>

typedef double real_T;
typedef int int_T;

enum { SS_DOUBLE, SS_SINGLE };
enum { COMPLEX_NO, COMPLEX_YES };
enum { SS_DWORK_USED_AS_DWORK, SS_DWORK_USED_AS_DSTATE };
enum { UNKNOWN_SIM_STATE, USE_DEFAULT_SIM_STATE };
#define SS_OPTION_EXCEPTION_FREE_CODE 1U
#define SS_OPTION_WORKS_WITH_CODE_REUSE 2U
#define UNUSED_ARG(arg) (void)(arg)

#define MOST_PORTS 4

typedef struct {
    int_T width, type, complex, contiguous, feedthrough;
    real_T *signal;
} Port;

typedef struct {
    int_T parameters, inputs, outputs, works, times, sim_state;
    unsigned options;
    real_T sample_time, offset;
    Port input[MOST_PORTS], output[1];
    struct {
        const char *name;
        int_T width, type, complex, usage;
        void *memory;
    } work;
} SimStruct;

/* Ports are unknown until they are set: dynamically sized, with direct feedthrough off. */
#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) 0
#define ssSetNumInputPorts(S, n) ((n) <= MOST_PORTS ? ((S)->inputs = (n), 1) : 0)
#define ssSetNumOutputPorts(S, n) ((n) <= 1 ? ((S)->outputs = (n), 1) : 0)
#define ssSetInputPortWidth(S, k, w) ((S)->input[k].width = (w))
#define ssSetInputPortDataType(S, k, t) ((S)->input[k].type = (t))
#define ssSetInputPortComplexSignal(S, k, c) ((S)->input[k].complex = (c))
#define ssSetInputPortRequiredContiguous(S, k, c) ((S)->input[k].contiguous = (c))
#define ssSetInputPortDirectFeedThrough(S, k, d) ((S)->input[k].feedthrough = (d))
#define ssSetOutputPortWidth(S, k, w) ((S)->output[k].width = (w))
#define ssSetOutputPortDataType(S, k, t) ((S)->output[k].type = (t))
#define ssSetOutputPortComplexSignal(S, k, c) ((S)->output[k].complex = (c))
#define ssSetNumDWork(S, n) ((n) == 1 ? ((S)->works = 1, 1) : 0)
#define ssSetDWorkName(S, k, n) ((S)->work.name = (n))
#define ssSetDWorkWidth(S, k, w) ((S)->work.width = (w))
#define ssSetDWorkDataType(S, k, t) ((S)->work.type = (t))
#define ssSetDWorkComplexSignal(S, k, c) ((S)->work.complex = (c))
#define ssSetDWorkUsageType(S, k, u) ((S)->work.usage = (u))
#define ssGetDWork(S, k) ((S)->work.memory)
#define ssSetSimStateCompliance(S, c) ((S)->sim_state = (c))
#define ssSetNumSampleTimes(S, n) ((S)->times = (n))
#define ssSetOptions(S, o) ((S)->options = (o))
#define ssSetSampleTime(S, k, t) ((S)->sample_time = (t))
#define ssSetOffsetTime(S, k, t) ((S)->offset = (t))
/* Only what is contiguous is one array; what has no direct feedthrough is not there while outputs are asked for. */
#define ssGetInputPortRealSignal(S, k) ((const real_T *)((S)->input[k].contiguous ? (S)->input[k].signal : NULL))
#define ssGetOutputPortRealSignal(S, k) ((S)->output[k].signal)

typedef struct {
    void (*sizes)(SimStruct *S);
    void (*sample_times)(SimStruct *S);
    void (*conditions)(SimStruct *S);
    void (*outputs)(SimStruct *S, int_T tid);
    void (*update)(SimStruct *S, int_T tid);
    void (*terminate)(SimStruct *S);
} Methods;

extern const Methods s_function;

#endif
