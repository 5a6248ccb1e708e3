//! Detects keys of a data sheet that are probably in another unit, by wide ranges of real joints.
//!
//! A key outside its range causes a warning. If the data sheet is refused for a consequence of it,
//! the error names this key first: a supply of 0.001 V must not be reported as too much friction.

use std::fmt;

use super::sheet::DataSheet;
use crate::error::shown;

/// A key far outside of the range of real joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// The key.
    pub key: &'static str,
    /// Value in the data sheet.
    pub found: f64,
    /// Lowest and highest usual value.
    pub usual: [f64; 2],
    /// Unit of the value and of the range.
    pub unit: &'static str,
}

impl Suspect {
    /// Returns the question about the unit, for a warning.
    fn question(&self) -> String {
        let [_, most] = self.usual;
        match self.key {
            "supply.voltage_v" if self.found > most => {
                format!("{} V: are these mV? The key is in V", shown(self.found))
            }
            "gear.backlash_deg" if self.found > most => {
                format!("{} deg: are these arcmin? The key is in deg", shown(self.found))
            }
            _ if self.unit.is_empty() => "Is this number right? The key has no unit".into(),
            _ => format!("Is this number in another unit? The key is in {}", self.unit),
        }
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.usual.map(shown);
        let Self { key, unit, .. } = *self;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        write!(f, "`{key}` is {}{unit}; usual is {least} to {most}{unit}", shown(self.found))
    }
}

impl DataSheet {
    /// Returns the first key outside the range of real joints; `None` if all are inside. Zero does
    /// not count; other checks refuse it.
    pub fn suspect(&self) -> Option<Suspect> {
        self.suspects().next()
    }

    /// Returns all keys outside the ranges of real joints.
    pub(super) fn suspects(&self) -> impl Iterator<Item = Suspect> {
        self.numbers().into_iter().filter_map(|(key, found, usual, unit)| {
            let found = found.filter(|found| *found != 0.0)?;
            let is_usual = (usual[0]..=usual[1]).contains(&found);
            (!is_usual).then_some(Suspect { key, found, usual, unit })
        })
    }

    /// Lists the given keys with their numbers: `motor.kt_nm_per_a` (0.016), `gear.ratio` (50).
    pub fn listed(&self, keys: &[&str]) -> String {
        let some = self.numbers().into_iter().filter(|(key, ..)| keys.contains(key));
        let shown =
            some.filter_map(|(key, found, ..)| Some(format!("`{key}` ({})", shown(found?))));
        shown.collect::<Vec<_>>().join(", ")
    }

    /// Returns keys with their values in the data sheet, their usual ranges and their units.
    fn numbers(&self) -> [(&'static str, Option<f64>, [f64; 2], &'static str); 18] {
        let (motor, gear, load, friction) = (&self.motor, &self.gear, &self.load, &self.friction);
        let supply = self.supply.as_ref();
        [
            ("supply.voltage_v", supply.map(|supply| supply.voltage_v), [1.0, 1e3], "V"),
            ("motor.resistance_ohm", motor.resistance_ohm, [1e-3, 1e4], "ohm"),
            ("motor.kt_nm_per_a", Some(motor.kt_nm_per_a), [1e-5, 1e3], "N m/A"),
            ("motor.current_limit_a", motor.current_limit_a, [1e-3, 1e4], "A"),
            ("motor.amplifier_a_per_v", motor.amplifier_a_per_v, [1e-4, 1e4], "A/V"),
            ("motor.inductance_h", Some(motor.inductance_h), [1e-9, 10.0], "H"),
            ("motor.rotor_inertia_kg_m2", Some(motor.rotor_inertia_kg_m2), [1e-11, 1e3], "kg m^2"),
            ("gear.ratio", Some(gear.ratio), [1e-2, 1e5], ""),
            ("gear.efficiency", Some(gear.efficiency), [1e-2, 1.0], ""),
            ("gear.backlash_deg", gear.backlash_deg, [1e-5, 10.0], "deg"),
            ("gear.stiffness_nm_per_rad", gear.stiffness_nm_per_rad, [1e-3, 1e10], "N m/rad"),
            ("load.inertia_kg_m2", Some(load.inertia_kg_m2), [1e-10, 1e6], "kg m^2"),
            ("load.constant_nm", Some(load.constant_nm.abs()), [0.0, 1e6], "N m"),
            ("load.unbalance_nm", Some(load.unbalance_nm), [0.0, 1e6], "N m"),
            ("friction.stick_nm", Some(friction.stick_nm), [0.0, 1e6], "N m"),
            ("friction.slip_nm", Some(friction.slip_nm), [0.0, 1e6], "N m"),
            ("friction.viscous_nm_s_per_rad", Some(self.viscous()), [0.0, 1e6], "N m s/rad"),
            ("encoder.lines", self.encoder.lines.map(f64::from), [1.0, 1e7], ""),
        ]
    }

    /// Returns the warning about a key that is probably in another unit.
    pub(super) fn unit_is_doubtful(&self) -> Option<String> {
        self.suspect().map(|suspect| format!("{suspect}. {}", suspect.question()))
    }
}
