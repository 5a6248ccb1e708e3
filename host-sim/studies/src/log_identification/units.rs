//! Units of a log, and of the identified parameters.

use std::f64::consts::TAU;

use super::reading::MotionLog;

/// Largest start time that is kept, s. A later one is from an absolute clock and is shifted to 0.
const LONG_AGO_S: f64 = 1e6;

/// Unit of a position column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
pub enum PositionUnit {
    /// Metres: a machine that moves along a line.
    M,
    /// Millimetres: a machine that moves along a line.
    Mm,
    /// Radians.
    Rad,
    /// Degrees.
    Deg,
    /// Counts of an encoder, with `--counts-per-turn`.
    Count,
}

impl PositionUnit {
    /// Returns the name on the command line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Mm => "mm",
            Self::Rad => "rad",
            Self::Deg => "deg",
            Self::Count => "count",
        }
    }

    /// Returns the unit at the end of a column's name, as in `position_deg` or `angle [\u{b0}]`.
    pub fn of_name(column: &str) -> Option<Self> {
        match &*unit_of_name(column)? {
            "m" => Some(Self::M),
            "mm" => Some(Self::Mm),
            "rad" => Some(Self::Rad),
            "deg" | "\u{b0}" => Some(Self::Deg),
            _ => None,
        }
    }

    /// Returns the unit at the end of the name of a motor's column: counts or an angle. The `m` of
    /// `q_m` denotes the motor, not metres.
    pub fn of_motor(column: &str) -> Option<Self> {
        match &*unit_of_name(column)? {
            "count" | "counts" => Some(Self::Count),
            _ => Self::of_name(column).filter(|unit| !matches!(unit, Self::M | Self::Mm)),
        }
    }
}

/// Returns a unit of time (`s`, `ms`, `us` or `ns`) in seconds.
pub fn seconds(unit: &str) -> Option<f64> {
    match unit {
        "s" => Some(1.0),
        "ms" => Some(1e-3),
        "us" | "\u{b5}s" | "\u{3bc}s" => Some(1e-6),
        "ns" => Some(1e-9),
        _ => None,
    }
}

/// First parts of compound units such as `rad/s`.
const PER: [&str; 8] = ["1", "m", "mm", "rad", "deg", "\u{b0}", "count", "counts"];

/// Returns the last part of a column's name, which can be its unit: `deg` of `position_deg`, of
/// `position (deg)` and of `position/deg`, the degree sign of `angle [\u{b0}]`; `None` for a single
/// word, or for a compound unit such as `rad/s`.
pub fn unit_of_name(column: &str) -> Option<String> {
    let name = column.trim().to_lowercase();
    let is_part = |c: char| c.is_alphanumeric() || c == '\u{b0}';
    let last = |of: &str| -> Option<(String, String)> {
        let end = of.trim_end_matches(|c: char| !is_part(c));
        let last = end.rsplit(|c: char| !is_part(c)).next().filter(|last| !last.is_empty())?;
        Some((end[..end.len() - last.len()].to_owned(), last.to_owned()))
    };
    let (before, unit) = last(&name).filter(|(before, _)| !before.is_empty())?;
    let is_per =
        before.ends_with('/') && last(&before).is_some_and(|(_, per)| PER.contains(&per.as_str()));
    (!is_per).then_some(unit)
}

/// Units of a log: conversion of its columns to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogUnits {
    /// Unit of time, s.
    pub time_s: f64,
    /// Unit of position, m or rad.
    pub position: f64,
    /// Whether the machine moves along a line.
    pub is_linear: bool,
    /// Unit of effort, N or N m, if known.
    pub effort: Option<f64>,
    /// Unit of the motor's position, rad; `None` if the position is in counts.
    pub motor: Option<f64>,
}

impl LogUnits {
    /// Creates the units; `counts_per_turn` is used for [`PositionUnit::Count`].
    pub fn new(time_s: f64, unit: PositionUnit, counts_per_turn: f64, effort: Option<f64>) -> Self {
        let (position, is_linear) = match unit {
            PositionUnit::M => (1.0, true),
            PositionUnit::Mm => (1e-3, true),
            PositionUnit::Rad => (1.0, false),
            PositionUnit::Deg => (1f64.to_radians(), false),
            PositionUnit::Count => (TAU / counts_per_turn, false),
        };
        Self { time_s, position, is_linear, effort, motor: None }
    }

    /// Creates the units of a log as a user describes them.
    ///
    /// # Errors
    /// Returns a sentence with the invalid or missing value.
    pub fn checked(
        time_s: f64,
        unit: PositionUnit,
        counts_per_turn: Option<f64>,
        effort: Option<f64>,
    ) -> Result<Self, String> {
        match (unit, counts_per_turn) {
            (PositionUnit::Count, None) => {
                return Err("--position-unit count needs --counts-per-turn, the counts in a turn \
                            of the joint"
                    .into());
            }
            (PositionUnit::Count, Some(counts)) if !(counts > 0.0 && counts.is_finite()) => {
                return Err(format!("--counts-per-turn {counts}: must be a number above 0"));
            }
            (PositionUnit::Count, _) | (_, None) => {}
            (_, Some(_)) => {
                return Err("--counts-per-turn belongs to --position-unit count".into());
            }
        }
        if let Some(gain) = effort.filter(|gain| !gain.is_finite() || *gain == 0.0) {
            return Err(format!("--effort-gain {gain}: must be a number other than 0"));
        }
        Ok(Self::new(time_s, unit, counts_per_turn.unwrap_or(1.0), effort))
    }

    /// Converts a log to SI; an effort of unknown unit stays as it is.
    pub fn apply(&self, log: &mut MotionLog) {
        let effort = self.effort_per_unit();
        for (series, factor) in [
            (&mut log.time, self.time_s),
            (&mut log.position, self.position),
            (&mut log.effort, effort),
            (&mut log.motor, self.motor.unwrap_or(1.0)),
        ] {
            series.iter_mut().for_each(|value| *value *= factor);
        }
        // The times of an absolute clock are shifted to start at 0.
        let begin = log.time.first().copied().filter(|begin| begin.abs() > LONG_AGO_S);
        if let Some(begin) = begin {
            log.time.iter_mut().for_each(|time| *time -= begin);
        }
        log.smallest_change *= self.position;
        log.smallest_motor_change *= self.motor.unwrap_or(1.0);
        log.time_digit *= self.time_s;
    }

    /// Returns the effort of a unit of the log's effort.
    pub fn effort_per_unit(&self) -> f64 {
        self.effort.unwrap_or(1.0)
    }

    /// Returns these units with the unit of the motor's position.
    ///
    /// # Errors
    /// Returns a sentence if the unit is a length, since a motor turns.
    pub fn with_motor(self, unit: PositionUnit) -> Result<Self, String> {
        let motor = match unit {
            PositionUnit::Rad => Some(1.0),
            PositionUnit::Deg => Some(1f64.to_radians()),
            PositionUnit::Count => None,
            PositionUnit::M | PositionUnit::Mm => {
                return Err(
                    "--motor-position-unit must be rad, deg or count: the motor turns".into()
                );
            }
        };
        Ok(Self { motor, ..self })
    }

    /// Returns the factor from the motor's units per rad (or metre) of the joint to the unit of the
    /// gear's ratio.
    pub const fn motor_of_a_turn(&self) -> f64 {
        if self.is_linear || self.motor.is_some() { 1.0 } else { TAU }
    }

    /// Returns the unit of a gear's ratio.
    pub const fn ratio_unit(&self) -> &'static str {
        match (self.is_linear, self.motor) {
            (false, Some(_)) => "turns per turn",
            (false, None) => "counts per turn",
            (true, Some(_)) => "rad/m",
            (true, None) => "counts/m",
        }
    }

    /// Returns the unit of positions.
    pub const fn position_unit(&self) -> &'static str {
        if self.is_linear { "m" } else { "rad" }
    }

    /// Returns the unit of efforts. On a linear machine the effort is a force; otherwise, without a
    /// gain, its unit is that of the log.
    pub const fn effort_unit(&self) -> &'static str {
        match (self.is_linear, self.effort) {
            (true, _) => "N",
            (false, Some(_)) => "N m",
            (false, None) => "effort",
        }
    }

    /// Returns whether the unit of the effort is assumed to be 1 N: on a linear machine without a
    /// gain.
    pub const fn is_assumed(&self) -> bool {
        self.is_linear && self.effort.is_none()
    }

    /// Returns the unit of a parameter.
    pub fn unit_of(&self, parameter: &str) -> String {
        let (effort, position) = (self.effort_unit(), self.position_unit());
        match parameter {
            "inertia" if self.is_linear => "kg".into(),
            "inertia" if self.effort.is_some() => "kg m^2".into(),
            "inertia" => format!("{effort} s^2/{position}"),
            name if name.starts_with("viscous") => format!("{effort} s/{position}"),
            _ => effort.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_column_is_the_last_part_of_its_name_in_brackets_or_behind_a_line() {
        for (name, unit) in [
            ("position_deg", Some(PositionUnit::Deg)),
            ("Winkel [\u{b0}]", Some(PositionUnit::Deg)),
            ("angle (deg)", Some(PositionUnit::Deg)),
            ("q [rad]", Some(PositionUnit::Rad)),
            ("Weg [mm]", Some(PositionUnit::Mm)),
            ("x/m", Some(PositionUnit::M)),
            ("v/(m/s)", None),
            ("speed [\u{b0}/s]", None),
            ("deg", None),
            ("position", None),
        ] {
            assert_eq!(PositionUnit::of_name(name), unit, "{name}");
        }
        let time = |name: &str| unit_of_name(name).and_then(|unit| seconds(&unit));
        for (name, unit) in [
            ("t [ms]", Some(1e-3)),
            ("time_s", Some(1.0)),
            ("Zeit (\u{b5}s)", Some(1e-6)),
            ("stamp_ns", Some(1e-9)),
            ("time", None),
            ("ticks", None),
            ("rate [1/s]", None),
        ] {
            assert_eq!(time(name), unit, "{name}");
        }
    }
}
