//! Play between the motor and an encoder on the load: the motor crosses it without a count.
//!
//! ```text
//! v <- v + g (u - B sign(v)) h        at rest only if |u| > B
//! x <- x + v h                        |x| <= p; v = 0 at an end
//! taken up:  x has reached p in the direction of u
//! ```
//!
//! `x` and `v` are those of the whole joint in the play: `g` is its gain (four times
//! `progress_gain`), `B` its friction (`breakaway_v`), `u` the effort and `p` is `play_deg`. The
//! motor alone is lighter and has a part of that friction, so it is ahead of `x`. Two counts from
//! where the encoder last showed that it lives begin anew at `x = 0`. Until the play is taken up,
//! an effort without a count is no stall: neither [`super::stall`] nor [`super::stall_impulse`]
//! adds it up.
//!
//! Guarantees: a motor that is free in its play, lighter than the joint of the file by what the
//! file errs, and without a load, has gone `p` before either of them adds up.
//!
//! Does badly: with a silent encoder the joint crosses the play and goes on until the stall: on
//! the thesis's joint 14.5 deg with a play of 1 deg, at full effort, against 2.3 deg without.
//! [`super::abrupt_stop`] is off, for the halves of a joint collide in the play: an encoder that
//! dies in motion is detected by its effort alone. A joint that hunts within its play takes it up
//! in neither direction.

use super::limits::{Limits, Units};

/// The gain of the file's joint, as a multiple of that of the weakest joint.
const OF_WEAKEST: f32 = 4.0;

/// The play and the joint in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Play {
    /// Counts.
    width: f32,
    /// Codes.
    friction: f32,
    /// Counts per tick and tick, of a code.
    gain: f32,
}

/// Where the joint is in the play.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PlayState {
    /// Counts.
    at: f32,
    /// Counts per tick.
    speed: f32,
    /// Where the encoder last showed that it lives, counts.
    anchor: i32,
}

impl Play {
    /// Makes it; without a play there is none.
    pub fn new(limits: &Limits, units: &Units) -> Option<Self> {
        let gain =
            OF_WEAKEST * limits.progress_gain * units.code * units.tick * units.tick / units.count;
        (limits.play > 0.0 && gain > 0.0).then(|| Self {
            width: limits.play / units.count,
            friction: limits.breakaway_effort / units.code,
            gain,
        })
    }

    /// Takes the code that is about to be applied, and the position (counts). Returns whether the
    /// play is taken up in the direction of the effort.
    // Out of line: a joint without play does not pay for it.
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
