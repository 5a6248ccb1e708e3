//! Unit of a logged effort, and its torque at the joint of a machine's file.
//!
//! | unit | N m at the joint |
//! |---|---|
//! | V, output of the controller | G of the data sheet (docs/reference/units.md) |
//! | A, current of the motor | n eta K_t |
//! | N m, torque at the joint | 1 |
//!
//! The unit is the end of the column's name, as in `u_v` or `current [A]`. Without one, it is the
//! unit whose gain is within 2 % of `--effort-gain`, V before A, or else a torque.

use super::units::unit_of_name;
use files::data_sheet::{DataSheet, Mapping};

/// Relative difference up to which two gains are equal.
const SAME: f64 = 0.02;

/// Unit of a logged effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffortUnit {
    /// Volts at the output of the controller.
    Volt,
    /// Amperes in the motor.
    Ampere,
    /// Newton metres at the joint.
    NewtonMetre,
}

impl EffortUnit {
    /// Returns the unit at the end of a column's name.
    pub fn of_name(column: &str) -> Option<Self> {
        let unit = unit_of_name(column)?;
        let name = column.to_lowercase();
        let end = name.trim_end_matches(|c: char| !c.is_alphanumeric());
        if ["n m", "n*m", "n\u{b7}m"].iter().any(|torque| end.ends_with(torque)) {
            return Some(Self::NewtonMetre);
        }
        match &*unit {
            "v" => Some(Self::Volt),
            "a" => Some(Self::Ampere),
            "nm" => Some(Self::NewtonMetre),
            _ => None,
        }
    }

    /// Returns the unit with the given gain; a torque if neither volt nor ampere has it.
    pub fn of_gain(gain: f64, sheet: &DataSheet, mapping: &Mapping) -> Self {
        [Self::Volt, Self::Ampere]
            .into_iter()
            .find(|unit| unit.agrees(gain, sheet, mapping))
            .unwrap_or(Self::NewtonMetre)
    }

    /// Returns the torque at the joint for one unit of the effort, N m.
    pub fn gain(self, sheet: &DataSheet, mapping: &Mapping) -> f64 {
        match self {
            Self::Volt => mapping.units.effort(1.0),
            Self::Ampere => sheet.gear.ratio * sheet.gear.efficiency * sheet.motor.kt_nm_per_a,
            Self::NewtonMetre => 1.0,
        }
    }

    /// Returns whether a gain fits this unit. Its sign is ignored: it is the direction of the
    /// effort.
    pub fn agrees(self, gain: f64, sheet: &DataSheet, mapping: &Mapping) -> bool {
        (gain.abs() / self.gain(sheet, mapping) - 1.0).abs() <= SAME
    }

    /// Returns the symbol of the unit.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Volt => "V",
            Self::Ampere => "A",
            Self::NewtonMetre => "N m",
        }
    }

    /// Returns the keys of a file that determine the gain.
    pub const fn keys(self) -> &'static str {
        match self {
            Self::Volt => {
                "motor.kt_nm_per_a, motor.resistance_ohm (or amplifier_a_per_v) and [gear]"
            }
            Self::Ampere => "motor.kt_nm_per_a and [gear]",
            Self::NewtonMetre => "[gear]",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_names_the_unit_of_its_effort() {
        use EffortUnit::{Ampere, NewtonMetre, Volt};
        for (name, unit) in [
            ("v_applied_v", Some(Volt)),
            ("Strom [A]", Some(Ampere)),
            ("torque [N m]", Some(NewtonMetre)),
            ("tau_nm", Some(NewtonMetre)),
            ("u", None),
            ("effort", None),
        ] {
            assert_eq!(EffortUnit::of_name(name), unit, "{name}");
        }
    }
}
