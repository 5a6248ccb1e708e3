//! The range of positions, counted from where the joint stood at power-on.
//!
//! Arming anew shifts the zero of the controller, not this one: otherwise a joint could be walked
//! out of its range in steps. Does badly: without an index or a homing switch the range is only as
//! good as the place of power-on.

use super::limits::{Limits, Units};

/// Position against its range.
#[derive(Clone, Copy, Debug)]
pub(super) struct PositionLimits {
    lowest: i32,
    highest: i32,
}

impl PositionLimits {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        if limits.position_min == 0.0 && limits.position_max == 0.0 {
            return Self { lowest: i32::MIN, highest: i32::MAX };
        }
        // The conversion saturates.
        let counts = |deg: f32| libm::roundf(deg / units.count) as i32;
        Self { lowest: counts(limits.position_min), highest: counts(limits.position_max) }
    }

    #[inline]
    pub const fn check(&self, position: i32) -> bool {
        position < self.lowest || position > self.highest
    }
}
