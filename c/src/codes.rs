//! Numbers of results, modes and faults. Each number keeps its meaning.

use stiction::positioner::Mode;
use stiction::safety::fault::Fault;

/// Done.
pub const STICTION_OK: i32 = 0;
/// A value is outside its range: see `StictionRefusal`.
pub const STICTION_REFUSED: i32 = 1;
/// A pointer is null or misaligned.
pub const STICTION_BAD_POINTER: i32 = 2;
/// The struct was not initialised, or was refused. It is no mode and no fault.
pub const STICTION_NOT_READY: i32 = -1;

/// The encoder turns with the motor.
pub const STICTION_ENCODER_AT_MOTOR: u32 = 0;
/// The encoder turns with the load, behind the transmission.
pub const STICTION_ENCODER_AT_LOAD: u32 = 1;

/// Mode: the joint moves, or has not come to rest.
pub const STICTION_MOVE: i32 = 0;
/// Mode: the joint rests, and the law chooses: another attempt, or HOLD.
pub const STICTION_STUCK: i32 = 1;
/// Mode: a pulse is on.
pub const STICTION_PULSE: i32 = 2;
/// Mode: the pulse is over, and the joint comes to rest.
pub const STICTION_COAST: i32 = 3;
/// Mode: the joint rests at its target.
pub const STICTION_HOLD: i32 = 4;
/// Mode: the attempts have ended without success.
pub const STICTION_GIVE_UP: i32 = 5;

/// No fault.
pub const STICTION_NO_FAULT: i32 = 0;
/// Fault: the encoder moved farther in a tick than a joint can.
pub const STICTION_ENCODER_JUMP: i32 = 13;
/// Fault: effort beyond friction, and no counts: a dead encoder, a hard stop.
pub const STICTION_STALL: i32 = 14;
/// Fault: the joint turns against the effort: encoder or motor is reversed.
pub const STICTION_ENCODER_REVERSED: i32 = 15;
/// Fault: the joint is farther from its target than the effort explains.
pub const STICTION_FOLLOWING_ERROR: i32 = 16;
/// Fault: the joint is faster than allowed.
pub const STICTION_OVERSPEED: i32 = 17;
/// Fault: the joint is outside its range.
pub const STICTION_POSITION_LIMIT: i32 = 18;
/// Fault: the model of the winding is too hot.
pub const STICTION_OVERHEAT: i32 = 21;
/// Fault: the joint swings around a target at rest.
pub const STICTION_OSCILLATION: i32 = 24;

// The numbers are those of the core.
const _: () = {
    assert!(STICTION_MOVE == Mode::Move as i32 && STICTION_STUCK == Mode::Stuck as i32);
    assert!(STICTION_PULSE == Mode::Pulse as i32 && STICTION_COAST == Mode::Coast as i32);
    assert!(STICTION_HOLD == Mode::Hold as i32 && STICTION_GIVE_UP == Mode::GiveUp as i32);
    assert!(STICTION_ENCODER_JUMP == Fault::EncoderJump as i32);
    assert!(STICTION_STALL == Fault::Stall as i32);
    assert!(STICTION_ENCODER_REVERSED == Fault::EncoderReversed as i32);
    assert!(STICTION_FOLLOWING_ERROR == Fault::FollowingError as i32);
    assert!(STICTION_OVERSPEED == Fault::Overspeed as i32);
    assert!(STICTION_POSITION_LIMIT == Fault::PositionLimit as i32);
    assert!(STICTION_OVERHEAT == Fault::Overheat as i32);
    assert!(STICTION_OSCILLATION == Fault::Oscillation as i32);
};
