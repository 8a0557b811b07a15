/* Runs the S-function that is named as Simulink's engine does, in two blocks of which the second is a sample behind the first, and in a
   third that takes up the saved state of the first halfway. Reads samples as doubles, the inputs of each together; writes the outputs;
   1 if anything is off. */
#include "simstruc.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_SAMPLES 1000

/* All that there are, from a list of S_FUNCTION(name). */
#define S_FUNCTION(name) extern const Methods name##_methods;
#include "all.h"
#undef S_FUNCTION
#define S_FUNCTION(name) {#name, &name##_methods},
static const struct {
    const char *name;
    const Methods *methods;
} all[] = {
#include "all.h"
};
static const Methods *methods;

typedef struct {
    SimStruct S;
    real_T given[MOST_PORTS], gives;
} Instance;

static int wrong = 0;

static void expect(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "not so: %s\n", what);
        wrong = 1;
    }
}

static size_t bytes(const SimStruct *S)
{
    return (size_t)S->work.width * (S->work.type == SS_SINGLE ? sizeof(float) : sizeof(double));
}

static void begin(Instance *b)
{
    SimStruct *S = &b->S;
    memset(b, 0, sizeof *b);
    methods->sizes(S);
    expect(S->outputs == 1 && S->works == 1 && S->times == 1, "one output, one state, one sample time");
    expect(S->output[0].width == 1 && S->output[0].type == SS_DOUBLE, "the output is a double");
    expect(S->work.width > 0 && S->work.usage == SS_DWORK_USED_AS_DSTATE, "there is a state, and it is a discrete one");
    expect(S->sim_state == USE_DEFAULT_SIM_STATE, "the state is saved by Simulink");
    S->output[0].signal = &b->gives;
    for (int k = 0; k < S->inputs; k++) {
        expect(S->input[k].width == 1 && S->input[k].type == SS_DOUBLE && S->input[k].contiguous, "inputs are doubles");
        S->input[k].signal = &b->given[k];
    }
    methods->sample_times(S);
    expect(S->offset == 0.0, "samples begin at 0");
    S->work.memory = malloc(bytes(S));
    memset(S->work.memory, 0x55, bytes(S));
    methods->conditions(S);
}

/* One sample: outputs are asked for twice, as in an algebraic loop, and without inputs where these do not matter. */
static real_T sample(Instance *b, const real_T *given)
{
    real_T first;
    for (int k = 0; k < b->S.inputs; k++) {
        b->given[k] = b->S.input[k].feedthrough ? given[k] : (real_T)NAN;
    }
    methods->outputs(&b->S, 0);
    first = b->gives;
    methods->outputs(&b->S, 0);
    expect(first == b->gives, "asking changes nothing");
    memcpy(b->given, given, sizeof(real_T) * (size_t)b->S.inputs);
    methods->update(&b->S, 0);
    return first;
}

int main(int count, char **words)
{
    static real_T given[MOST_SAMPLES * MOST_PORTS], gives[MOST_SAMPLES];
    static Instance first, second, third;
    size_t n, inputs;
    for (size_t k = 0; count == 2 && k < sizeof all / sizeof *all; k++) {
        if (strcmp(all[k].name, words[1]) == 0) {
            methods = all[k].methods;
        }
    }
    if (methods == NULL) {
        fprintf(stderr, "no S-function is named so\n");
        return 1;
    }
    begin(&first);
    begin(&second);
    begin(&third);
    inputs = (size_t)first.S.inputs;
    n = fread(given, sizeof(real_T) * inputs, MOST_SAMPLES, stdin);
    for (size_t k = 0; k < n; k++) {
        gives[k] = sample(&first, &given[k * inputs]);
        if (k > 0) {
            expect(sample(&second, &given[(k - 1) * inputs]) == gives[k - 1], "blocks do not disturb each other");
        }
        if (k > n / 2) {
            expect(sample(&third, &given[k * inputs]) == gives[k], "a saved state goes on");
        }
        if (k == n / 2) {
            memcpy(third.S.work.memory, first.S.work.memory, bytes(&first.S));
        }
    }
    methods->conditions(&first.S);
    expect(n > 0 && sample(&first, given) == gives[0], "a reset begins anew");
    methods->terminate(&first.S);
    methods->terminate(&second.S);
    methods->terminate(&third.S);
    free(first.S.work.memory);
    free(second.S.work.memory);
    free(third.S.work.memory);
    fwrite(gives, sizeof(real_T), n, stdout);
    fprintf(stderr, "Ts %.17g, feedthrough %d\n", first.S.sample_time, first.S.input[0].feedthrough);
    return wrong;
}
