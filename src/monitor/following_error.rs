//! The joint does not follow its set point, or runs away from it.
//!
//! The error may be as large as the limit. A set point that jumps by more than half of it in a tick makes room: until
//! the error has been within half of the limit again, it may be the limit larger than right after the jump. So a step
//! of any size passes, one that is just as large as the limit, too, and a joint that runs the other way does not.
//!
//! Does badly: a joint that never sets out on a step does not trip this; [`super::stall`] is for that.

use super::limits::{Limits, Units};

/// Error against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct FollowingError {
    most: u32,
}

/// What is allowed at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FollowingState {
    setpoint: i32,
    /// Beyond the limit, because of a jump.
    room: u32,
}

impl FollowingError {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        Self { most: Units::threshold(limits.following_error, units.count) }
    }

    /// Takes set point and position of a tick (counts); returns the error if it is too large.
    #[inline]
    pub const fn check(&self, state: &mut FollowingState, setpoint: i32, counts: i32) -> Option<i32> {
        let error = setpoint.wrapping_sub(counts);
        let size = error.unsigned_abs();
        if setpoint.wrapping_sub(state.setpoint).unsigned_abs() > self.most / 2 {
            state.room = size;
        } else if size <= self.most / 2 {
            state.room = 0;
        }
        state.setpoint = setpoint;
        if size > self.most.saturating_add(state.room) { Some(error) } else { None }
    }
}
