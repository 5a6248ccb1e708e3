//! The approach to a target at rest in the least number of steps with bounded speed and
//! acceleration: R. Zanasi, C. Guarino Lo Bianco and A. Tonielli, Automatica 36 (2000), 439.
//!
//! One step is a unit of time. `D` is the largest change of the speed, `V` the largest speed, and
//! `d` the distance. The fastest speed that still comes to rest on the target is
//!
//! ```text
//! t(d) = n D/2 + d/(n + 1)     n = 0, 1, 2 ... whichever gives the least
//! w   <- clamp(min(t, V), w - D .. w + D)
//! ```
//!
//! Each `n` is the line through the speeds `n D` and `(n + 1) D`, from which `n` and `n + 1` whole
//! steps `D` come to rest. The least of them all is the polygon over these points. A speed on it
//! falls by exactly `D` with each step, and the last step is `d` itself. Only the lines whose
//! speeds can be reached within one step need to be considered, so that no root has to be computed.
//!
//! Guarantees, for whole numbers `V`, `D` and `d` below 2^22 near the target: the speed is never
//! above `V` nor changes by more than `D`. It lands exactly, from rest never beyond the target. Far
//! away `d` has the rounding of `f32`, and the lines are lowered by more than all roundings.

/// The limits in whole units per step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Approach {
    /// V.
    fastest: i32,
    /// D.
    change: i32,
    /// D/2 and 1/D.
    half: f32,
    per_change: f32,
}

/// Factor that lowers the lines, by 16 roundings of an `f32`: their computation has fewer than
/// four.
const CAUTION: f32 = 1.0 - 1.0 / 1_048_576.0;

impl Approach {
    /// Prepares the approach for the largest speed and its largest change, in whole units.
    pub fn new(fastest: i32, change: i32) -> Self {
        let half = 0.5 * change as f32;
        Self { fastest, change, half, per_change: 1.0 / change as f32 }
    }

    /// Returns the wanted speed towards a target that is `distance` ahead (behind, if negative). If
    /// the present speed cannot reach it within a step, the result is inexact, but on the right
    /// side.
    #[inline]
    pub fn wanted(&self, distance: f32, speed: i32) -> i32 {
        // All ones behind, and zero ahead: two's complement turns by it.
        let behind = (distance.to_bits() as i32) >> 31;
        let distance = distance.abs();
        let towards = ((speed ^ behind) - behind) as f32;
        let whole = (towards * self.per_change) as i32;
        let n = if whole > 2 { whole - 1 } else { 1 } as f32;
        // The line of n = 0 is the distance itself.
        let mut line = n * self.half + distance / (n + 1.0);
        line = least(line, (n + 1.0) * self.half + distance / (n + 2.0));
        line = least(line, (n + 2.0) * self.half + distance / (n + 3.0));
        let wanted = least(line * CAUTION, distance) as i32;
        // Towards zero: no faster than wanted.
        let wanted = if wanted > self.fastest { self.fastest } else { wanted };
        (wanted ^ behind) - behind
    }

    /// Returns the next speed: the wanted one, as far as one step can change the present one.
    #[inline]
    pub const fn next(&self, wanted: i32, speed: i32) -> i32 {
        let (slowest, fastest) = (speed - self.change, speed + self.change);
        let next = if wanted > fastest { fastest } else { wanted };
        if next < slowest { slowest } else { next }
    }

    /// Returns the distance to rest if each further step lowers the present speed by `D`.
    pub fn stopping_distance(&self, speed: i32) -> i64 {
        let change = self.change.max(1);
        let steps = i64::from(speed / change);
        let signed = if speed < 0 { -i64::from(change) } else { change.into() };
        steps.abs() * i64::from(speed) - steps.abs() * (steps.abs() + 1) / 2 * signed
    }
}

/// Returns the smaller of two numbers, by one comparison.
#[inline]
fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}
