//! Errors about invalid values, with the key and the value of the file.

use stiction::control::laws::RobustDualGains;
use stiction::parameters;
use stiction::parameters::names::{NamedBounds, NamedError};
use stiction::units::value::Table as _;
use toml::Value;

use super::plan::RunPlan;
use super::task::Task;
use files::data_sheet::{DataSheet, OF_A_SHEET};
use files::error::{Error, shown};

/// Keys of a data sheet from which limits, profile and drive are derived.
const DERIVED_FROM: [&str; 11] = [
    "supply.voltage_v",
    "motor.resistance_ohm",
    "motor.kt_nm_per_a",
    "motor.current_limit_a",
    "motor.amplifier_a_per_v",
    "motor.rotor_inertia_kg_m2",
    "gear.ratio",
    "gear.efficiency",
    "load.inertia_kg_m2",
    "friction.stick_nm",
    "encoder.lines",
];

impl RunPlan {
    /// Converts an error of the core to one with the key and the value of the file. The declaration
    /// of the value names the table of the key.
    pub fn explain(&self, error: &stiction::InvalidValue) -> Error {
        let of_two_encoders = || RobustDualGains::ABOUT.iter().find(|about| about.key == error.key);
        let Some(about) = parameters::about(error.key).or_else(of_two_encoders) else {
            return Error::Input(NamedError(*error).to_string());
        };
        let controller = self.controller.as_deref().unwrap_or_default();
        let path = match (about.table, about.name) {
            ("controller", key) => format!("controller.{controller}.{key}"),
            ("reference", _) => self.asked_by.clone(),
            ("reference.trajectories" | "reference.sines", key) => {
                format!("{}.{key}", self.asked_by)
            }
            ("identification", "ramp_rates_v_per_s") => self.asked_by.clone(),
            (table, key) => format!("{table}.{key}"),
        };
        let written = match (about.name, &self.task) {
            ("ramp_rates_v_per_s", Task::Ramp(rate)) => Some(*rate),
            _ => self
                .value_at(&path.split('.').collect::<Vec<_>>())
                .and_then(|value| value.as_float()),
        };
        let mut found = shown(error.found.into());
        if let Some(written) = written {
            let vanishes = error.found == 0.0 && written != 0.0;
            found = shown(written) + if vanishes { ", which is 0 in single precision" } else { "" };
        }
        self.refuse(&path, &found, &NamedBounds(error.allowed).to_string())
    }

    /// Returns a value of the machine by its key.
    fn value_at(&self, path: &[&str]) -> Option<Value> {
        let machine = Value::try_from(&*self.machine).ok()?;
        path.iter().try_fold(machine, |value, key| value.get(key).cloned())
    }

    pub(super) fn above_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found > 0.0, || "a number above 0".into())
    }

    pub(super) fn at_least_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found >= 0.0, || "a number not below 0".into())
    }

    pub(super) fn check(
        &self,
        key: &str,
        found: f64,
        allowed: bool,
        what: impl Fn() -> String,
    ) -> Result<(), Error> {
        if allowed && found.is_finite() {
            Ok(())
        } else {
            Err(self.refuse(key, &shown(found), &what()))
        }
    }

    pub(super) fn refuse(&self, key: &str, found: &str, allowed: &str) -> Error {
        // Infinity counts as a number in TOML.
        let finite = if found.ends_with("inf") {
            allowed.replacen("a number", "a finite number", 1)
        } else {
            allowed.into()
        };
        // The message names the value that the user wrote.
        let sheet = self.sheet().ok().flatten().map(|(sheet, _)| sheet);
        let suspect = sheet.as_ref().and_then(DataSheet::suspect);
        let derived_of = sheet.filter(|_| self.is_derived(key));
        Error::Input(match (suspect.filter(|suspect| suspect.key != key), derived_of) {
            (None, Some(sheet)) => self.refuse_derived(&sheet, key, found, &finite),
            (None, None) => {
                format!("{}: `{key}` is {found}; must be {finite}", self.origin.of(key))
            }
            (Some(suspect), Some(_)) => format!(
                "{}: {suspect}. It leads to `{key}` = {found}; must be {finite}",
                self.origin.of(suspect.key)
            ),
            (Some(suspect), None) => {
                let origin = self.origin.of(key);
                format!("{origin}: `{key}` is {found}; must be {finite} ({suspect})")
            }
        })
    }

    /// Returns the message for a key that follows from a data sheet. It names the key that was set
    /// by hand, or else lists the keys from which the value follows.
    fn refuse_derived(&self, sheet: &DataSheet, key: &str, found: &str, allowed: &str) -> String {
        let set = DERIVED_FROM.into_iter().find(|from| self.origin.has_set(from));
        set.map_or_else(
            || {
                format!(
                    "{}: `{key}` is {found}; must be {allowed}; it follows from {}: change one",
                    self.origin.of(key),
                    sheet.listed(&DERIVED_FROM)
                )
            },
            |from| {
                let origin = self.origin.of(from);
                format!("{origin}: this value leads to `{key}` = {found}; must be {allowed}")
            },
        )
    }

    /// Returns whether a key of a file with a data sheet follows from others.
    fn is_derived(&self, key: &str) -> bool {
        let table = key.split('.').next().unwrap_or_default();
        OF_A_SHEET.contains(&key)
            || ["limits", "profile", "jog", "current_sensor"].contains(&table)
                && self.value_at(&key.split('.').collect::<Vec<_>>()).is_none()
    }
}
