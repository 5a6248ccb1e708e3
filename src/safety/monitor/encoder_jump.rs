//! Travel in one tick that no motor could make: noise on the encoder's lines, a loose connector.
//!
//! Detected in the tick in which it is read. Does badly: a jump below the threshold passes for
//! motion, and shifts the position for good.

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

    #[inline]
    pub const fn check(&self, travel: i32) -> bool {
        travel.unsigned_abs() > self.most
    }
}
