//! Columns of a time series, in the CSV of a run and in the log of a device.
//!
//! The columns of [`LEADING`] come first, so that every script can rely on them. In a run, all
//! other signals of the core's list follow, then the signals of the laws.

use stiction::control::signal::{self, SIGNALS, Signal};

/// A column of a time series. A run has the values of the joint. A device has those of its encoder,
/// under the same names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesColumn {
    /// Time since the start, s.
    Time,
    /// Set point theta_d, deg.
    Reference,
    /// Position theta_a, deg.
    Position,
    /// Reference minus position, deg.
    Error,
    /// Velocity, deg/s.
    Velocity,
    /// Whether the joint sticks; on a device, whether the measured velocity is zero.
    Stuck,
    /// Effort on the joint, V.
    Applied,
    /// A signal of the core's list, by its place.
    Signal(usize),
}

/// First columns of every run and every log.
pub const LEADING: [SeriesColumn; 11] = [
    SeriesColumn::Time,
    SeriesColumn::Reference,
    SeriesColumn::Position,
    SeriesColumn::Error,
    SeriesColumn::Velocity,
    SeriesColumn::Signal(signal::index("v_pd")),
    SeriesColumn::Signal(signal::index("v_c")),
    SeriesColumn::Signal(signal::index("v")),
    SeriesColumn::Signal(signal::index("code")),
    SeriesColumn::Stuck,
    SeriesColumn::Applied,
];

/// Columns that are needed to draw a file.
pub const DRAWN: &[SeriesColumn] = LEADING.split_at(8).0;

/// Signals of a closed loop only; their cells are empty for a ramp.
pub const OF_A_CLOSED_LOOP: [usize; 6] = [
    signal::index("reference_counts"),
    signal::index("reference_fraction"),
    signal::index("reference_velocity"),
    signal::index("reference_acceleration"),
    signal::index("v_pd"),
    signal::index("v_c"),
];

impl SeriesColumn {
    /// Returns the column's name, with its unit.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time_s",
            Self::Reference => "reference_deg",
            Self::Position => "position_deg",
            Self::Error => signal::name("error"),
            Self::Velocity => signal::name("velocity"),
            Self::Stuck => "stuck",
            Self::Applied => signal::name("v_applied"),
            Self::Signal(place) => match SIGNALS.split_at(place).1 {
                [Signal { name, .. }, ..] => name,
                [] => "",
            },
        }
    }

    /// Returns the names of the signals that the column needs from a device.
    pub const fn made_of(self) -> &'static [&'static str] {
        match self {
            Self::Time => &[],
            Self::Reference => &[
                const { signal::name("reference_counts") },
                const { signal::name("reference_fraction") },
            ],
            Self::Position => &[const { signal::name("counts") }],
            Self::Error => &[const { signal::name("error") }],
            Self::Velocity | Self::Stuck => &[const { signal::name("velocity") }],
            Self::Applied => &[const { signal::name("v_applied") }],
            // Signals with a column of their own.
            Self::Signal(place) => match SIGNALS.split_at(place).1 {
                [Signal { name, .. }, ..] => core::slice::from_ref(name),
                [] => &[],
            },
        }
    }
}

/// Returns whether a name is that of a leading column.
pub fn is_leading(name: &str) -> bool {
    LEADING.iter().any(|column| column.name() == name)
}

/// Returns the columns of every run: the leading ones, then every other signal of the core. Left
/// out are the motor's current, which has a column only if it is measured, and the motor's
/// position, which is a column of a run with two encoders only.
pub fn of_a_run() -> Vec<SeriesColumn> {
    const LEFT_OUT: [&str; 2] = [signal::name("current"), signal::name("motor_counts")];
    let is_other = |name| !is_leading(name) && !LEFT_OUT.contains(&name);
    let others = SIGNALS.iter().enumerate().filter(|(_, signal)| is_other(signal.name));
    LEADING.into_iter().chain(others.map(|(place, _)| SeriesColumn::Signal(place))).collect()
}

/// Rounds a time to the nanosecond. Times are k h, which is not always the expected decimal: 11.2,
/// not 11.200000000000001.
pub fn to_the_nanosecond(time_s: f64) -> f64 {
    (time_s * 1e9).round() / 1e9
}
