//! The range of positions, counted from the [reference](crate::servo) of the joint.
//!
//! Arming anew shifts the zero of the controller, not that of the range: otherwise, repeated arming
//! could move a joint out of its range in steps. While the position is unknown, no range applies,
//! and only jogs and homings drive the joint. Does badly: the range is only as good as the
//! reference, which no sensor confirms.

use super::limits::{Limits, Units};

/// Range of positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PositionLimits {
    lowest: i32,
    highest: i32,
    /// The zero of the range, counts since power-on.
    zero: i32,
}

impl Default for PositionLimits {
    fn default() -> Self {
        Self::NONE
    }
}

impl PositionLimits {
    /// Range without limits: every position is within it.
    pub const NONE: Self = Self { lowest: i32::MIN, highest: i32::MAX, zero: 0 };

    pub(super) fn new(limits: &Limits, units: &Units) -> Self {
        if limits.position_min == 0.0 && limits.position_max == 0.0 {
            return Self::NONE;
        }
        // The conversion saturates.
        let counts = |deg: f32| libm::roundf(deg / units.count) as i32;
        Self { lowest: counts(limits.position_min), highest: counts(limits.position_max), zero: 0 }
    }

    /// Returns the range of a joint whose zero is at `zero`, counts since power-on.
    pub fn with_zero(self, zero: i32) -> Self {
        if self == Self::NONE {
            return self;
        }
        let [lowest, highest] = [self.lowest, self.highest].map(|end| end.saturating_add(zero));
        Self { lowest, highest, zero }
    }

    /// Returns the lowest and the highest position of the range, counts.
    #[cfg(feature = "two-encoders")]
    pub const fn ends(&self) -> [i32; 2] {
        [self.lowest, self.highest]
    }

    /// Returns a position (counts since power-on) in counts from the zero of the range.
    pub const fn counted(&self, position: i32) -> i32 {
        position.wrapping_sub(self.zero)
    }

    #[inline]
    pub const fn check(&self, position: i32) -> bool {
        position < self.lowest || position > self.highest
    }
}
