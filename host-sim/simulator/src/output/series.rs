//! Reads a time series written by [`csv`](super::csv) or by the log of a device.

use std::path::Path;

use super::columns::{DRAWN, SeriesColumn};
use files::error::Error;

/// One sample of a run or a log; a ramp lacks the optional signals.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub struct SeriesSample {
    /// Label of the run, if the file has several.
    #[serde(default)]
    label: Option<String>,
    /// Time since the start of the run or log, s.
    pub time_s: f64,
    /// Set point, deg.
    pub reference_deg: Option<f64>,
    /// Position of the joint in a run, of the encoder in a log, deg.
    pub position_deg: f64,
    /// Reference minus position, deg.
    pub error_deg: Option<f64>,
    /// Velocity of the joint in a run, the measured one in a log, deg/s.
    pub velocity_deg_per_s: f64,
    /// PD's part of the effort, V.
    pub v_pd_v: Option<f64>,
    /// The compensator's part of the effort, V.
    pub v_c_v: Option<f64>,
    /// The sum of both, limited to the full scale, V.
    pub v_v: f64,
}

/// Samples of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name of the file, and label of the run if the file has several.
    pub name: String,
    /// Samples in the order of the file.
    pub samples: Vec<SeriesSample>,
}

/// Reads the runs of a file.
///
/// # Errors
/// Returns an error with the file, and the column or line that differs from the format of `stiction
/// run --csv` and `stiction device ... log`.
pub fn read(path: &Path) -> Result<Vec<Series>, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::File {
        action: "read",
        path: path.into(),
        source,
    })?;
    let shown = path.display();
    let refuse = |why: String| Error::Input(format!("{shown}: {why}"));
    let mut reader = csv::Reader::from_reader(&*bytes);
    let header = reader.headers().map_err(|error| refuse(error.to_string()))?;
    if let Some(missing) = DRAWN
        .iter()
        .map(|column| column.name())
        .find(|name| !header.iter().any(|found| found == *name))
    {
        return Err(refuse(format!(
            "there is no column `{missing}`; the file must be from `stiction run --csv` with a \
             controller, or from `stiction device ... log`"
        )));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut all: Vec<Series> = Vec::new();
    let position = SeriesColumn::Position.name();
    let header = header.clone();
    let position = header.iter().position(|found| found == position);
    for record in reader.into_records() {
        // The error names the line.
        let record = record.map_err(|error| refuse(error.to_string()))?;
        // A tick without a loop has no position, and a studio writes none.
        if position.is_some_and(|place| record.get(place) == Some("")) {
            continue;
        }
        let sample: SeriesSample =
            record.deserialize(Some(&header)).map_err(|error| refuse(error.to_string()))?;
        let name =
            sample.label.as_ref().map_or_else(|| stem.clone(), |label| format!("{stem}, {label}"));
        match all.iter_mut().find(|series| series.name == name) {
            Some(series) => series.samples.push(sample),
            None => all.push(Series { name, samples: vec![sample] }),
        }
    }
    if all.is_empty() {
        return Err(refuse("the file has no samples".into()));
    }
    Ok(all)
}
