//! Samples of a device as CSV: the columns of `stiction run --csv` that a device can send, then
//! those of further signals.
//!
//! `position_deg` is that of the encoder, not the true one. `stuck` is whether the velocity of the
//! regression is zero: a device has no other measure of sticking.

use stiction::link::Sample;

use super::signals::Signals;
use crate::output::Cell;
use crate::output::columns::{LEADING, SeriesColumn, is_leading};
use files::error::Error;

/// Samples received from a device, and their signals.
#[derive(Clone, Debug, Default)]
pub struct SampleLog {
    signals: Signals,
    /// Signals in columns after the leading ones.
    more: Vec<String>,
    samples: Vec<Sample>,
}

impl SampleLog {
    /// Creates an empty log with the columns of a run, the applied effort, the signals of the law
    /// in use, and those in `more`.
    ///
    /// # Errors
    /// Returns an error that names a signal the device does not have.
    pub fn new(signals: Signals, more: &[String]) -> Result<Self, Error> {
        more.iter().try_for_each(|name| signals.check(name))?;
        let mut all: Vec<String> = vec![];
        for name in signals.of_law().map(str::to_owned).chain(more.iter().cloned()) {
            if !all.contains(&name) && !is_leading(&name) {
                all.push(name);
            }
        }
        Ok(Self { signals, more: all, samples: Vec::new() })
    }

    /// Returns the mask of the signals that these columns need.
    pub fn mask(&self) -> u64 {
        let leading = LEADING.iter().flat_map(|column| column.made_of().iter().copied());
        self.signals.mask(leading.chain(self.more.iter().map(String::as_str)))
    }

    /// Adds a sample.
    pub fn push(&mut self, sample: Sample) {
        self.samples.push(sample);
    }

    /// Returns the number of samples.
    pub const fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns whether there is no sample.
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Returns the CSV file. Its time starts at the first sample.
    ///
    /// # Errors
    /// Returns an error if a number cannot be written.
    pub fn render(&self, sample_time: f32, resolution: f32) -> Result<Vec<u8>, Error> {
        let failed = |error: csv::Error| Error::Input(error.to_string());
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        let leading = LEADING.iter().map(|column| column.name());
        writer.write_record(leading.chain(self.more.iter().map(String::as_str))).map_err(failed)?;
        let begin = self.samples.first().map_or(0, |sample| sample.clock);
        let resolution = f64::from(resolution);
        for sample in &self.samples {
            let seconds = f64::from(sample.clock.wrapping_sub(begin)) * f64::from(sample_time);
            // A column is one signal, or the sum of a whole and a fractional position.
            let sum = |column: &SeriesColumn| {
                column.made_of().iter().map(|name| self.signals.number(sample, name)).sum::<f64>()
            };
            let row = LEADING.iter().map(|column| match column {
                // The sample time is in single precision.
                SeriesColumn::Time => Cell::from((seconds * 1e6).round() / 1e6),
                SeriesColumn::Reference | SeriesColumn::Position => {
                    Cell::from(sum(column) * resolution)
                }
                SeriesColumn::Stuck => Cell::from(sum(column) == 0.0),
                SeriesColumn::Error
                | SeriesColumn::Velocity
                | SeriesColumn::Applied
                | SeriesColumn::Signal(_) => self.signals.cell(sample, column.name()),
            });
            let more = self.more.iter().map(|name| self.signals.cell(sample, name));
            writer.serialize(row.chain(more).collect::<Vec<Cell>>()).map_err(failed)?;
        }
        writer.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}
