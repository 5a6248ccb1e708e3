//! Time series of a run as arrays of numbers, under the names of the [`csv`](super::csv) columns.

use super::cell::Cell;
use super::columns::of_a_run;
use super::csv::{CURRENT, MOTOR_COUNTS, cell, has_current, has_motor, moments, signals_of};
use crate::run::RunResult;

/// Returns the columns of a run with their names, then the motor's counts if it has two encoders,
/// then the motor's current if it has a sensor of it, then the signals of its law. An empty cell is
/// NaN; a flag is 0 or 1.
pub fn arrays(result: &RunResult) -> Vec<(&'static str, Vec<f64>)> {
    let (moments, is_ramp) = moments(result);
    let of_columns = of_a_run().into_iter().map(|column| {
        let numbers = moments.iter().map(|moment| number(&cell(column, moment, is_ramp)));
        (column.name(), numbers.collect())
    });
    let of_the_law = signals_of(result).into_iter().enumerate().map(|(place, name)| {
        let value = |law: &[f32]| law.get(place).map_or(f64::NAN, |value| f64::from(*value));
        (name, moments.iter().map(|moment| value(&moment.tick.law)).collect())
    });
    let of_the_motor = has_motor(result).then(|| {
        let numbers = moments.iter().map(|moment| number(&moment.motor_counts.into()));
        (MOTOR_COUNTS, numbers.collect())
    });
    let current = has_current(result)
        .then(|| (CURRENT, moments.iter().map(|moment| moment.tick.current.into()).collect()));
    of_columns.chain(of_the_motor).chain(current).chain(of_the_law).collect()
}

const fn number(cell: &Cell) -> f64 {
    match cell {
        Cell::None | Cell::Text(_) => f64::NAN,
        Cell::Double(number) => *number,
        Cell::Single(number) => *number as f64,
        Cell::Whole(number) => *number as f64,
        Cell::Flag(true) => 1.0,
        Cell::Flag(false) => 0.0,
    }
}
