/* A law of your own for stiction's ensembles: build a shared library with these functions, and pass
 * it as `--law FILE`. docs/how-to/own-law.md has an example.
 *
 * Angles are in rad, times in s. The effort is in the unit of the joint's drive: every figure of
 * effort has it. Different joints run on different threads; each has a controller of its own.
 */
#ifndef STICTION_LAW_H
#define STICTION_LAW_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of these functions. */
#define STICTION_LAW_ABI 2

/* A joint as the built-in laws know it: the nominal joint and bounds of its friction. */
typedef struct {
    double sample_time;     /* between two ticks, s */
    double count;           /* angle of a count, rad */
    double largest_effort;
    double effort_step;
    double inertia;         /* nominal, effort s^2/rad */
    double viscous;         /* nominal, effort s/rad */
    double breakaway_low;   /* bounds of the breakaway effort */
    double breakaway_high;
    double load;            /* largest load that drives the joint; 0: none does */
    double hold_effort;     /* holds the load where the joint is armed, within 20 % */
    double jitter;          /* counts by which the encoder changes at rest */
    bool encoder_at_load;
} StictionLawJoint;

/* One tick. */
typedef struct {
    int32_t counts;
    bool saturated;             /* whether the last effort was limited */
    double target_counts;       /* set point, with a fraction */
    double error;               /* set point minus position, rad */
    double velocity;            /* measured, rad/s */
    double target_velocity;     /* rad/s */
    double target_acceleration; /* rad/s^2 */
    double applied;             /* effort since the last tick, as the joint had it */
} StictionLawSample;

/* Returns STICTION_LAW_ABI. */
uint32_t stiction_law_abi(void);

/* Name in tables and rows, and version; both live as long as the library. */
const char *stiction_law_name(void);
const char *stiction_law_version(void);

/* Makes the controller of a joint at rest; null if it cannot. */
void *stiction_law_start(const StictionLawJoint *joint);

/* Returns the effort of a tick. */
double stiction_law_tick(void *controller, const StictionLawSample *sample);

/* Optional, for a law that follows a path of its own: returns the following error that is a fault
 * on a joint, rad. Without it, or with 0, the joint has that of PD. */
double stiction_law_following_error(const StictionLawJoint *joint);

/* Ends a controller. */
void stiction_law_end(void *controller);

#ifdef __cplusplus
}
#endif

#endif
