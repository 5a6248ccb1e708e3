//! Effort beyond the breakaway, and the encoder does not count: the more effort, the sooner.
//!
//! ```text
//! excess   = |effort| - breakaway     while that is positive; from breakaway/8 to 4 breakaway
//! impulse += excess h
//! impulse  = 0                        when the encoder shows that it lives
//! ```
//!
//! Trips when the impulse exceeds its limit: an inverse-time characteristic with a shortest and a
//! longest time. By default the limit is the breakaway effort for half a second. So twice the
//! breakaway trips after 0.5 s, the least effort beyond it after 4 s, and five times or more after
//! 0.125 s. With the defaults, from 3.5 times the breakaway on, this monitor trips before
//! [`super::stall`], which judges effort of more than twice the breakaway without pauses. To
//! lengthen `stall_s`, raise this limit as well. Only this monitor judges pulses: a pulse of the
//! full scale moves a light joint far.
//!
//! The impulse is added up across pauses, pulses, changes of sign and arming. Only counts clear it,
//! and not every count: if one wire is cut, the other may flicker between two neighbouring counts.
//! Two things show that the encoder lives:
//!
//! - The joint is two counts from the place where the encoder last showed that it lives.
//! - The encoder counts in the direction of an effort whose sign has turned since then, and no
//!   effort since then was twice the breakaway or more. This happens while a joint hunts across the
//!   edge of a count (DNPF at its set point). A larger effort in one tick moves a joint by a count
//!   or more: a joint that stays within the same two counts under it does not hunt. A law that
//!   pulses (`robust`) brakes after each pulse and so turns the sign: without this condition, the
//!   flicker of the other wire would clear the sum of the pulses.
//!
//! A trip restarts the sum. Effort within the breakaway is never added, so that a law may hold a
//! joint at rest forever.
//!
//! This monitor detects a dead encoder under SRNF, which applies little more than the breakaway
//! effort. Does badly: a joint that moves needs less effort than the breakaway to keep moving. An
//! encoder that dies while the joint creeps, under an effort between the two levels of friction, is
//! not detected; [`super::abrupt_stop`] detects one that dies at more speed.
//!
//! There is no margin on `breakaway_v`. A joint with more friction than that, which rests under an
//! effort beyond it, trips: to this monitor a live encoder without motion and a dead one look the
//! same, and with a margin the dead one would never be detected. Counting only half of the time
//! while the effort grows was tried, since an integral that grows will break the joint away. The
//! friction that the integrals of the thesis tolerate stayed the same, up to a fifth above the
//! file's (an integral on target does not grow), and with a dead encoder the joint went almost
//! twice as far. tests/evidence/reliability.md has the friction that each law tolerates.

use super::limits::{Limits, Units};

/// Ratio of the breakaway effort to the least excess.
const LEAST: u32 = 8;

/// Largest excess, as a multiple of the breakaway effort. A transmission that winds up behind
/// the motor for a tenth of a second may take the full scale without a count of an encoder on the
/// load.
const MOST: u32 = 4;

/// Monitor of the impulse without a count.
#[derive(Clone, Copy, Debug)]
pub(super) struct StallImpulse {
    /// The largest code that is within the breakaway.
    breakaway: u32,
    /// Largest impulse, codes times ticks.
    most: u32,
}

/// Impulse since the encoder last showed that it lives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StallImpulseState {
    /// Impulse, codes times ticks.
    sum: u32,
    /// Position of the joint when the encoder last showed that it lives, counts.
    anchor: i32,
    /// Sign of the last effort beyond the breakaway; zero if there was none yet.
    sign: i8,
    /// Whether the sign has turned since the encoder last showed that it lives.
    turned: bool,
    /// Whether an effort since then was twice the breakaway or more.
    strong: bool,
}

impl StallImpulse {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        // Disabled together with the stall monitor.
        let is_on = limits.breakaway_effort > 0.0 && limits.stall_effort > 0.0;
        let most = match limits.stall_impulse {
            v if is_on => Units::threshold(v, units.code * units.tick),
            _ => u32::MAX,
        };
        // Towards zero: the largest code that is no more than the breakaway.
        Self { breakaway: (limits.breakaway_effort / units.code) as u32, most }
    }

    /// Updates the state with the position of the joint (counts), armed or not.
    #[inline]
    pub const fn see(&self, state: &mut StallImpulseState, position: i32) {
        if position.wrapping_sub(state.anchor).unsigned_abs() > 1 {
            *state = StallImpulseState::lives(position, state.sign);
        }
    }

    /// Updates the state with the code that is about to be applied, the position (counts) and the
    /// travel since the last tick (counts). Returns whether the monitor trips.
    #[inline]
    pub fn check(
        &self,
        state: &mut StallImpulseState,
        code: i32,
        position: i32,
        travel: i32,
    ) -> bool {
        self.see(state, position);
        if state.turned && !state.strong && travel.signum() == i32::from(state.sign) {
            *state = StallImpulseState::lives(position, state.sign);
        }
        let size = code.unsigned_abs();
        if size <= self.breakaway {
            return false;
        }
        let sign = if code > 0 { 1 } else { -1 };
        state.turned |= state.sign == -sign;
        state.sign = sign;
        let beyond = size - self.breakaway;
        state.strong |= beyond >= self.breakaway;
        let most = self.breakaway.saturating_mul(MOST);
        let excess = beyond.max(self.breakaway / LEAST).min(most).max(1);
        state.sum = state.sum.saturating_add(excess);
        let trips = state.sum > self.most;
        if trips {
            state.sum = 0;
        }
        trips
    }
}

impl StallImpulseState {
    /// Returns a cleared state, at a position where the encoder has shown that it lives.
    const fn lives(anchor: i32, sign: i8) -> Self {
        Self { sum: 0, anchor, sign, turned: false, strong: false }
    }

    /// Returns the same impulse in other units, in which it has `ratio` times as many codes times
    /// ticks.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { sum: (self.sum as f32 * ratio) as u32, ..self }
    }
}
