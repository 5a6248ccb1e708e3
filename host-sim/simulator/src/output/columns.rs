//! The columns of a time series, in the CSV of a run and in the log of a device.
//!
//! Those that every script may rely on come first, in the order of [`LEADING`]. Of a run, every
//! other signal of the core's list follows, so a signal that is added there has its column; then
//! come the signals of the laws.

use stiction::signal::{self, SIGNALS, Signal};

/// A column of a time series. A run knows the joint itself. A device knows its encoder only, and
/// writes what it measures under the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesColumn {
    /// Time since the begin, s.
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
    /// Effort that the joint gets, V.
    Applied,
    /// A signal of the core's list, by its place.
    Signal(usize),
}

/// The columns that every run and every log begins with.
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

/// The columns without which a file cannot be drawn.
pub const DRAWN: &[SeriesColumn] = LEADING.split_at(8).0;

/// The signals that only a closed loop has: a ramp leaves their cells empty.
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

    /// Returns the names of the signals that a device has to send for the column.
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
            // Those that are a column by themselves.
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

/// Returns the columns of a run: the leading ones, then every other signal of the core.
pub fn of_a_run() -> Vec<SeriesColumn> {
    let others = SIGNALS.iter().enumerate().filter(|(_, signal)| !is_leading(signal.name));
    LEADING.into_iter().chain(others.map(|(place, _)| SeriesColumn::Signal(place))).collect()
}

/// Returns a time to the nanosecond. Times are k h, which is not always the decimal that a reader
/// expects: 11.2, not 11.200000000000001.
pub fn to_the_nanosecond(time_s: f64) -> f64 {
    (time_s * 1e9).round() / 1e9
}
