//! Speed beyond what the loop was made for: an overhauling load, or a loop that runs away.
//!
//! Detected in the tick in which the regression says so: for a jump in speed, within its window.

use super::limits::Limits;

/// Measured speed against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overspeed {
    fastest: f32,
}

impl Overspeed {
    pub fn new(limits: &Limits) -> Self {
        Self { fastest: if limits.overspeed > 0.0 { limits.overspeed } else { f32::INFINITY } }
    }

    #[inline]
    pub fn check(&self, velocity: f32) -> bool {
        velocity.abs() > self.fastest
    }
}
