//! Encoder or motor wired the wrong way around: the first move after arming goes against the
//! effort.
//!
//! A joint that was at rest (arming requires it) goes where it is pushed. While the effort has one
//! sign and is at least the breakaway effort, the travel with it is summed up. The limit of counts
//! with the effort proves the wiring until the next arming; as many against it trip. A joint that
//! is still coasting from an effort the other way does not count until it has stopped.
//!
//! The sum ends where the effort falls below the breakaway effort or changes its sign. What the
//! last one that was not zero came to with the effort is then set off against the next one: a move
//! of a few counts is braked before it proves the wiring, and noise of a count ends the coasting
//! too early, so that the braking looks like a wrong wire. The push before that is forgotten: were
//! the counts of all pushes set off, a wire that is swapped later would be seen after all of them.
//!
//! A joint may move already when the effort rises beyond the breakaway effort: a load has driven
//! it, or the spring of its gear. An effort beyond any friction slows such a joint down, while a
//! reversed one gains speed against it. So travel against the effort counts by what it is more
//! than the joint made in a tick before:
//!
//! ```text
//! with += d                    d: travel of a tick with the effort
//! with += d - min(d_0, 0)      where d < 0, and never above zero by that; d_0: the smaller travel
//!                              of the last two ticks with less than the breakaway effort, zero if
//!                              they differ in sign
//! ```
//!
//! From rest `d_0` is zero, and each count against the effort counts: the jitter of an encoder goes
//! to and fro, and a glitch has one tick.
//!
//! Does badly: a wire that is swapped after a push is seen later by the counts of that push, fewer
//! than `reversal_deg` has. Once proven, a connector that is turned while the joint moves is left
//! to following error and overspeed. A load that still gains speed against the breakaway effort in
//! the first move looks like a wrong wire. A joint that was already moving when the effort rose has
//! to gain `reversal_deg` over that speed before a wrong wire is seen.

use super::limits::{Limits, Units};

/// Travel against the effort and its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reversal {
    code: i32,
    counts: i32,
}

/// Where the first move has led so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ReversalState {
    proven: bool,
    /// Sign of the last effort beyond the threshold; zero: there was none yet.
    sign: i8,
    /// Direction in which the joint still moves because of the effort before that.
    coasts: i32,
    with: i32,
    /// What the last sum that was not zero came to with the effort, counts; zero if it went
    /// against it.
    pushed: i32,
    /// Travel in the last tick below the threshold, and what both of the last two have made,
    /// counts.
    last: i32,
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

    /// Takes the travel of this tick and the code that was applied meanwhile; returns the travel
    /// against it if that is too much.
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
    /// Ends the sum, and keeps what it came to with the effort.
    fn end_sum(&mut self) {
        if self.with != 0 {
            self.pushed = self.with.max(0);
        }
        self.with = 0;
    }

    /// Takes the wiring for proven, until the next arming.
    pub const fn suppose(&mut self) {
        self.proven = true;
    }
}
