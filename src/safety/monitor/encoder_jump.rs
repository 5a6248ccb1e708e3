//! Travel in one tick that no motor could make: noise on the encoder's lines, a loose connector.
//!
//! Detected in the tick in which it is read. An encoder that gave no valid answer for some ticks
//! reports their travel at once: each of them adds one threshold.
//!
//! Does badly: a jump below the threshold passes for motion, and shifts the position for good.

use super::limits::{Limits, Units};

/// Monitor of the travel in one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct EncoderJump {
    most: u32,
}

impl EncoderJump {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        Self { most: Units::threshold(limits.encoder_jump, units.count) }
    }

    /// Returns whether a travel (counts) in a number of ticks is a jump.
    #[inline]
    pub const fn check(&self, travel: i32, ticks: u32) -> bool {
        travel.unsigned_abs() > self.most.saturating_mul(ticks)
    }
}
