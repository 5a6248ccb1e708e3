//! Positions that lose no precision far from zero.
//!
//! A position is a whole number of encoder counts (`i32`, wrapping) plus a fraction of a count in
//! `[0, 1)` (`f32`). Two positions are subtracted as integers first, and only the small difference
//! becomes a float: the error of a joint ten thousand turns from its origin is as exact as near
//! zero, and the counter may wrap.

/// The position of the joint: `counts + fraction`, in encoder counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "device", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Position {
    /// Whole counts of the position. They wrap.
    pub counts: i32,
    /// Fraction of a count beyond the whole ones, in `[0, 1)`.
    pub fraction: f32,
}

impl Position {
    /// Returns a position on a whole count.
    ///
    /// ```
    /// use stiction::units::position::Position;
    /// assert_eq!(Position::from_counts(-3).fraction, 0.0);
    /// ```
    pub const fn from_counts(counts: i32) -> Self {
        Self { counts, fraction: 0.0 }
    }

    /// Returns this position moved by `displacement` counts, with the rounding of `f32`.
    ///
    /// ```
    /// use stiction::units::position::Position;
    /// let p = Position::from_counts(2_000_000_000).displaced(-0.25);
    /// assert_eq!((p.counts, p.fraction), (1_999_999_999, 0.75));
    /// ```
    pub fn displaced(self, displacement: f32) -> Self {
        let sum = self.fraction + displacement;
        let floor = floor(sum);
        let fraction = sum - floor;
        let counts = self.counts.wrapping_add(floor as i32);
        // A sum just below zero has a fraction that rounds to one.
        if fraction >= 1.0 {
            Self { counts: counts.wrapping_add(1), fraction: 0.0 }
        } else {
            Self { counts, fraction }
        }
    }

    /// Returns this position after `ticks` ticks at constant `rate`: exact to `ticks * 2^-32`
    /// counts, however long.
    pub fn advanced(self, rate: Rate, ticks: i32) -> Self {
        let travel = rate.0.wrapping_mul(i64::from(ticks));
        let counts = self.counts.wrapping_add((travel >> 32) as i32);
        // The upper 24 bits of the fraction are exactly what an f32 below one can hold.
        let sum = self.fraction + ((travel as u32) >> 8) as f32 * (1.0 / 16_777_216.0);
        // The sum of two fractions is below two, and its whole part needs no rounding function.
        if sum >= 1.0 {
            Self { counts: counts.wrapping_add(1), fraction: sum - 1.0 }
        } else {
            Self { counts, fraction: sum }
        }
    }

    /// Returns how far this position lies ahead of `counts`, in counts: the wrapping integer
    /// difference plus the fraction.
    ///
    /// ```
    /// use stiction::units::position::Position;
    /// let reference = Position { counts: i32::MIN, fraction: 0.5 };
    /// assert_eq!(reference.ahead_of(i32::MAX), 1.5);
    /// ```
    pub fn ahead_of(self, counts: i32) -> f32 {
        self.counts.wrapping_sub(counts) as f32 + self.fraction
    }
}

/// A constant speed in counts per tick, as a fixed-point number with 32 fractional bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rate(i64);

impl Rate {
    /// The rate of a joint at rest.
    pub const ZERO: Self = Self(0);

    /// Returns the rate that moves from one position to another in `ticks` ticks (at least one).
    /// Positions wrap: of the two ways from one to the other, the rate goes the shorter one, below
    /// 2^31 counts.
    ///
    /// ```
    /// use stiction::units::position::{Position, Rate};
    /// let (from, to) = (Position::from_counts(7), Position { counts: 20_668, fraction: 0.25 });
    /// let rate = Rate::between(from, to, 500);
    /// let end = from.advanced(rate, 500);
    /// assert!((end.ahead_of(20_668) - 0.25).abs() < 1e-6);
    /// ```
    pub fn between(from: Position, to: Position, ticks: u32) -> Self {
        let difference = (i64::from(to.counts.wrapping_sub(from.counts)) << 32)
            .wrapping_add(q32(to.fraction))
            .wrapping_sub(q32(from.fraction));
        Self(difference / i64::from(ticks.max(1)))
    }

    /// Returns the rate in counts per tick.
    pub fn counts_per_tick(self) -> f32 {
        // The halves are converted apart: a 64-bit integer to float conversion is a library routine
        // on the target.
        (self.0 >> 32) as i32 as f32 + ((self.0 as u32) >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// Returns the largest whole number that is not above `x`, as `libm::floorf` does. Two instructions
/// of the processor convert there and back.
fn floor(x: f32) -> f32 {
    // From 2^23 on every f32 is whole. NaN stays NaN.
    if x.abs() < 8_388_608.0 {
        let truncated = x as i32 as f32;
        if truncated > x { truncated - 1.0 } else { truncated }
    } else {
        x
    }
}

/// Returns a fraction in `[0, 1)` as a fixed-point number with 32 fractional bits.
fn q32(fraction: f32) -> i64 {
    i64::from((fraction * 4_294_967_296.0) as u32)
}

#[cfg(test)]
mod tests {
    #[test]
    fn floor_is_that_of_libm() {
        // Every exponent and sign, and mantissas at both ends and between.
        for high in 0..=0xFFFF_u32 {
            for low in [0, 1, 0x7FFF, 0x8000, 0xFFFF] {
                let x = f32::from_bits(high << 16 | low);
                let (ours, theirs) = (super::floor(x), libm::floorf(x));
                assert!(
                    ours == theirs || ours.is_nan() && theirs.is_nan(),
                    "{x:e}: {ours:e}, not {theirs:e}"
                );
            }
        }
    }
}
