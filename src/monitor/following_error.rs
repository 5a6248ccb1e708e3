//! The joint does not follow its set point, or runs away from it.
//!
//! The error may be as large as the limit. A set point that jumps makes room: until the error has
//! been within half of the limit again, it may be larger by the size of the jump. So a step of any
//! size passes, one that is just as large as the limit, too, and a joint that runs the other way
//! does not.
//!
//! ```text
//! jump  = |set point - set point before - velocity h|     beyond half of the limit; less is none
//! room += jump, never beyond the present error            0 once the error is within half of the limit
//! ```
//!
//! What the set point travels at its own velocity is no jump. However fast a trajectory is, its
//! error has the limit and no more. Jumps in a row add up, so that a joint that stays behind each
//! of a row of steps trips in the end only if it runs away; it is the joint's travel against them
//! that is bounded.
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
