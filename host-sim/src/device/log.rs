//! Samples as CSV, in the columns of `stiction run --csv`, as far as a device knows them.
//!
//! `position_deg` is that of the encoder, not the true one, and `stuck` is whether the regression says zero: a device
//! sees no more.

use stiction::link::{Sample, Term};

use crate::error::Error;

/// The samples so far.
#[derive(Clone, Debug, Default)]
pub struct Log {
    samples: Vec<Sample>,
}

#[derive(serde::Serialize)]
struct Row {
    time_s: f64,
    reference_deg: f64,
    position_deg: f64,
    error_deg: f32,
    velocity_deg_per_s: f32,
    v_pd_v: f32,
    v_c_v: f32,
    v_v: f32,
    code: i32,
    stuck: bool,
}

impl Log {
    /// What has to be subscribed for these columns.
    pub const TERMS: u16 = Term::SetpointCounts.bit()
        | Term::SetpointFraction.bit()
        | Term::Counts.bit()
        | Term::Error.bit()
        | Term::Velocity.bit()
        | Term::Pd.bit()
        | Term::Compensator.bit()
        | Term::Output.bit()
        | Term::Code.bit();

    /// Adds one.
    pub fn push(&mut self, sample: Sample) {
        self.samples.push(sample);
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The file; time begins with the first sample.
    ///
    /// # Errors
    /// If a number cannot be written.
    pub fn render(&self, sample_time: f32, resolution: f32) -> Result<Vec<u8>, Error> {
        let failed = |error: csv::Error| Error::Input(error.to_string());
        let mut writer = csv::Writer::from_writer(Vec::new());
        let begin = self.samples.first().map_or(0, |sample| sample.clock);
        for sample in &self.samples {
            let whole = |term| sample.value(term).map_or(0, i32::from_le_bytes);
            let real = |term| sample.value(term).map_or(0.0, f32::from_le_bytes);
            let ticks = sample.clock.wrapping_sub(begin);
            let resolution = f64::from(resolution);
            let setpoint = f64::from(whole(Term::SetpointCounts)) + f64::from(real(Term::SetpointFraction));
            let time_s = f64::from(ticks) * f64::from(sample_time);
            let row = Row {
                time_s: (time_s * 1e6).round() / 1e6,
                reference_deg: setpoint * resolution,
                position_deg: f64::from(whole(Term::Counts)) * resolution,
                error_deg: real(Term::Error),
                velocity_deg_per_s: real(Term::Velocity),
                v_pd_v: real(Term::Pd),
                v_c_v: real(Term::Compensator),
                v_v: real(Term::Output),
                code: whole(Term::Code),
                stuck: real(Term::Velocity) == 0.0,
            };
            writer.serialize(row).map_err(failed)?;
        }
        writer.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}
