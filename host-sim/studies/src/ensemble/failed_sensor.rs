//! An encoder that fails: from one tick on, it counts a part of its travel.

use dynamics::joint::DiscSide;

/// A failed encoder of a joint that has one on the motor and one on the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailedSensor {
    /// Side of the encoder.
    pub side: DiscSide,
    /// Part of its travel that it counts: 0 if it is dead, -1 if it is reversed, between 0 and 1 if
    /// its disc slips.
    pub part: f64,
    /// Count at which it failed; `None` before its first reading.
    from: Option<i64>,
}

impl FailedSensor {
    /// Creates an encoder that fails at its next reading.
    pub const fn new(side: DiscSide, part: f64) -> Self {
        Self { side, part, from: None }
    }

    /// Returns the reading for the true count, of an encoder on `side`.
    pub fn read(&mut self, side: DiscSide, count: i64) -> i64 {
        if side != self.side {
            return count;
        }
        let from = *self.from.get_or_insert(count);
        from + (self.part * (count - from) as f64).round() as i64
    }
}
