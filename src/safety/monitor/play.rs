//! Play between the motor and an encoder on the load: the motor crosses it without a count.
//!
//! ```text
//! v <- v + g (u - B sign(v)) h        at rest only if |u| > B
//! x <- x + v h                        |x| <= p; v = 0 at an end
//! taken up:  x has reached p in the direction of u
//! ```
//!
//! `x` and `v` are position and speed of the whole joint in the play: `g` is its gain (four times
//! `progress_gain`), `B` its friction (`breakaway_v`), `u` the effort and `p` is `play_deg`. The
//! motor alone is lighter and has a part of that friction, so it is ahead of `x`. Two counts of
//! travel restart the model at `x = 0`. Until the play is taken up, an effort without a count is no
//! stall: neither [`super::stall`] nor [`super::stall_impulse`] adds it up.
//!
//! Guarantees: before either of them adds up, a motor that is free in its play has travelled `p`,
//! if it has no load and is lighter than the joint of the file by at least the file's error.
//!
//! Does badly: with a silent encoder the joint crosses the play and goes on until the stall: on the
//! thesis's joint 14.5 deg with a play of 1 deg, at full effort, against 2.3 deg without.
//! [`super::abrupt_stop`] is off, since the halves of a joint collide in the play: an encoder that
//! dies in motion is detected by its effort alone. A joint that hunts within its play takes it up
//! in neither direction.

use super::limits::{Limits, Units};

/// The gain of the file's joint, as a multiple of that of the weakest joint.
const OF_WEAKEST: f32 = 4.0;

/// Model of the joint in its play.
#[derive(Clone, Copy, Debug)]
pub(super) struct Play {
    /// Width of the play, p, counts.
    width: f32,
    /// Friction of the joint, B, codes.
    friction: f32,
    /// Acceleration for each code, counts per tick and tick.
    gain: f32,
}

/// State of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PlayState {
    /// Position in the play, x, counts.
    at: f32,
    /// Speed in the play, v, counts per tick.
    speed: f32,
    /// Position of the encoder at the last restart of the model, counts.
    anchor: i32,
}

impl Play {
    /// Makes the model; none without a play or a gain.
    pub fn new(limits: &Limits, units: &Units) -> Option<Self> {
        let gain =
            OF_WEAKEST * limits.progress_gain * units.code * units.tick * units.tick / units.count;
        (limits.play > 0.0 && gain > 0.0).then(|| Self {
            width: limits.play / units.count,
            friction: limits.breakaway_effort / units.code,
            gain,
        })
    }

    /// Updates the state with the code that is about to be applied and the position (counts).
    /// Returns whether the play is taken up in the direction of the effort.
    // Out of line: it costs nothing for a joint without play.
    #[cold]
    #[inline(never)]
    pub fn is_taken_up(&self, state: &mut PlayState, code: i32, position: i32) -> bool {
        if position.wrapping_sub(state.anchor).unsigned_abs() > 1 {
            *state = PlayState { anchor: position, ..PlayState::default() };
        }
        let effort = code as f32;
        // Friction stops the joint, and does not turn it.
        let slowed = self.friction * self.gain;
        let pushed = state.speed + effort * self.gain;
        state.speed =
            if pushed > 0.0 { (pushed - slowed).max(0.0) } else { (pushed + slowed).min(0.0) };
        let at = state.at + state.speed;
        // Not `clamp`, which may panic.
        state.at = at.max(-self.width).min(self.width);
        if state.at != at {
            state.speed = 0.0;
        }
        if code < 0 { state.at <= -self.width } else { state.at >= self.width }
    }
}
