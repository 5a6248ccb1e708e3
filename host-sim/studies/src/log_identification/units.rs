//! Units of a log, and those of what is identified from it.

use std::f64::consts::TAU;

use super::reading::Log;

/// A log that begins later than this has the time of some other clock, s.
const LONG_AGO_S: f64 = 1e6;

/// The unit of a position column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
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
    /// As the command line has it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Mm => "mm",
            Self::Rad => "rad",
            Self::Deg => "deg",
            Self::Count => "count",
        }
    }

    /// The unit that a column's name ends with, as in `position_deg`.
    pub fn of_name(column: &str) -> Option<Self> {
        let name = column.to_ascii_lowercase();
        let last =
            name.rsplit(|c: char| !c.is_ascii_alphanumeric()).find(|part| !part.is_empty())?;
        // A name of one word is no unit.
        (last.len() < name.len()).then_some(())?;
        match last {
            "m" => Some(Self::M),
            "mm" => Some(Self::Mm),
            "rad" => Some(Self::Rad),
            "deg" => Some(Self::Deg),
            _ => None,
        }
    }
}

/// How the columns of a log become SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Seconds of a unit of time.
    pub time_s: f64,
    /// Metres or radians of a unit of position.
    pub position: f64,
    /// Whether the machine moves along a line.
    pub is_linear: bool,
    /// N or N m of a unit of effort, if it is known.
    pub effort: Option<f64>,
}

impl Scale {
    /// Of a position unit; `counts_per_turn` counts for [`PositionUnit::Count`].
    pub fn new(time_s: f64, unit: PositionUnit, counts_per_turn: f64, effort: Option<f64>) -> Self {
        let (position, is_linear) = match unit {
            PositionUnit::M => (1.0, true),
            PositionUnit::Mm => (1e-3, true),
            PositionUnit::Rad => (1.0, false),
            PositionUnit::Deg => (1f64.to_radians(), false),
            PositionUnit::Count => (TAU / counts_per_turn, false),
        };
        Self { time_s, position, is_linear, effort }
    }

    /// Brings a log to SI, or to the unit of its effort.
    pub fn apply(&self, log: &mut Log) {
        let effort = self.effort.unwrap_or(1.0);
        for (series, factor) in [
            (&mut log.time, self.time_s),
            (&mut log.position, self.position),
            (&mut log.effort, effort),
        ] {
            series.iter_mut().for_each(|value| *value *= factor);
        }
        // Of a clock that counts from somewhere long ago, nobody wants to read the seconds.
        let begin = log.time.first().copied().filter(|begin| begin.abs() > LONG_AGO_S);
        if let Some(begin) = begin {
            log.time.iter_mut().for_each(|time| *time -= begin);
        }
        log.smallest_change *= self.position;
        log.time_digit *= self.time_s;
    }

    /// The unit of positions.
    pub const fn position_unit(&self) -> &'static str {
        if self.is_linear { "m" } else { "rad" }
    }

    /// The unit of efforts; without a gain that of the log, but for a machine on a line, whose
    /// effort is taken as a force.
    pub const fn effort_unit(&self) -> &'static str {
        match (self.is_linear, self.effort) {
            (true, _) => "N",
            (false, Some(_)) => "N m",
            (false, None) => "effort",
        }
    }

    /// Whether the unit of the effort is a guess: that of a machine on a line without a gain.
    pub const fn is_assumed(&self) -> bool {
        self.is_linear && self.effort.is_none()
    }

    /// The unit of a parameter.
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
