//! The measured temperature of the motor: too hot, and a sensor that fails.
//!
//! ```text
//! x   mean of the readings of 0.1 s (one at least)       R, T: control::motor_ntc
//! fault 35: x within 4 steps of either end, three times in a row
//! fault 34: T > limit_c
//! heat    = max(heat, (T - ambient_c) / (limit_c - ambient_c) continuous^2)
//! ```
//!
//! The last line corrects the [model of the winding's heat](super::monitor). `continuous` is the
//! steady effort that takes the winding from the room's temperature `ambient_c` to `limit_c`. So a
//! motor that is hotter than the model believes, because the room is hot, the case is warm, or the
//! power was off meanwhile, has less time for an overload. If `limits.continuous_v` is off, there
//! is no model to correct, and `limit_c` alone protects.
//!
//! The correction only raises the heat. A winding heats up within seconds and an NTC follows tens
//! of seconds later, and one that has come off its place shows the room: neither may make the model
//! less strict. In a cold room or with a fan, a larger `limits.continuous_v` uses what the motor
//! has.
//!
//! Every call judges one tick, in each state of the servo, also with the output off. Guarantees: an
//! open or shorted sensor is found within 0.4 s, a mean beyond the limit within 0.2 s (with sample
//! times above 0.1 s none exist). Does badly: an NTC that is off its place, or of another type, is
//! not detected.

use crate::control::motor_ntc::MotorNtc;
use crate::safety::fault::Fault;

/// Time over which readings are averaged, s. A winding changes by a kelvin in that time at most.
const MEAN: f32 = 0.1;

/// Distance from either end of the converter's range within which the sensor is open or shorted,
/// steps: half of what an intact one leaves.
const END: f32 = 4.0;

/// Number of means in a row that show an open or shorted sensor, of which one may be a disturbance.
const OPEN: u8 = 3;

/// The temperature sensor of a motor, prepared for its ticks.
#[derive(Clone, Copy, Debug)]
pub struct MotorTemperature {
    ntc: MotorNtc,
    /// Largest reading of the converter.
    top: f32,
    /// Ticks of a mean.
    ticks: u16,
}

/// Readings of the present mean, and what the last one has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorTemperatureState {
    sum: u32,
    ticks: u16,
    /// Means in a row that show an open or shorted sensor.
    open: u8,
    /// Temperature of the last mean, deg C; none before the first one, or without a valid reading.
    temperature: Option<f32>,
    /// Fault for which the servo must not be armed.
    forbids: Option<Fault>,
}

/// What a mean has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warmth {
    /// Part of the way from `ambient_c` to `limit_c`.
    Part(f32),
    /// A fault, with its value.
    Fault(Fault, f32),
}

impl MotorTemperature {
    /// Prepares a validated sensor for a sample time (s); none without one. `top` is the largest
    /// reading of the converter.
    pub fn of(ntc: MotorNtc, sample_time: f32, top: u16) -> Option<Self> {
        let ticks = libm::roundf(MEAN / sample_time).max(1.0);
        ntc.is_there().then(|| Self { ntc, top: f32::from(top), ticks: ticks as u16 })
    }

    /// Takes the reading of a tick. Returns what the mean has shown that ends with it.
    pub fn take(&self, state: &mut MotorTemperatureState, reading: u16) -> Option<Warmth> {
        state.sum += u32::from(reading);
        state.ticks += 1;
        if state.ticks < self.ticks {
            return None;
        }
        let mean = state.sum as f32 / f32::from(self.ticks);
        (state.sum, state.ticks) = (0, 0);
        let rest = self.top - mean;
        if mean < END || rest < END {
            state.open = state.open.saturating_add(1);
            (state.temperature, state.forbids) = (None, Some(Fault::MotorSensor));
            return (state.open >= OPEN).then_some(Warmth::Fault(Fault::MotorSensor, mean));
        }
        state.open = 0;
        let MotorNtc { divider, limit, ambient, .. } = self.ntc;
        let temperature = self.ntc.temperature(divider * mean / rest);
        state.temperature = Some(temperature);
        state.forbids = (temperature > limit).then_some(Fault::MotorHot);
        Some(if temperature > limit {
            Warmth::Fault(Fault::MotorHot, temperature)
        } else {
            Warmth::Part((temperature - ambient) / (limit - ambient))
        })
    }
}

impl MotorTemperatureState {
    /// Returns the temperature of the last mean, deg C; none before the first one, or without a
    /// valid reading.
    pub const fn temperature(&self) -> Option<f32> {
        self.temperature
    }

    /// Returns the fault that forbids arming: the last mean was too hot, or shows an open or
    /// shorted sensor, be it the first one.
    pub const fn forbids_arming(&self) -> Option<Fault> {
        self.forbids
    }
}
