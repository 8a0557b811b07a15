/* What exported C does with inputs that no sensor should give, counted for one function of one model.

   It is included once for every function, after the self-test of the model, with
     ENTRY        its name                  NUMBER, LARGEST   the type of its numbers, and the largest of them
     STATE, RESET, SAVE, RESTORE, SAVED     its state         SAMPLES, GIVES   the vectors of the self-test
     CALL(s, k)   a sample of the vectors, each input through `wild`
     ROUNDS       how often they lead back to the usual outputs
     FARTHEST     the largest input that the model takes; 0 for a feed-forward or a controller

   The functions under test may be compiled with other options than this file, which must know a NaN when it sees one. */
#ifndef STRESS_COMMON
#define STRESS_COMMON
#include <float.h>
#include <math.h>
#include <string.h>

static unsigned int stress_random;
static int stress_on;
static int stress_kind;
static NUMBER stress_taken;

/* The value itself, or something else in its place. */
static NUMBER wild(NUMBER v)
{
    static const double others[] = {NAN, -NAN, HUGE_VAL, -HUGE_VAL, LARGEST, -LARGEST, 1e30, -1e30, 1e15, -1e15, 1e-40, -1e-40,
                                    LARGEST / 3.0, 0.0, -0.0, 1e-310, 100.0, -1000.0};
    const int n = (int)(sizeof(others) / sizeof(others[0]));
    NUMBER given = v;
    if (stress_on) {
        stress_random = (stress_random * 1664525u) + 1013904223u;
        stress_kind = (int)((stress_random >> 12) % (3u * (unsigned int)n));
        given = (stress_kind < n) ? (NUMBER)others[stress_kind] : v;
    }
    stress_taken = given;
    return given;
}

static int is_finite_number(NUMBER v)
{
    return ((double)v >= -LARGEST) && ((double)v <= LARGEST);
}
#endif

#define JOINED(a, b) a##b
#define FUNCTION(a, b) JOINED(a, b)

static int FUNCTION(ENTRY, _stressed)(void)
{
    STATE s;
    STATE other;
    NUMBER saved[SAVED];
    NUMBER last = 0;
    NUMBER low = GIVES[0];
    NUMBER high = GIVES[0];
    int infinite = 0;
    int held = 0;
    int forgotten = 0;
    int refused = 0;
    double most = 0.0;
    double off = 0.0;
    RESET(&s);
    RESET(&other);
    stress_random = 1u;
    /* Anything goes in, finite numbers come out; the model behaves as if the last input had come again. */
    for (int k = 0; k < 5 * SAMPLES; k++) {
        stress_on = 1;
        const NUMBER y = CALL(&s, k % SAMPLES);
        stress_on = 0;
        infinite += !is_finite_number(y);
        if (FARTHEST > 0.0) {
            last = (fabs((double)stress_taken) <= FARTHEST) ? stress_taken : last;
            const NUMBER again = STEP(&other, last);
            held += memcmp(&y, &again, sizeof(y)) != 0;
        }
    }
    /* States are saved as they are, and a NaN among the numbers is not taken. */
    SAVE(&s, saved);
    other = s;
    for (int k = 0; k < SAMPLES; k++) {
        (void)CALL(&s, k);
    }
    refused += RESTORE(&s, saved, SAVED) != 1;
    refused += memcmp(&s, &other, sizeof(s)) != 0;
    saved[SAVED - 1] = (NUMBER)NAN;
    refused += RESTORE(&other, saved, SAVED) != 0;
    /* A reset forgets all of it. */
    RESET(&other);
    for (int k = 0; k < SAMPLES; k++) {
        const NUMBER y = CALL(&other, k);
        const double from = fabs((double)y - (double)GIVES[k]);
        forgotten += memcmp(&y, &GIVES[k], sizeof(y)) != 0;
        most = (from <= most) ? most : from;
        low = (y < low) ? y : low;
        high = (y > high) ? y : high;
    }
    /* Without a reset the usual inputs lead back to the usual outputs. */
    for (int k = 0; k < ROUNDS * SAMPLES; k++) {
        const double y = (double)CALL(&s, k % SAMPLES);
        const double usual = (double)CALL(&other, k % SAMPLES);
        if (k >= (ROUNDS - 1) * SAMPLES) {
            off = (fabs(y - usual) <= off) ? off : fabs(y - usual);
        }
    }
    printf("stressed %s %d %d %d %d %.1e %.1e\n", NAME, infinite, held, refused, forgotten,
           most / ((double)high - (double)low), off / ((double)high - (double)low));
    return infinite + held + refused + forgotten;
}

#undef JOINED
#undef FUNCTION
