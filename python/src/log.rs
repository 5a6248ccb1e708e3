//! Identification of a joint from arrays of time, position and effort.

use pyo3::prelude::*;

use super::arrays::numbers;
use super::error::{in_python, refused, word};
use super::interrupt::interruptible;
use files::error::Error;
use studies::log_identification::reading::of_series;
use studies::log_identification::units::{LogUnits, PositionUnit, seconds};
use studies::log_identification::{FitSettings, identify as identified, output};

/// Settings of an identification as Python has them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    time_unit: String,
    position_unit: String,
    counts_per_turn: Option<f64>,
    effort_gain: Option<f64>,
    effort_delay: Option<f64>,
    cut_off: Option<f64>,
    asymmetric: Option<bool>,
    stribeck: bool,
    gravity: bool,
}

impl Settings {
    fn checked(&self) -> PyResult<FitSettings> {
        let time_s = seconds(&self.time_unit).ok_or_else(|| {
            refused(&format!("--time-unit {}: must be s, ms, us or ns", self.time_unit))
        })?;
        let unit: PositionUnit = word("position-unit", &self.position_unit)?;
        let scale = LogUnits::checked(time_s, unit, self.counts_per_turn, self.effort_gain);
        let settings = FitSettings {
            has_motor_current: false,
            scale: scale.map_err(|why| refused(&why))?,
            is_asymmetric: self.asymmetric,
            has_stribeck: self.stribeck,
            has_gravity: self.gravity,
            cut_off_hz: self.cut_off,
            effort_delay_s: self.effort_delay,
        };
        settings.checked().map_err(|why| refused(&why))
    }
}

/// Identifies the joint of a log; returns the JSON object of `stiction identify`.
#[pyfunction]
pub fn identify(
    py: Python<'_>,
    time: &[u8],
    position: &[u8],
    effort: &[u8],
    settings: Settings,
) -> PyResult<String> {
    let settings = settings.checked()?;
    let [time, position, effort] = [time, position, effort].map(numbers);
    let found = interruptible(py, |_| {
        let log = of_series([&time, &position, &effort]).map_err(Error::Input)?;
        identified(log, &settings).map_err(Error::Input)
    })?;
    Ok(in_python(&output::object("arrays", &found).to_string()))
}
