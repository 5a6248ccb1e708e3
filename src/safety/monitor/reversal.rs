//! Encoder or motor wired the wrong way around: the first move after arming goes against the
//! effort.
//!
//! A joint that was at rest (arming requires it) moves in the direction of the effort. While the
//! effort has one sign and is at least the breakaway effort, the travel in its direction is summed
//! up. A sum of `reversal_deg` with the effort proves the wiring until the next arming; as much
//! against the effort trips. Travel does not count while the joint still coasts from an effort the
//! other way.
//!
//! The sum ends when the effort falls below the breakaway effort or changes its sign. If the last
//! sum that was not zero went with the effort, its counts are set off against the next sum: a move
//! of a few counts is braked before it proves the wiring, and noise of a count ends the coasting
//! too early, so that the braking looks like a wrong wire. Only the last push is set off. If the
//! counts of all pushes were, a wire swapped later would be detected only after all of them.
//!
//! A joint may already move when the effort rises beyond the breakaway effort, driven by a load or
//! by the spring of its gear. An effort beyond any friction slows such a joint down, while a joint
//! with a wrong wire gains speed against the effort. So of the travel against the effort in a tick,
//! only the part counts that exceeds the travel per tick before:
//!
//! ```text
//! with += d                    d: travel of a tick with the effort
//! with += d - min(d_0, 0)      where d < 0, and never above zero by that; d_0: the smaller travel
//!                              of the last two ticks with less than the breakaway effort, zero if
//!                              they differ in sign
//! ```
//!
//! From rest `d_0` is zero, and each count against the effort counts. The jitter of an encoder goes
//! to and fro, and a glitch lasts one tick, so neither makes a `d_0`.
//!
//! Does badly: a wire that is swapped after a push is detected later, by the counts of that push,
//! which are fewer than `reversal_deg`. After the proof, a connector that is turned while the joint
//! moves is left to the monitors of following error and overspeed. A load that still gains speed
//! against the breakaway effort in the first move looks like a wrong wire. A joint that was already
//! moving when the effort rose has to gain `reversal_deg` over that speed before a wrong wire is
//! detected.

use super::limits::{Limits, Units};

/// Monitor of the travel against the effort.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reversal {
    code: i32,
    counts: i32,
}

/// State of the first move after arming.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ReversalState {
    proven: bool,
    /// Sign of the last effort of at least the breakaway effort; zero if there was none yet.
    sign: i8,
    /// Direction in which the joint still coasts from the effort before that; zero if it does not.
    coasts: i32,
    /// Sum of the travel with the effort, counts.
    with: i32,
    /// The last sum that was not zero, counts; zero if that sum was negative.
    pushed: i32,
    /// Travel in the last tick with less than the breakaway effort, counts.
    last: i32,
    /// The smaller travel d_0 of the last two ticks with less than the breakaway effort, counts;
    /// zero if the two travels differ in sign.
    before: i32,
}

impl Reversal {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let saturated = |units: u32| i32::try_from(units).unwrap_or(i32::MAX);
        Self {
            code: saturated(Units::threshold(limits.breakaway_effort, units.code)),
            counts: saturated(Units::threshold(limits.reversal, units.count)),
        }
    }

    /// Updates the state with the travel of this tick (counts) and the code that was applied
    /// meanwhile. Returns the sum (counts, negative) if it is too large against the effort.
    #[inline]
    pub fn check(&self, state: &mut ReversalState, code: i32, travel: i32) -> Option<i32> {
        if state.proven {
            return None;
        }
        if code.abs() < self.code {
            let both = match travel {
                1.. => state.last.min(travel).max(0),
                _ => state.last.max(travel).min(0),
            };
            state.end_sum();
            (state.last, state.before) = (travel, both);
            return None;
        }
        let sign = if code > 0 { 1 } else { -1 };
        if state.sign != sign {
            let (coasts, before) =
                if state.sign == 0 { (0, state.before) } else { (travel.signum(), 0) };
            state.end_sum();
            *state = ReversalState { sign, coasts, last: 0, before, ..*state };
        }
        if travel.signum() == state.coasts {
            return None;
        }
        state.coasts = 0;
        let along = |counts: i32| if code > 0 { counts } else { counts.saturating_neg() };
        let travel = along(travel);
        if travel < 0 {
            let gained = travel.saturating_sub(along(state.before).min(0));
            state.with = state.with.saturating_add(gained).min(state.with.max(0));
        } else {
            state.with = state.with.saturating_add(travel);
        }
        state.proven = state.with >= self.counts;
        let against = state.with.saturating_add(state.pushed);
        (against <= -self.counts && self.counts < i32::MAX).then_some(state.with)
    }
}

impl ReversalState {
    /// Ends the sum. Unless it is zero, keeps it as `pushed`, or zero if it is negative.
    fn end_sum(&mut self) {
        if self.with != 0 {
            self.pushed = self.with.max(0);
        }
        self.with = 0;
    }

    /// Treats the wiring as proven until the next arming.
    pub const fn suppose(&mut self) {
        self.proven = true;
    }
}
