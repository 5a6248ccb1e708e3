//! A thermal model of the motor's winding: the square of the effort through a first-order lag
//! (I2t).
//!
//! ```text
//! heat += (effort^2 - heat) h / tau          trips when heat > continuous^2
//! ```
//!
//! Full effort `V` from cold trips after `tau ln(1 / (1 - (continuous / V)^2))`. The winding cools
//! while the bridge is off and stays warm when the servo is armed again. Does badly: it knows
//! neither the motor nor the room; a reset forgets the heat; on a bridge that gives a voltage, the
//! effort is the current of a motor that stands still.

use super::limits::{Limits, Units};

/// Heat against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thermal {
    most: f32,
    share: f32,
}

/// Filtered square of the code.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ThermalState {
    heat: f32,
}

impl Thermal {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let codes = limits.continuous_effort / units.code;
        let most = if codes > 0.0 { codes * codes } else { f32::INFINITY };
        Self { most, share: units.tick / limits.thermal_time }
    }

    /// Returns whether the winding is too hot to arm.
    pub fn is_hot(&self, state: &ThermalState) -> bool {
        state.heat > self.most
    }

    /// Takes the code of a tick.
    #[inline]
    pub fn check(&self, state: &mut ThermalState, code: i32) -> bool {
        let code = code as f32;
        state.heat += (code * code - state.heat) * self.share;
        state.heat > self.most
    }
}

impl ThermalState {
    /// The same heat where an effort has `ratio` times as many codes.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { heat: self.heat * ratio * ratio }
    }

    /// The effort that would make this heat if it lasted, in codes.
    pub fn effort(&self) -> f32 {
        libm::sqrtf(self.heat)
    }
}
