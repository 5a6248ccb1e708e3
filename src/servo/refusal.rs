//! Reasons why a servo refuses a command.

use crate::safety::fault::Fault;

/// Reason why the servo refuses a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The servo has not had its first tick.
    Booting,
    /// A fault is latched.
    Faulted(Fault),
    /// The fault cannot be cleared by a command.
    NotClearable(Fault),
    /// The servo is armed, and the command requires a stopped servo; or a course runs that accepts
    /// only a stop.
    Armed,
    /// The servo is not armed, and the command requires an armed servo.
    NotArmed,
    /// The joint moves, and the command requires a joint at rest.
    Moving,
    /// A stop is under way.
    Stopping,
    /// Arming would end in this fault at once, or the cleared fault would return at once.
    WouldTrip(Fault),
    /// The encoder is in doubt after a stall, a jump or a reversal: the joint has to be moved by
    /// hand, or a jog has to show that encoder and motor agree.
    EncoderInDoubt,
    /// The friction of the joint is unknown (`breakaway_min_v` is zero), so that no closed loop is
    /// armed. An identification measures the friction.
    FrictionUnknown,
    /// The joint has a range of positions, and its position is unknown: only a jog and a homing may
    /// drive it until a homing or a command sets its position.
    NotReferenced,
    /// The motion would leave the range of positions.
    OutOfRange,
    /// The trajectory or the sine begins too far from the joint.
    FarAway,
    /// The position is 2^30 counts away from the joint or its set point, or farther.
    TooFar,
    /// The set point is too fast to come to rest within the range of positions.
    TooFast,
    /// A link has replaced the motion of the parameters.
    Replaced,
    /// A test at arming runs, which accepts only a stop.
    Testing,
}
