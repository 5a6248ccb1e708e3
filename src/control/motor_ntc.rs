//! The temperature sensor of the motor: an NTC in its winding, with a resistor to the converter's
//! reference.
//!
//! ```text
//! 3.3 V --- divider_ohm ---+--- NTC --- ground        x: reading, x_top: the largest one
//!                          +--- converter
//!
//! R   = divider_ohm x / (x_top - x)
//! 1/T = 1/298.15 K + ln(R / R_25) / B                 the B-parameter equation (IEC 60539-1)
//! ```
//!
//! A user configures it in `[motor_ntc]` of a machine's file. A joint without that table has no
//! sensor.
//!
//! Does badly: B is constant here. That of an NTC changes by some percent over 100 K, so a `beta_k`
//! for 25 and 85 deg C is off by 2 to 3 K at 120 deg C. The current through the NTC heats it: with
//! 10 kOhm and 10 kOhm by 0.3 mW, which is 0.1 to 0.3 K in air.

use crate::units::error::HUGE;
use crate::units::value::{Table, table};

/// Absolute zero and the reference temperature of an NTC, deg C.
const ZERO_C: f32 = -273.15;
const REFERENCE_C: f32 = 25.0;

/// Lowest temperature at which an intact NTC has to be distinguishable from an open one, deg C.
const COLDEST_C: f32 = -20.0;

/// Largest ratio of the two resistors with either being the larger one: eight steps of a converter
/// of 12 bits remain then.
const RATIO: f32 = 511.0;

table! {
    /// The temperature sensor of the motor and the temperatures of its motor.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MotorNtc (ntc) "motor_ntc" if (ntc.is_there()) {
        /// Resistance of the NTC at 25 deg C, ohm.
        resistance_25: f32 = 0x0F01 "resistance_25_ohm", Above(0.0, HUGE), Needed(10_000.0);
        /// B of the NTC, K: from its data sheet, for 25 and 85 deg C if there are several.
        beta: f32 = 0x0F02 "beta_k", Between(1000.0, 10_000.0), Default(3950.0);
        /// Resistor from the NTC to 3.3 V, ohm. The best resolution is where it equals the NTC's
        /// resistance.
        divider: f32 = 0x0F03 "divider_ohm",
            Between(ntc.resistance(COLDEST_C) / RATIO, ntc.resistance(ntc.limit) * RATIO),
            Default(10_000.0);
        /// Temperature of the winding that turns the output off, deg C: the largest one of the
        /// motor's data sheet.
        limit: f32 = 0x0F04 "limit_c", Between(40.0, 200.0), Needed(100.0);
        /// Temperature of the room for which `limits.continuous_v` holds, deg C: that of the rated
        /// current in the motor's data sheet.
        ambient: f32 = 0x0F05 "ambient_c", Between(-20.0, ntc.limit - 10.0), Default(25.0);
    }
}

impl MotorNtc {
    /// A motor without a temperature sensor.
    pub const NONE: Self = Self { resistance_25: 0.0, ..Self::EXAMPLE };

    /// Returns whether the motor has a sensor.
    #[inline]
    pub const fn is_there(&self) -> bool {
        self.resistance_25 > 0.0
    }

    /// Returns the resistance of the NTC at a temperature (deg C), ohm.
    fn resistance(&self, celsius: f32) -> f32 {
        let apart = 1.0 / (celsius - ZERO_C) - 1.0 / (REFERENCE_C - ZERO_C);
        self.resistance_25 * libm::expf(self.beta * apart)
    }

    /// Returns the temperature of a resistance of the NTC (ohm), deg C.
    pub fn temperature(&self, resistance: f32) -> f32 {
        let warmth = libm::logf(resistance / self.resistance_25) / self.beta;
        1.0 / (1.0 / (REFERENCE_C - ZERO_C) + warmth) + ZERO_C
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Data sheet of an NTC of 10 kOhm with B(25/85) = 3435 K (Murata NCP18XH103): ohm at deg C.
    const DATA_SHEET: [(f32, f32); 5] =
        [(0.0, 27_219.0), (25.0, 10_000.0), (50.0, 4161.0), (85.0, 1452.0), (125.0, 531.0)];

    #[test]
    fn the_temperature_is_that_of_a_data_sheet_within_three_kelvin() {
        let ntc = MotorNtc { beta: 3435.0, ..MotorNtc::EXAMPLE };
        for (celsius, ohm) in DATA_SHEET {
            let found = ntc.temperature(ohm);
            assert!((found - celsius).abs() < 3.0, "{celsius} C: {found}");
        }
    }

    #[test]
    fn the_temperature_of_a_resistance_has_that_resistance() {
        for celsius in [-20.0, 25.0, 80.0, 200.0] {
            let found = MotorNtc::EXAMPLE.temperature(MotorNtc::EXAMPLE.resistance(celsius));
            assert!((found - celsius).abs() < 0.01, "{celsius} C: {found}");
        }
    }
}
