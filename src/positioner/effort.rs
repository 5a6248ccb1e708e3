//! Last stage of a positioner's tick: the effort is limited and rounded to its step.

use crate::units::saturation::saturate;

/// Limit and step of the effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSteps {
    largest: f32,
    step: f32,
    per_step: f32,
}

impl EffortSteps {
    /// Prepares a limit and a step, both above zero.
    pub fn new(largest: f32, step: f32) -> Self {
        Self { largest, step, per_step: 1.0 / step }
    }

    /// Returns the multiple of the step nearest to the requested effort, or the largest effort if
    /// that is less, and whether the requested effort exceeded the limit.
    pub fn apply(&self, asked: f32) -> (f32, bool) {
        let (effort, saturated) = saturate(asked, self.largest);
        let stepped = libm::roundf(effort * self.per_step) * self.step;
        // No negative zero.
        (saturate(stepped, self.largest).0 + 0.0, saturated)
    }
}
