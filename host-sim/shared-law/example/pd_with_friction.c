/* PD, and a friction compensation that is smooth around the target.
 *
 *   effort = Kp e + Kd (w_d - w) + F tanh(e / (2 counts))
 *
 * Kp and Kd put the nominal joint at 8 Hz, or at 0.1 / h of a slow loop, with a damping ratio of
 * 0.9; F is the geometric middle of the bounds of the breakaway effort.
 *
 *   cc -O2 -shared -fPIC -I.. pd_with_friction.c -lm -o pd_with_friction.so
 */
#include <math.h>
#include <stdlib.h>

#include "stiction_law.h"

typedef struct {
    double kp, kd, friction, width;
} Law;

/* The tests build it with another version, and without the compensation. */
#ifndef STICTION_LAW_ABI_OF_TEST
#define STICTION_LAW_ABI_OF_TEST STICTION_LAW_ABI
#endif

uint32_t stiction_law_abi(void) { return STICTION_LAW_ABI_OF_TEST; }

const char *stiction_law_name(void) { return "pd-with-friction"; }

const char *stiction_law_version(void) { return "1"; }

void *stiction_law_start(const StictionLawJoint *joint) {
    const double natural = fmin(2.0 * 3.14159265358979 * 8.0, 0.1 / joint->sample_time);
    const double damping = 0.9;
    Law *law = malloc(sizeof *law);
    if (law) {
        const double kd = 2.0 * damping * joint->inertia * natural - joint->viscous;
        law->kp = joint->inertia * natural * natural;
        law->kd = kd > 0.0 ? kd : 0.0;
#ifdef PD_ALONE
        law->friction = 0.0;
#else
        law->friction = sqrt(joint->breakaway_low * joint->breakaway_high);
#endif
        law->width = 2.0 * joint->count;
    }
    return law;
}

double stiction_law_tick(void *controller, const StictionLawSample *sample) {
    const Law *law = controller;
    return law->kp * sample->error + law->kd * (sample->target_velocity - sample->velocity) +
           law->friction * tanh(sample->error / law->width);
}

void stiction_law_end(void *controller) { free(controller); }
