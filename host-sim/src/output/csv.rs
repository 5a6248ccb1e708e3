//! The time series of runs as CSV, units in the column names.

use super::cell::Cell;
use crate::run::{RunResult, Trace};

/// The columns that every script may rely on, here and in the log of a device; further ones stand
/// behind them.
pub const COLUMNS: [&str; 11] = [
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
    "v_applied_v",
];

/// Writes the header, then a line a sample. Of several runs, each line begins with its run's label.
/// What the laws publish of themselves stands behind the other columns.
///
/// # Errors
/// If a number cannot be written.
pub fn render(results: &[RunResult]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let mut of_laws: Vec<&str> = Vec::new();
    for name in results.iter().flat_map(|result| signals_of(result)) {
        if !of_laws.contains(&name) {
            of_laws.push(name);
        }
    }
    let labelled = results.len() > 1;
    let label = labelled.then_some("label");
    writer.write_record(label.into_iter().chain(COLUMNS).chain(of_laws.iter().copied()))?;
    for result in results {
        let own = signals_of(result);
        for (row, law) in rows(&result.trace) {
            let label = labelled.then(|| Cell::from(result.plan.label.as_str()));
            let of_laws = of_laws.iter().map(|name| {
                let place = own.iter().position(|other| other == name);
                place.and_then(|place| law.get(place)).map_or(Cell::None, |value| (*value).into())
            });
            writer.serialize(label.into_iter().chain(row).chain(of_laws).collect::<Vec<Cell>>())?;
        }
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// What the law of a run publishes of itself.
fn signals_of(result: &RunResult) -> Vec<&'static str> {
    let laws = result.plan.laws_in_use();
    let publishing = laws.iter().map(|law| law.signals()).find(|signals| !signals.is_empty());
    publishing.unwrap_or_default().iter().map(|signal| signal.name).collect()
}

type Row = ([Cell; COLUMNS.len()], [f32; stiction::signal::MAX_LAW_SIGNALS]);

/// A ramp has no reference and no controller: those cells are empty.
fn rows(trace: &Trace) -> Vec<Row> {
    match trace {
        Trace::Loop(moments) => moments
            .iter()
            .map(|m| {
                let row = [
                    to_the_nanosecond(m.time_s).into(),
                    m.reference_deg.into(),
                    m.position_deg.into(),
                    m.error_deg().into(),
                    m.velocity_deg_per_s.into(),
                    m.tick.v_pd.into(),
                    m.tick.v_c.into(),
                    f64::from(m.tick.v).into(),
                    i64::from(m.tick.code).into(),
                    m.stuck.into(),
                    m.applied_v.into(),
                ];
                (row, m.tick.law)
            })
            .collect(),
        Trace::Ramp(moments) => moments
            .iter()
            .map(|m| {
                let row = [
                    to_the_nanosecond(m.time_s).into(),
                    Cell::None,
                    m.position_deg.into(),
                    Cell::None,
                    m.velocity_deg_per_s.into(),
                    Cell::None,
                    Cell::None,
                    m.v.into(),
                    i64::from(m.code).into(),
                    m.stuck.into(),
                    m.applied_v.into(),
                ];
                (row, Default::default())
            })
            .collect(),
    }
}

/// Times are k h, which is not always the decimal that a reader expects: 11.2, not
/// 11.200000000000001.
fn to_the_nanosecond(time_s: f64) -> f64 {
    (time_s * 1e9).round() / 1e9
}
