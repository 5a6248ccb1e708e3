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
//! 0.125 s. So from 3.5 times the breakaway on this comes before the default of [`super::stall`],
//! which looks at effort of more than twice the breakaway that does not pause: who lengthens that
//! time has to raise this limit, too. Pulses are for this one alone, since a pulse of the full
//! scale moves a light joint far.
//!
//! The impulse is added up across pauses, pulses, changes of sign and arming. Only counts clear it,
//! and not every count: one wire that is cut lets the other flicker between two neighbouring
//! counts. The encoder lives if the joint is two counts from where it was when it lived last. It
//! also lives if it counts with an effort whose sign has turned since then: so does a joint that
//! hunts across the edge of a count (DNPF at its set point). But that is only for efforts of less
//! than twice the breakaway since then. More in one tick moves a joint by a count or more, and one
//! that gets it and stays within the same two counts does not hunt: a law that pulses (`robust`)
//! brakes after each pulse, the sign turns, and the flicker of the other wire would clear what the
//! pulses add up. A trip starts it anew. Effort within the breakaway is never added, so that a law
//! may hold a joint at rest for ever.
//!
//! This sees a dead encoder under SRNF, which asks for the breakaway effort and little more. Does
//! badly: a joint that moves needs less effort than the breakaway to keep moving. An encoder that
//! dies while the joint creeps, under an effort between the two levels of friction, is not seen;
//! [`super::abrupt_stop`] sees one that dies at more speed.
//!
//! There is no margin on `breakaway_v`. A joint with more friction than that, which rests under an
//! effort beyond it, trips: from here a live encoder that has nothing to count and a dead one look
//! the same, and a margin would leave the dead one unseen for ever. Half of the time for an effort
//! that grows was tried, since an integral that grows will break the joint away. The friction that
//! the integrals of the thesis bear stayed where it was, up to a fifth above the file's (an
//! integral on target does not grow), and a dead encoder led almost twice as far.
//! tests/evidence/reliability.md has the friction that each law bears.

use super::limits::{Limits, Units};

/// The least excess is so small a part of the breakaway effort.
const LEAST: u32 = 8;

/// Largest excess, as a multiple of the breakaway effort. A transmission that winds up behind
/// the motor for a tenth of a second may take the full scale without a count of an encoder on the
/// load.
const MOST: u32 = 4;

/// Impulse without a count against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct StallImpulse {
    /// The largest code that is within the breakaway.
    breakaway: u32,
    /// Codes times ticks.
    most: u32,
}

/// Codes times ticks beyond the breakaway since the last count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StallImpulseState {
    sum: u32,
    /// Where the joint was when the encoder last showed that it lives, counts.
    anchor: i32,
    /// Sign of the last effort beyond the breakaway; zero: there was none yet.
    sign: i8,
    /// The sign has turned since then.
    turned: bool,
    /// There was twice the breakaway since then, or more.
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

    /// Takes the position of the joint (counts), armed or not.
    #[inline]
    pub const fn see(&self, state: &mut StallImpulseState, position: i32) {
        if position.wrapping_sub(state.anchor).unsigned_abs() > 1 {
            *state = StallImpulseState::lives(position, state.sign);
        }
    }

    /// Takes the code that is about to be applied, the position (counts) and what it has travelled
    /// since the last tick.
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
    /// Begins anew where the encoder has shown that it lives.
    const fn lives(anchor: i32, sign: i8) -> Self {
        Self { sum: 0, anchor, sign, turned: false, strong: false }
    }

    /// Returns the same impulse where it has `ratio` times as many codes and ticks.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { sum: (self.sum as f32 * ratio) as u32, ..self }
    }
}
