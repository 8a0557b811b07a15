/* joint.h: a piezo actuator (model, feed-forward, controller) identified by piezoid.
   One call of a step function is one sample of 0.0005 s. */
#ifndef JOINT_H
#define JOINT_H

#define JOINT_SET 0x713F4687u /* checksum of the files of this export */

#define JOINT_TS 0.0005 /* sampling period [s] */

#ifdef __cplusplus
extern "C" {
#endif

/* State of preisach: relays on a triangular grid: asymmetric loops of any shape, minor loops, wiping-out. */
typedef struct {
    double count;
    double last;
    double sum;
    double reversal[128];
} joint_hysteresis_state;

/* State of the driver: an amplifier with a lag and a slew limit. */
typedef struct {
    double v;
    double z;
} joint_driver_state;

/* State of the linear block: a difference equation. */
typedef struct {
    double outputs[2];
    double inputs[3];
} joint_linear_state;

/* State of the model: hysteresis, creep, linear dynamics, offset. */
typedef struct {
    joint_hysteresis_state hysteresis;
    joint_linear_state linear;
    joint_driver_state driver;
    double taken;
} joint_state;

/* State of the inverse of the linear block: an FIR filter. */
typedef struct {
    double past[47];
} joint_preview_state;

/* State of the feed-forward: the inverses of linear dynamics, creep and hysteresis. */
typedef struct {
    joint_preview_state preview;
    joint_hysteresis_state hysteresis;
    joint_driver_state driver;
} joint_ff_state;

/* Resets the state to rest. */
void joint_reset(joint_state *s);

/* One sample of the model: input to displacement.
   u [V]: actuator input
   Returns y [um]: displacement.
   Operations in one call: at most 578 in the self-test, at most 2951 for every input.
   Of these at most 698 additions, 398 multiplications, 21 divisions and 1834 comparisons. */
double joint_step(joint_state *s, double u);

/* The same without advancing: *next is the state after the sample. Once the hardware has acknowledged it, s = next. */
double joint_plan(const joint_state *s, double u, joint_state *next);

#define JOINT_SAVED 141 /* numbers of a saved state */

/* Writes the state as numbers, with a checksum of what computes with it. */
void joint_save(const joint_state *s, double saved[JOINT_SAVED]);

/* Reads a saved state of n numbers. Returns 1, or 0 for the state of another export: s then stays. */
int joint_restore(joint_state *s, const double saved[], int n);

/* Resets the state to rest. */
void joint_ff_reset(joint_ff_state *s);

/* One sample of the feed-forward: requested displacement to actuator voltage.
   r [um]: wanted displacement
   Returns u [V]: actuator input.
   Operations in one call: at most 5213 in the self-test, at most 367572 for every input.
   Of these at most 87605 additions, 49118 multiplications, 3559 divisions and 227290 comparisons. */
double joint_ff_step(joint_ff_state *s, double r);

/* The same without advancing: *next is the state after the sample. Once the hardware has acknowledged it, s = next. */
double joint_ff_plan(const joint_ff_state *s, double r, joint_ff_state *next);

#define JOINT_FF_SAVED 182 /* numbers of a saved state */

/* Writes the state as numbers, with a checksum of what computes with it. */
void joint_ff_save(const joint_ff_state *s, double saved[JOINT_FF_SAVED]);

/* Reads a saved state of n numbers. Returns 1, or 0 for the state of another export: s then stays. */
int joint_ff_restore(joint_ff_state *s, const double saved[], int n);

#ifdef __cplusplus
}
#endif

#endif
