//! The motor's current in a live view: whether it is measured, and its target.

use stiction::Parameters;
use stiction::control::controller::EffortMode;

/// The measured current of a device that has a sensor of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownCurrent {
    /// Target of a current loop for an effort of 1 V, A; none if the effort is a voltage.
    pub target_a_per_v: Option<f64>,
}

impl ShownCurrent {
    /// Returns what the parameters define; `None` without a sensor.
    pub fn of(parameters: &Parameters) -> Option<Self> {
        let Parameters { current, controller, .. } = parameters;
        let is_regulated = controller.effort == EffortMode::Current;
        let target_a_per_v = is_regulated.then(|| 1.0 / f64::from(current.resistance));
        current.is_there().then_some(Self { target_a_per_v })
    }
}
