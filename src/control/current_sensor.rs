//! The sensor of the motor's current: a shunt in line with the motor, its amplifier, and a
//! converter.
//!
//! ```text
//! i = +-(reading - offset) full_scale / middle      middle: half of the converter's readings
//! ```
//!
//! The amplifier puts out half of the converter's range at no current, about. The exact offset is
//! measured at rest, with the bridge off, before each arming
//! ([`motor_current`](crate::safety::motor_current)). A user configures the sensor in
//! `[current_sensor]` of a machine's file. A joint without that table has no sensor.

use crate::control::encoder::Direction;
use crate::units::error::HUGE;
use crate::units::value::{Table, table};

/// Derived limit at which the bridge is turned off, as a part of the sensor's range: the rest of
/// the range is for the offset, which may be a twentieth of the range on either side.
const TRIP: f32 = 0.9;

/// Derived limit of the effort's current, as a part of the limit that turns the bridge off. A
/// winding of half the configured resistance reaches that one before the measured current has
/// corrected the effort.
const PEAK: f32 = 0.5;

table! {
    /// The sensor of the motor's current, and the limits of that current.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CurrentSensor (sensor) "current_sensor" if (sensor.is_there()) {
        /// Current at either end of the converter's range, A: half of the converter's reference,
        /// divided by shunt and gain. 1.65 V, 10 mOhm and a gain of 20 are 8.25 A.
        full_scale: f32 = 0x0D01 "full_scale_a", Above(0.0, HUGE), Needed(8.25);
        /// Which way the reading changes if the current drives the joint the positive way.
        direction: Direction = 0x0D02 "direction", Any, Default(Direction::Forward);
        /// Current that turns the bridge off, A, within a period of the PWM. Derived: 0.9 of
        /// `full_scale_a`.
        trip: f32 = 0x0D03 "trip_a",
            Between(sensor.full_scale / 20.0, sensor.full_scale), Derived(7.425);
        /// Largest current that an effort may cause, A. The effort is limited by the resistance of
        /// the winding, and then by the measured current. Derived: half of `trip_a`.
        peak: f32 = 0x0D04 "peak_a", OrOff(0.0, sensor.trip), Derived(3.712_5);
        /// Resistance of the winding with bridge, shunt and cable, ohm. Derived:
        /// `motor.resistance_ohm`. A derived `continuous_v` is the rated current times this one.
        resistance: f32 = 0x0D05 "resistance_ohm", Above(0.0, HUGE), Derived(2.0);
        /// Inductance of the winding with filter and cable, H, for the current loop of `loop.effort
        /// = "current"`; 0: unknown. Derived: `motor.inductance_h`.
        inductance: f32 = 0x0D06 "inductance_h", Between(0.0, HUGE), Derived(0.001);
        /// Bandwidth of that loop, Hz: 3 dB are lost there. Up to a tenth of `drive.pwm_hz`.
        bandwidth: f32 = 0x0D07 "bandwidth_hz", Above(0.0, HUGE), Default(1000.0);
    }
}

/// What the last tick has done to the motor, and the joint since.
#[derive(Clone, Copy, Debug)]
pub struct Driven {
    /// Effort since the last tick, V: the voltage of the bridge.
    pub effort: f32,
    /// Effort that a current loop is to make a current of, V; that effort without a loop.
    pub target: f32,
    /// Speed of the joint, deg/s.
    pub speed: f32,
    /// Ratio of the measured supply to the nominal one; 1 if either is unknown.
    pub supply: f32,
    /// Travel since the last tick, counts.
    pub travel: i32,
}

impl CurrentSensor {
    /// A motor without a sensor of its current.
    pub const NONE: Self = Self::derived(0.0, [0.0; 2]);

    /// Returns whether the motor has a sensor.
    #[inline]
    pub const fn is_there(&self) -> bool {
        self.full_scale > 0.0
    }

    /// Returns the current of a reading, A, with the sign of the sensor's direction. `top` is the
    /// largest reading of the converter.
    pub fn unit(&self, top: u16) -> f32 {
        let unit = self.full_scale / (0.5 * f32::from(top));
        match self.direction {
            Direction::Forward => unit,
            Direction::Reverse => -unit,
        }
    }

    /// Returns the sensor with this full scale (A) and the limits that follow from it, for a
    /// winding with a resistance (ohm) and an inductance (H).
    #[must_use]
    pub const fn derived(full_scale: f32, [resistance, inductance]: [f32; 2]) -> Self {
        let trip = TRIP * full_scale;
        let (direction, bandwidth) = (Direction::Forward, Self::EXAMPLE.bandwidth);
        Self { full_scale, direction, trip, peak: PEAK * trip, resistance, inductance, bandwidth }
    }
}
