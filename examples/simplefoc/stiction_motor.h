/* SimpleFOC's custom motion control by stiction. `move()` must run at the sample time of the
 * configuration: the law counts ticks, and has no clock. */
#ifndef STICTION_MOTOR_H
#define STICTION_MOTOR_H

#include <math.h>

#include "stiction.h"

/* Returns the voltage (or current) of a tick, for the target of the motor, rad, and its
 * feed_forward_velocity, rad/s. */
static inline float stiction_motor(FOCMotor *motor, Stiction *stiction, double counts_per_rad) {
    const double angle = (double)motor->sensor_direction * motor->sensor->getPreciseAngle() -
                         (double)motor->sensor_offset;
    StictionTarget target;
    stiction_target(stiction, motor->target, &target);
    target.velocity = motor->feed_forward_velocity;
    return stiction_follow(stiction, (int32_t)lround(angle * counts_per_rad), &target);
}

#endif
