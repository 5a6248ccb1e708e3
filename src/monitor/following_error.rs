//! The joint does not follow its set point, or runs away from it.
//!
//! The error may be as large as the limit. A set point that jumps makes room: until the error has
//! been within half of the limit again, it may be larger by the size of the jump. So a step of any
//! size passes, one that is just as large as the limit, too, and a joint that runs the other way
//! does not.
//!
//! ```text
//! jump  = |set point - set point before - velocity h|     beyond half of the limit; less is none
//! room += jump, never beyond the present error     0 once the error is within half of the limit
//! ```
//!
//! What the set point travels at its own velocity is no jump. However fast a trajectory is, its
//! error has the limit and no more. Jumps in a row add up: a joint that stays behind each of them
//! does not trip, and one that runs the other way does.
//!
//! Does badly: a joint that never sets out on a step does not trip this; [`super::stall`] is for
//! that.

use super::limits::{Limits, Units};

/// Error against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct FollowingError {
    most: u32,
    /// Counts that one deg/s makes in a tick.
    counts_per_speed: f32,
}

/// What is allowed at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FollowingState {
    setpoint: i32,
    /// Counts beyond the limit, because of jumps.
    room: u32,
}

impl FollowingError {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        Self {
            most: Units::threshold(limits.following_error, units.count),
            counts_per_speed: units.tick / units.count,
        }
    }

    /// Returns whether a distance (counts) is more than the limit.
    pub const fn is_beyond(&self, distance: i32) -> bool {
        distance.unsigned_abs() > self.most
    }

    /// Takes set point (counts), its velocity (deg/s) and the position (counts) of a tick; returns
    /// the error (counts) if it is too large.
    #[inline]
    pub fn check(
        &self,
        state: &mut FollowingState,
        setpoint: i32,
        velocity: f32,
        counts: i32,
    ) -> Option<i32> {
        let error = setpoint.wrapping_sub(counts);
        let size = error.unsigned_abs();
        let due = (velocity * self.counts_per_speed) as i32;
        let jump = setpoint.wrapping_sub(state.setpoint).wrapping_sub(due).unsigned_abs();
        if jump > self.most / 2 {
            state.room = state.room.saturating_add(jump).min(size);
        } else if size <= self.most / 2 {
            state.room = 0;
        }
        state.setpoint = setpoint;
        if size > self.most.saturating_add(state.room) { Some(error) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error before a trip, or at the end, in counts; the limit is 50 of them. A count
    /// is 1 deg, and a tick 1 s.
    fn followed(motion: impl Iterator<Item = (i32, f32, i32)>) -> (Option<i32>, i32) {
        let limits = Limits { following_error: 50.0, ..Limits::OFF };
        let units = Units { count: 1.0, code: 1.0, tick: 1.0, supply: 0.0 };
        let (monitor, mut state) =
            (FollowingError::new(&limits, &units), FollowingState::default());
        let mut largest = 0;
        for (setpoint, velocity, counts) in motion {
            if let Some(error) = monitor.check(&mut state, setpoint, velocity, counts) {
                return (Some(error), largest);
            }
            largest = largest.max((setpoint - counts).abs());
        }
        (None, largest)
    }

    #[test]
    fn a_set_point_that_is_faster_than_the_limit_makes_no_room() {
        // 40 counts a tick are less than the limit and more than half of it; the joint goes at half
        // of that. The velocity is told a little wrong, as that of a blend is.
        for told in [36.0, 40.0, 44.0] {
            let slow = (0..100).map(|k| (40 * k, told, 20 * k));
            assert_eq!(followed(slow), (Some(60), 40), "{told}");
        }
        let fast = (0..100).map(|k| (4000 * k, 4000.0, 4000 * k - if k > 0 { 50 } else { 0 }));
        assert_eq!(followed(fast), (None, 50));
    }

    #[test]
    fn a_step_of_any_size_passes_and_a_joint_that_runs_away_from_it_does_not() {
        for size in [26, 50, 1000, -1_000_000] {
            let step = |k| if k > 0 { size } else { 0 };
            let towards = (0..100).map(|k| (step(k), 0.0, step(k) / 100 * k));
            assert_eq!(followed(towards).0, None, "{size}");
            let away = (0..100).map(|k| (step(k), 0.0, -size.signum() * 10 * k));
            // The sixth tick is the first one that is more than 50 counts away.
            assert_eq!(followed(away).0.map(i32::abs), Some(size.abs() + 60), "{size}");
        }
    }
}
