/* stiction: friction-compensating position control for a geared joint.
 *
 * Each struct is owned by the caller; nothing is allocated. A law stops no runaway: put the
 * monitors beside it, and limit current and time outside. Nothing here has run on real hardware.
 *
 * Written by cbindgen from c/src; do not edit. */

#ifndef STICTION_H
#define STICTION_H

#include <stdint.h>

// Done.
#define STICTION_OK 0

// A value is outside its range: see `StictionRefusal`.
#define STICTION_REFUSED 1

// A pointer is null or misaligned.
#define STICTION_BAD_POINTER 2

// The struct was not initialised, or was refused. It is no mode and no fault.
#define STICTION_NOT_READY -1

// The encoder turns with the motor.
#define STICTION_ENCODER_AT_MOTOR 0

// The encoder turns with the load, behind the transmission.
#define STICTION_ENCODER_AT_LOAD 1

// Mode: the joint moves, or has not come to rest.
#define STICTION_MOVE 0

// Mode: the joint rests, and the law chooses: another attempt, or HOLD.
#define STICTION_STUCK 1

// Mode: a pulse is on.
#define STICTION_PULSE 2

// Mode: the pulse is over, and the joint comes to rest.
#define STICTION_COAST 3

// Mode: the joint rests at its target.
#define STICTION_HOLD 4

// Mode: the attempts have ended without success.
#define STICTION_GIVE_UP 5

// No fault.
#define STICTION_NO_FAULT 0

// Fault: the encoder moved farther in a tick than a joint can.
#define STICTION_ENCODER_JUMP 13

// Fault: effort beyond friction, and no counts: a dead encoder, a hard stop.
#define STICTION_STALL 14

// Fault: the joint turns against the effort: encoder or motor is reversed.
#define STICTION_ENCODER_REVERSED 15

// Fault: the joint is farther from its target than the effort explains.
#define STICTION_FOLLOWING_ERROR 16

// Fault: the joint is faster than allowed.
#define STICTION_OVERSPEED 17

// Fault: the joint is outside its range.
#define STICTION_POSITION_LIMIT 18

// Fault: the model of the winding is too hot.
#define STICTION_OVERHEAT 21

// Fault: the joint swings around a target at rest.
#define STICTION_OSCILLATION 24

// A joint and its law. The caller owns it, and reads nothing of it.
typedef struct {
  uint64_t content[76];
} Stiction;

// Configuration of a joint and of the loop around it.
//
// Angles are rad of the joint. The effort is in any unit: volts, amperes, N m, a share of the
// duty. Inertia, friction, load and limits are in the same unit.
typedef struct {
  // `sizeof(StictionConfig)`.
  uint32_t size;
  // Time between two ticks, s.
  float sample_time;
  // Counts of the encoder in a turn of the joint: lines x 4 x gear.
  float counts_per_turn;
  // Largest effort.
  float largest_effort;
  // Step of the effort: that of the PWM, of a D/A converter, or of a message.
  float effort_step;
  // Moment of inertia, as the effort of an acceleration of 1 rad/s^2.
  float inertia;
  // Viscous friction with back-EMF, as the effort of a speed of 1 rad/s.
  float viscous;
  // Lowest breakaway effort of the joint over all positions, in the unit of the effort.
  float breakaway_low;
  // Highest breakaway effort of the joint over all positions, in the unit of the effort.
  float breakaway_high;
  // Largest load that drives the joint, as an effort. 0: none does.
  float load;
  // Effort that holds the joint where it starts.
  float hold_effort;
  // Counts by which the encoder changes at rest: 2 for noise of one count to either side.
  float jitter;
  // Largest speed, rad/s. 0: a rule of the law.
  float speed;
  // Largest acceleration, rad/s^2. 0: a rule of the law.
  float acceleration;
  // `STICTION_ENCODER_AT_MOTOR` or `STICTION_ENCODER_AT_LOAD`.
  uint32_t encoder_side;
} StictionConfig;

// Reason why a configuration is refused: a field that is outside its range.
typedef struct {
  // Name of the field, with a zero at its end.
  uint8_t field[24];
  // Value found.
  float found;
  // Lowest value allowed.
  float low;
  // Highest value allowed.
  float high;
} StictionRefusal;

// Position that the joint should have at one tick, and the velocity with which it moves on.
typedef struct {
  // Whole counts. They wrap.
  int32_t counts;
  // Fraction of a count beyond the whole ones, from 0 to below 1.
  float fraction;
  // Velocity, rad/s. 0: the target rests, and the joint moves there by a profile of its own.
  float velocity;
  // Acceleration, rad/s^2.
  float acceleration;
} StictionTarget;

// Monitors of a joint. The caller owns them, and reads nothing of them.
typedef struct {
  uint64_t content[86];
} StictionMonitors;

// Configuration of the monitors, beside that of the joint.
typedef struct {
  // `sizeof(StictionMonitorConfig)`.
  uint32_t size;
  // Lowest position from the counter's zero, rad. With both zero there is no range.
  float range_low;
  // Highest position, rad.
  float range_high;
  // Effort that the motor tolerates forever at standstill.
  float continuous_effort;
  // Time constant of the motor's winding, s.
  float thermal_time;
} StictionMonitorConfig;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Validates a configuration and initialises a joint at rest. Returns `STICTION_OK`,
// `STICTION_REFUSED` with the reason in `why` (which can be NULL), or `STICTION_BAD_POINTER`.
//
// `joint` is the caller's, `config` can be read, `why` is NULL or can be written.
int32_t stiction_init(Stiction *joint, const StictionConfig *config, StictionRefusal *why);

// Writes the target at rest at an angle (rad) from the counter's zero. After many turns, add to
// `target->counts` instead: a float keeps an angle to 6e-8 of itself.
//
// `joint` is the caller's, and `target` can be written.
int32_t stiction_target(const Stiction *joint, float angle, StictionTarget *target);

// Runs one tick towards an angle (rad) at which the joint should rest. Returns the effort until
// the next tick, which must be applied at once and in full. Returns 0 if the joint is not
// initialised. `counts` can wrap.
//
// `joint` is the caller's.
float stiction_tick(Stiction *joint, int32_t counts, float angle);

// Runs one tick towards a target that can move, and returns as `stiction_tick` does.
//
// `joint` is the caller's, and `target` can be read.
float stiction_follow(Stiction *joint, int32_t counts, const StictionTarget *target);

// Does the same for an amplifier that has limited the last effort: `applied` is the mean effort
// that the joint has had since the last tick.
//
// `joint` is the caller's, and `target` can be read.
float stiction_follow_applied(Stiction *joint,
                              int32_t counts,
                              const StictionTarget *target,
                              float applied);

// Forgets what was learned. To be called before the next tick when the output has been off, or the
// counter was set.
//
// `joint` is the caller's.
int32_t stiction_restart(Stiction *joint);

// Has a law in `STICTION_GIVE_UP` try again. A target that moves does so, too.
//
// `joint` is the caller's.
int32_t stiction_try_again(Stiction *joint);

// Returns what the law did in the last tick: `STICTION_MOVE` to `STICTION_GIVE_UP`, or
// `STICTION_NOT_READY`.
//
// `joint` is the caller's.
int32_t stiction_mode(const Stiction *joint);

// Validates both configurations and initialises monitors of a joint at `counts` with a cold motor.
// Returns as `stiction_init` does.
//
// `monitors` are the caller's, both configurations can be read, `why` is NULL or can be written.
int32_t stiction_monitors_init(StictionMonitors *monitors,
                               const StictionConfig *joint,
                               const StictionMonitorConfig *config,
                               int32_t counts,
                               StictionRefusal *why);

// Looks at a tick with output: the counter, the target, and the effort that is about to be
// applied. Returns 0 if all is well. Otherwise turn the output off in this tick: it returns the
// fault and writes the value that tripped it (deg for angles) into `value`, which can be NULL.
//
// `monitors` are the caller's, `target` can be read, `value` is NULL or can be written.
int32_t stiction_monitors_check(StictionMonitors *monitors,
                                int32_t counts,
                                const StictionTarget *target,
                                float effort,
                                float *value);

// Looks at a tick without output: the motor cools.
//
// `monitors` are the caller's.
int32_t stiction_monitors_idle(StictionMonitors *monitors, int32_t counts);

// Prepares the monitors for the output to be turned on again at `counts`: the heat stays.
//
// `monitors` are the caller's.
int32_t stiction_monitors_arm(StictionMonitors *monitors, int32_t counts);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* STICTION_H */
