//! The time series of runs as CSV, units in the column names.

use crate::run::{RunResult, Trace};

/// One sample of any run.
#[derive(serde::Serialize)]
struct Row {
    time_s: f64,
    reference_deg: Option<f64>,
    position_deg: f64,
    error_deg: Option<f64>,
    velocity_deg_per_s: f64,
    v_pd_v: Option<f32>,
    v_c_v: Option<f32>,
    v_v: f64,
    code: i16,
    stuck: bool,
}

/// The header, then a line a sample. Of several runs, each line begins with its run's label.
///
/// # Errors
/// If a number cannot be written.
pub fn render(results: &[RunResult]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let columns = [
        "time_s",
        "reference_deg",
        "position_deg",
        "error_deg",
        "velocity_deg_per_s",
        "v_pd_v",
        "v_c_v",
        "v_v",
        "code",
        "stuck",
    ];
    let labelled = results.len() > 1;
    let header = labelled.then_some("label").into_iter().chain(columns);
    writer.write_record(header)?;
    for result in results {
        for row in rows(&result.trace) {
            if labelled {
                writer.serialize((&result.plan.label, row))?;
            } else {
                writer.serialize(row)?;
            }
        }
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// A ramp has no reference and no controller: those cells are empty.
fn rows(trace: &Trace) -> Vec<Row> {
    match trace {
        Trace::Loop(moments) => moments
            .iter()
            .map(|m| Row {
                time_s: to_the_nanosecond(m.time_s),
                reference_deg: Some(m.reference_deg),
                position_deg: m.position_deg,
                error_deg: Some(m.error_deg()),
                velocity_deg_per_s: m.velocity_deg_per_s,
                v_pd_v: Some(m.tick.v_pd),
                v_c_v: Some(m.tick.v_c),
                v_v: f64::from(m.tick.v),
                code: m.tick.code,
                stuck: m.stuck,
            })
            .collect(),
        Trace::Ramp(moments) => moments
            .iter()
            .map(|m| Row {
                time_s: to_the_nanosecond(m.time_s),
                reference_deg: None,
                position_deg: m.position_deg,
                error_deg: None,
                velocity_deg_per_s: m.velocity_deg_per_s,
                v_pd_v: None,
                v_c_v: None,
                v_v: m.v,
                code: m.code,
                stuck: m.stuck,
            })
            .collect(),
    }
}

/// Times are k h, which is not always the decimal that a reader expects: 11.2, not 11.200000000000001.
fn to_the_nanosecond(time_s: f64) -> f64 {
    (time_s * 1e9).round() / 1e9
}
