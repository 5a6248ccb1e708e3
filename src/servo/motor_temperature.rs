//! The motor's temperature in the servo: its faults, and the correction of the modelled heat.

use super::Servo;
use crate::safety::fault::LatchedFault;
use crate::safety::motor_temperature::{MotorTemperatureState, Warmth};

impl Servo {
    /// Takes the converter's reading of the motor's NTC, once a tick and after it, in every state.
    /// Without such a sensor, nothing happens.
    ///
    /// A fault ends the output of the next tick. The call is no part of the tick: a board makes it
    /// where there is time for a logarithm every 0.1 s.
    pub fn take_ntc(&mut self, reading: u16) {
        let Some(control_loop) = &mut self.control_loop else { return };
        let Some(sensor) = &control_loop.temperature else { return };
        match sensor.take(&mut self.motor_temperature, reading) {
            None => {}
            Some(Warmth::Part(part)) => {
                control_loop.monitors.warm_at_least(&mut control_loop.watch, part);
            }
            Some(Warmth::Fault(fault, value)) => {
                self.latch(LatchedFault { fault, tick: self.clock, value });
            }
        }
    }

    /// Returns the measured temperature of the motor, deg C; none without a sensor, within 0.1 s
    /// after power-on or new parameters, and while the sensor is open or shorted.
    pub const fn motor_temperature(&self) -> Option<f32> {
        self.motor_temperature.temperature()
    }

    /// Forgets the readings of former parameters.
    pub(super) fn forget_temperature(&mut self) {
        self.motor_temperature = MotorTemperatureState::default();
    }
}
