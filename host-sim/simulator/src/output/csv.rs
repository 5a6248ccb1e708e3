//! Time series of runs as CSV, with units in the column names.

use stiction::control::signal;

use super::cell::Cell;
use super::columns::{OF_A_CLOSED_LOOP, SeriesColumn, of_a_run, to_the_nanosecond};
use crate::closed_loop::LoopSample;
use crate::run::{RunResult, RunTrace};

/// Returns the CSV: the header, then a line for each sample. With several runs, each line starts
/// with the label of its run. The motor's counts follow, if a run has two encoders, then the
/// motor's current, if a run has a sensor of it. The signals of the laws are in the last columns.
///
/// # Errors
/// Returns an error if a number cannot be written.
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
    let columns = of_a_run();
    let names = columns.iter().map(|column| column.name());
    let motor = results.iter().any(has_motor).then_some(MOTOR_COUNTS);
    let current = results.iter().any(has_current).then_some(CURRENT);
    let names = names.chain(motor).chain(current);
    writer.write_record(label.into_iter().chain(names).chain(of_laws.iter().copied()))?;
    for result in results {
        let own = signals_of(result);
        let (moments, is_ramp) = moments(result);
        let is_measured = has_current(result);
        for moment in moments {
            let label = labelled.then(|| Cell::from(result.plan.label.as_str()));
            let row = columns.iter().map(|column| cell(*column, moment, is_ramp));
            let of_laws = of_laws.iter().map(|name| {
                let place = own.iter().position(|other| other == name);
                place
                    .and_then(|place| moment.tick.law.get(place))
                    .map_or(Cell::None, |value| (*value).into())
            });
            let motor = motor.map(|_| moment.motor_counts.into());
            let current = current.map(|_| match is_measured {
                true => Cell::from(moment.tick.current),
                false => Cell::None,
            });
            let row = label.into_iter().chain(row).chain(motor).chain(current).chain(of_laws);
            writer.serialize(row.collect::<Vec<Cell>>())?;
        }
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// Returns the samples of a run, and whether they are of a ramp.
pub(super) fn moments(result: &RunResult) -> (&[LoopSample], bool) {
    match &result.trace {
        RunTrace::Loop(moments) => (moments, false),
        RunTrace::Ramp(moments) => (moments, true),
    }
}

/// Column of the motor's counts, in a run with an encoder on either side of the gear.
pub(super) const MOTOR_COUNTS: &str = "motor_counts";

/// Returns whether a run has a second encoder.
pub(super) fn has_motor(result: &RunResult) -> bool {
    moments(result).0.iter().any(|moment| moment.motor_counts.is_some())
}

/// Column of the motor's current.
pub(super) const CURRENT: &str = signal::name("current");

/// Returns whether a run has measured a current of its motor.
pub(super) fn has_current(result: &RunResult) -> bool {
    moments(result).0.iter().any(|moment| moment.tick.current != 0.0)
}

/// Returns the signals of the law of a run.
pub(super) fn signals_of(result: &RunResult) -> Vec<&'static str> {
    let laws = result.plan.laws_in_use();
    let publishing = laws.iter().map(|law| law.signals()).find(|signals| !signals.is_empty());
    publishing.unwrap_or_default().iter().map(|signal| signal.name).collect()
}

/// Returns the cell of a column. A ramp has no reference and no controller: those cells are empty.
pub(super) fn cell(column: SeriesColumn, moment: &LoopSample, is_ramp: bool) -> Cell {
    match column {
        SeriesColumn::Reference | SeriesColumn::Error if is_ramp => Cell::None,
        SeriesColumn::Signal(place) if is_ramp && OF_A_CLOSED_LOOP.contains(&place) => Cell::None,
        SeriesColumn::Time => to_the_nanosecond(moment.time_s).into(),
        SeriesColumn::Reference => moment.reference_deg.into(),
        SeriesColumn::Position => moment.position_deg.into(),
        SeriesColumn::Error => moment.error_deg().into(),
        SeriesColumn::Velocity => moment.velocity_deg_per_s.into(),
        SeriesColumn::Stuck => moment.stuck.into(),
        SeriesColumn::Applied => moment.applied_v.into(),
        SeriesColumn::Signal(place) => {
            match (signal::SIGNALS.get(place), signal::value(&moment.tick, place)) {
                (Some(signal), Some(bits)) => Cell::of(signal.form, bits),
                _ => Cell::None,
            }
        }
    }
}
