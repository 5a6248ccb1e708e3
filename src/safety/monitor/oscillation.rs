//! The joint swings to and fro under efforts that change their sign, and its set point does not.
//!
//! ```text
//! a swing    more than 16 counts back from the farthest place of the swing before
//! a series   each swing within 1 s of the one before, under effort of the other sign, while the
//!            set point went less than 16 counts
//! warning    a series of 3 s;     fault: a series of oscillation_s
//! ```
//!
//! 16 counts are more than the noise that standstill allows (4) and less than any swing that does
//! harm. Efforts of both signs distinguish a loop that oscillates from a machine that shakes the
//! joint.
//!
//! Guarantees: a joint that swings by more than 16 counts twice a second or faster, around a set
//! point that rests, trips after `oscillation_s` plus one swing.
//!
//! Does badly: slower swings, as the hunting of an integral, are no series. A swing on a moving set
//! point is not judged. An elastic shaft behind the encoder may swing unseen.

use super::limits::{Limits, Units};

/// Travel back that makes a swing, and travel of the set point that ends a series, counts.
const SWING: u32 = 16;

/// Longest time between two swings of a series, s.
const LONGEST: f32 = 1.0;

/// Length of a series beyond which it is reported as a warning, s.
const REPORTED: f32 = 3.0;

/// Monitor of a series of swings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oscillation {
    longest: u32,
    reported: u32,
    limit: u32,
}

/// State of the present swing and of its series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct OscillationState {
    /// Farthest place of the present swing, counts since power-on.
    farthest: i32,
    /// Direction of the present swing; zero before the first one.
    direction: i32,
    /// Sign of the effort in the swing before.
    effort: i32,
    /// Ticks since the last swing.
    since: u32,
    /// Length of the series up to the last swing, ticks.
    lasted: u32,
    /// Set point of the last tick, counts.
    setpoint: i32,
    /// Travel of the set point since the last swing, counts.
    way: u32,
}

impl Oscillation {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        Self {
            longest: Units::whole(LONGEST, units.tick),
            reported: Units::whole(REPORTED, units.tick),
            limit: Units::threshold(limits.oscillation_time, units.tick),
        }
    }

    /// Updates the state with the position (counts since power-on), the set point (counts), and the
    /// code that was applied in the last tick. Returns the length of the series, ticks, if it is
    /// too long.
    #[inline]
    pub fn check(
        &self,
        state: &mut OscillationState,
        position: i32,
        setpoint: i32,
        code: i32,
    ) -> Option<u32> {
        state.since = state.since.saturating_add(1);
        let moved = setpoint.wrapping_sub(state.setpoint).unsigned_abs();
        state.way = state.way.saturating_add(moved);
        state.setpoint = setpoint;
        if state.since > self.longest {
            state.lasted = 0;
        }
        // Ahead of the farthest place, in the direction of the swing.
        let ahead = position.wrapping_sub(state.farthest);
        let forward = if state.direction < 0 { ahead.wrapping_neg() } else { ahead };
        if state.direction != 0 && forward >= 0 {
            state.farthest = position;
            return None;
        }
        if ahead.unsigned_abs() <= SWING {
            return None;
        }
        let effort = code.signum();
        let goes_on = state.since <= self.longest
            && state.way < SWING
            && effort != 0
            && effort == -state.effort;
        state.lasted = if goes_on { state.lasted.saturating_add(state.since) } else { 0 };
        (state.direction, state.farthest) = (ahead.signum(), position);
        (state.effort, state.since, state.way) = (effort, 0, 0);
        (state.lasted > self.limit).then_some(state.lasted)
    }

    /// Returns whether a series has lasted long enough to be reported.
    pub const fn is_reported(&self, state: &OscillationState) -> bool {
        state.lasted > self.reported
    }
}
