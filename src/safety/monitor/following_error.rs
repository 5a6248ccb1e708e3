//! The joint does not follow its set point, or runs away from it.
//!
//! The error may be as large as the limit. A jump of the set point adds room: the part of the error
//! that the joint still has to travel because of the jump. So a step of any size passes, even one
//! just as large as the limit, and a joint that runs the other way trips.
//!
//! ```text
//! jump  = set point - set point before - velocity h       beyond half of the limit; less is none
//! room += jump                                            with its sign: a jump back takes room
//! room  = what of it lies between zero and the error      the joint has travelled the rest
//! ```
//!
//! Trips when |error - room| exceeds the limit. Between two jumps the room only shrinks, so a joint
//! that turns back on its way may go back by the limit. Whatever the jumps and their directions,
//! the joint is never farther than the limit outside the positions from which and to which it was
//! sent.
//!
//! Travel of the set point at its own velocity is no jump. However fast a trajectory is, its error
//! is bounded by the limit alone.
//!
//! A trajectory must begin no farther from the joint than the limit, and no farther than the error
//! at which the law reaches the full scale. The second bound holds even if the limit is off: a
//! trajectory must not begin with a jump, whatever the monitors are.
//!
//! Does badly: a joint that never starts to move on a step does not trip this monitor;
//! [`super::stall`] is for that. A joint that creeps to and fro between two set points in turn does
//! not trip it either.

use super::limits::{Limits, Units};

/// Monitor of the following error.
#[derive(Clone, Copy, Debug)]
pub(super) struct FollowingError {
    most: u32,
    /// Largest distance from the joint at which a trajectory may begin, counts.
    farthest: u32,
    /// Counts that one deg/s makes in a tick.
    counts_per_speed: f32,
}

/// Set point of the last tick, and present room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FollowingState {
    setpoint: i32,
    /// Part of the error that jumps have made, counts, with the error's sign and never beyond it.
    room: i32,
}

impl FollowingError {
    /// Makes the monitor; `saturating` is the error at which the law reaches the full scale, deg.
    pub fn new(limits: &Limits, saturating: f32, units: &Units) -> Self {
        let most = Units::threshold(limits.following_error, units.count);
        Self {
            most,
            farthest: most.min(Units::whole(saturating, units.count)),
            counts_per_speed: units.tick / units.count,
        }
    }

    /// Returns whether a set point at this distance from the joint (counts) is a jump.
    pub const fn is_jump(&self, distance: i32) -> bool {
        distance.unsigned_abs() > self.farthest
    }

    /// Checks the set point (counts), its velocity (deg/s) and the position (counts) of a tick.
    /// Returns the error (counts) if it is too large.
    #[inline]
    pub fn check(
        &self,
        state: &mut FollowingState,
        setpoint: i32,
        velocity: f32,
        counts: i32,
    ) -> Option<i32> {
        let error = setpoint.wrapping_sub(counts);
        let due = (velocity * self.counts_per_speed) as i32;
        let jump = setpoint.wrapping_sub(state.setpoint).wrapping_sub(due);
        let made = if jump.unsigned_abs() > self.most / 2 { jump } else { 0 };
        let room = state.room.saturating_add(made);
        *state = FollowingState { setpoint, room: room.max(error.min(0)).min(error.max(0)) };
        // Both have the same sign, and the room is no more than the error.
        if error.abs_diff(state.room) > self.most { Some(error) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the error that trips, if one does, and the largest error before it, counts. The
    /// limit is 50 counts; a count is 1 deg, and a tick 1 s.
    fn followed(motion: impl Iterator<Item = (i32, f32, i32)>) -> (Option<i32>, i32) {
        let limits = Limits { following_error: 50.0, ..Limits::OFF };
        let units = Units { count: 1.0, code: 1.0, tick: 1.0, supply: 0.0 };
        let (monitor, mut state) =
            (FollowingError::new(&limits, 50.0, &units), FollowingState::default());
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
        // of that. The velocity is a little wrong, as that of a blend is.
        for velocity in [36.0, 40.0, 44.0] {
            let slow = (0..100).map(|k| (40 * k, velocity, 20 * k));
            assert_eq!(followed(slow), (Some(60), 40), "{velocity}");
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

    /// Returns the error that trips under a square wave between 400 and 0 counts, ten ticks each,
    /// with the joint at `position` in each tick.
    fn squares(position: impl Fn(i32) -> i32) -> Option<i32> {
        let square = |k: i32| if (k / 10) % 2 == 0 { 400 } else { 0 };
        followed((0..1000).map(|k| (square(k), 0.0, position(k)))).0
    }

    #[test]
    fn jumps_to_and_fro_do_not_hide_a_joint_that_runs_away() {
        // A joint that follows them passes, be it slower than they are, or without any motion.
        for reached in [0, 50, 150, 400, 440] {
            assert_eq!(
                squares(|k| reached - reached * (k % 20 - 10).abs() / 10),
                None,
                "{reached}"
            );
        }
        // One that creeps off by a count a tick is seen as soon as it is 51 counts outside.
        let error = squares(|k| -k);
        assert_eq!(error, Some(51));
        let error = squares(|k| if k < 10 { 40 * k } else { 390 + k });
        assert_eq!(error, Some(-51));
    }

    #[test]
    fn a_joint_that_turns_back_on_its_way_may_go_back_by_the_limit() {
        let step = |k| if k > 0 { 1000 } else { 0 };
        let back = |k: i32, by: i32| if k < 60 { 10 * k } else { (1200 - 10 * k).max(600 - by) };
        assert_eq!(followed((0..200).map(|k| (step(k), 0.0, back(k, 50)))).0, None);
        let (error, _) = followed((0..200).map(|k| (step(k), 0.0, back(k, 60))));
        assert_eq!(error, Some(1000 - 600 + 60));
    }
}
