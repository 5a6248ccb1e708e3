//! A thermal model of the motor's winding: the square of its current, measured or estimated,
//! through a first-order lag (I2t).
//!
//! ```text
//! R i = effort - k_e v                       volts; k_e v is the back-EMF at the joint's speed v;
//!                                            with a sensor, i is its current
//! heat += ((R i)^2 - heat) h / tau           trips when heat > continuous^2
//! ```
//!
//! `continuous` is R times the current that the motor tolerates forever. An effort `V` at
//! standstill trips from cold after `tau ln(1 / (1 - (continuous / V)^2))`; its sign does not
//! matter. The winding cools while the bridge is off, except in a
//! [short brake](crate::safety::fault::Reaction::ShortBrake), whose current counts as any other. It
//! stays warm when the servo is armed again, when parameters change, and across a reset
//! ([`Boot`](crate::servo::Boot)).
//!
//! Does badly: it models neither the room nor the housing, and without power the heat is forgotten.
//! Without a sensor of the current it measures nothing: an inductance makes the current less than
//! modelled, and a motion that the encoder counts and that does not exist has a back-EMF that does
//! not exist either.

use super::limits::{Limits, Units};

/// Monitor of the winding's heat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thermal {
    most: f32,
    share: f32,
    /// Back-EMF of a speed of one deg/s, codes.
    back_emf: f32,
}

/// Heat: the filtered square of the current, in codes squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ThermalState {
    heat: f32,
}

impl Thermal {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let codes = limits.continuous_effort / units.code;
        let most = if codes > 0.0 { codes * codes } else { f32::INFINITY };
        let back_emf = limits.back_emf / units.code;
        Self { most, share: units.tick / limits.thermal_time, back_emf }
    }

    /// Returns whether the winding is too hot to arm.
    pub fn is_hot(&self, state: &ThermalState) -> bool {
        state.heat > self.most
    }

    /// Takes the code of a tick and the joint's speed, deg/s.
    #[inline]
    pub fn check(&self, state: &mut ThermalState, code: i32, velocity: f32) -> bool {
        self.check_measured(state, code as f32 - self.back_emf * velocity)
    }

    /// Takes the current of a tick, as the code at standstill that causes it.
    #[inline]
    pub fn check_measured(&self, state: &mut ThermalState, current: f32) -> bool {
        state.heat += (current * current - state.heat) * self.share;
        state.heat > self.most
    }

    /// Returns the current that the back-EMF drives through a shorted winding at a speed of the
    /// joint, deg/s, as the code at standstill that causes it.
    pub fn induced(&self, velocity: f32) -> f32 {
        -self.back_emf * velocity
    }

    /// Adds the heat of a tick in which a current flowed, after [`cool`](Self::cool): both together
    /// are [`check_measured`](Self::check_measured). The current is the code at standstill that
    /// causes it.
    pub fn heat(&self, state: &mut ThermalState, current: f32) {
        state.heat += current * current * self.share;
    }

    /// Raises the heat to a part of the largest one, if it is less. Without a largest heat, nothing
    /// happens.
    pub fn warm_at_least(&self, state: &mut ThermalState, part: f32) {
        if self.most.is_finite() {
            state.heat = state.heat.max(part * self.most);
        }
    }

    /// Cools for a tick without current.
    pub fn cool(&self, state: &mut ThermalState) {
        state.heat -= state.heat * self.share;
    }
}

impl ThermalState {
    /// Returns the same heat in other units, in which an effort has `ratio` times as many codes.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { heat: self.heat * ratio * ratio }
    }

    /// Returns the heat of a steady effort that is given in codes.
    pub const fn of_effort(codes: f32) -> Self {
        Self { heat: codes * codes }
    }

    /// Returns the steady effort that would cause this heat, codes.
    pub fn effort(&self) -> f32 {
        libm::sqrtf(self.heat)
    }
}
