//! Samples as CSV, in the columns of `stiction run --csv`, as far as a device knows them, and in
//! those of further signals.
//!
//! `position_deg` is that of the encoder, not the true one, and `stuck` is whether the regression
//! says zero: a device sees no more.

use stiction::link::Sample;

use super::signals::Signals;
use crate::error::Error;
use crate::output::Cell;
use crate::output::csv::COLUMNS;

/// The signals that the columns of `stiction run --csv` are made of.
const BASE: [&str; 9] = [
    "counts",
    "reference_counts",
    "reference_fraction_counts",
    "error_deg",
    "velocity_deg_per_s",
    "v_pd_v",
    "v_c_v",
    "v_v",
    "code",
];

/// The signal of what the joint got, which is not always what was asked for.
const APPLIED: &str = "v_applied_v";

/// The samples of a device so far, and the signals that they have.
#[derive(Clone, Debug, Default)]
pub struct Log {
    signals: Signals,
    /// Signals with a column of their own behind the others.
    more: Vec<String>,
    samples: Vec<Sample>,
}

impl Log {
    /// Makes an empty log of a device's signals: the columns of a run, what was applied, the
    /// signals of the law in use, and those in `more`.
    ///
    /// # Errors
    /// Names a signal that the device does not have.
    pub fn new(signals: Signals, more: &[String]) -> Result<Self, Error> {
        more.iter().try_for_each(|name| signals.check(name))?;
        let mut all: Vec<String> = vec![];
        for name in signals.of_law().map(str::to_owned).chain(more.iter().cloned()) {
            if !all.contains(&name) && !COLUMNS.contains(&name.as_str()) {
                all.push(name);
            }
        }
        Ok(Self { signals, more: all, samples: Vec::new() })
    }

    /// Tells which signals have to be subscribed for these columns.
    pub fn mask(&self) -> u64 {
        self.signals
            .mask(BASE.into_iter().chain([APPLIED]).chain(self.more.iter().map(String::as_str)))
    }

    /// Adds a sample.
    pub fn push(&mut self, sample: Sample) {
        self.samples.push(sample);
    }

    /// Counts the samples.
    pub const fn len(&self) -> usize {
        self.samples.len()
    }

    /// Tells whether there is no sample.
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Writes the file; its time begins with the first sample.
    ///
    /// # Errors
    /// If a number cannot be written.
    pub fn render(&self, sample_time: f32, resolution: f32) -> Result<Vec<u8>, Error> {
        let failed = |error: csv::Error| Error::Input(error.to_string());
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        let header = COLUMNS.into_iter().chain(self.more.iter().map(String::as_str));
        writer.write_record(header).map_err(failed)?;
        let begin = self.samples.first().map_or(0, |sample| sample.clock);
        let resolution = f64::from(resolution);
        for sample in &self.samples {
            let value = |name: &str| self.signals.number(sample, name);
            let cell = |name: &str| self.signals.cell(sample, name);
            let ticks = sample.clock.wrapping_sub(begin);
            let time_s = f64::from(ticks) * f64::from(sample_time);
            let reference = value("reference_counts") + value("reference_fraction_counts");
            let mut row = vec![
                Cell::from((time_s * 1e6).round() / 1e6),
                Cell::from(reference * resolution),
                Cell::from(value("counts") * resolution),
            ];
            row.extend(
                ["error_deg", "velocity_deg_per_s", "v_pd_v", "v_c_v", "v_v", "code"].map(cell),
            );
            row.push(Cell::from(value("velocity_deg_per_s") == 0.0));
            row.push(cell(APPLIED));
            row.extend(self.more.iter().map(|name| cell(name)));
            writer.serialize(row).map_err(failed)?;
        }
        writer.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}
