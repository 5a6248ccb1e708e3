//! Errors about invalid values, with the key and the value of the file.

use toml::Value;

use super::plan::RunPlan;
use super::task::Task;
use crate::data_sheet::OF_A_SHEET;
use crate::error::{Error, shown};

impl RunPlan {
    /// Converts an error of the core to one with the key and the value of the file. The declaration
    /// of the value has its table.
    pub fn explain(&self, error: &stiction::Error) -> Error {
        let Some(about) = error.key.about() else { return Error::Input(error.to_string()) };
        let controller = self.controller.as_deref().unwrap_or_default();
        let path = match (about.table, about.name) {
            ("controller", key) => format!("controller.{controller}.{key}"),
            ("reference", _) => self.asked_by.clone(),
            ("reference.trajectories", key) => format!("{}.{key}", self.asked_by),
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
        self.refuse(&path, &found, &error.allowed.to_string())
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
        // The message is about a key that the file sets.
        let suspect = self.sheet().ok().flatten().and_then(|(sheet, _)| sheet.suspect());
        Error::Input(match suspect.filter(|suspect| suspect.key != key) {
            None => format!("{}: `{key}` is {found}; allowed is {finite}", self.origin.of(key)),
            Some(suspect) if self.is_derived(key) => format!(
                "{}: {suspect}. It makes `{key}` {found}; allowed is {finite}",
                self.origin.of(suspect.key)
            ),
            Some(suspect) => {
                let origin = self.origin.of(key);
                format!("{origin}: `{key}` is {found}; allowed is {finite} ({suspect})")
            }
        })
    }

    /// Returns whether a key is derived from a data sheet.
    fn is_derived(&self, key: &str) -> bool {
        let table = key.split('.').next().unwrap_or_default();
        OF_A_SHEET.contains(&key)
            || ["limits", "profile", "jog"].contains(&table)
                && self.value_at(&key.split('.').collect::<Vec<_>>()).is_none()
    }
}
