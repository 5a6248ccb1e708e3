//! The classical Runge-Kutta method with a variable step (`rk4-adaptive`), the thesis's own: each
//! step is done once whole and once in two halves, and the difference decides (Press et al.,
//! *Numerical Recipes*, section 16.2: `rkqc`).
//!
//! ```text
//! error = max |y_halves - y_whole| / (eps (|y| + |h y'| + floor))
//! next  = 0.9 h error^(-1/5) after a step that was kept, at most 4 h
//!       = 0.9 h error^(-1/4) after one that was not, at least h/10 (the book's later editions; the first has no bound)
//! y     = y_halves + (y_halves - y_whole) / 15
//! ```
//!
//! The book has no floor, and then a body at rest never breaks away: its velocity and acceleration
//! are zero at the begin of that step, and no error is small against them.

use super::SolverFailure;
use super::dynamics::Dynamics;
use super::explicit::{Progress, classical};
use super::state::{Finish, Observer};

/// Accuracy and floor of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// eps; the thesis has 2e-4.
    pub eps: f64,
    /// Evaluations before the run is given up.
    pub max_evaluations: u64,
}

/// A step that was not kept becomes no shorter than this part of it at once: far from a switch, the
/// error of a step over it says little about the one that is right.
const LEAST_SHRINK: f64 = 0.1;

/// Runs a differential equation for `duration_s`.
///
/// # Errors
/// If the step underflows, events do not end or the work exceeds its bound: with time and state.
pub fn run<const N: usize, const Z: usize, D: Dynamics<N, Z>, O: Observer<N>>(
    dynamics: &mut D,
    accuracy: Accuracy,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure> {
    let mut progress = Progress::start(dynamics, duration_s, observer);
    let mut wanted = duration_s / 1000.0;
    while progress.t < duration_s {
        let corner_s = dynamics.next_corner(progress.t);
        let end_s = corner_s.min(duration_s);
        let last_s = if corner_s <= duration_s { end_s.next_down() } else { end_s };
        let (t, from, first) = (progress.t, progress.state, progress.rates.rates);
        let mut h = wanted.min(end_s - t);
        let (state, error) = loop {
            if t + h == t {
                return Err(progress.trouble("the step underflows"));
            }
            let whole = classical(dynamics, t, last_s, &from, &first, h);
            let half = classical(dynamics, t, last_s, &from, &first, 0.5 * h);
            let middle = dynamics.evaluate((t + 0.5 * h).min(last_s), &half).rates;
            let halves = classical(dynamics, t + 0.5 * h, last_s, &half, &middle, 0.5 * h);
            progress.evaluations += 10;
            if progress.evaluations > accuracy.max_evaluations {
                let limit = accuracy.max_evaluations;
                return Err(progress.trouble(format!("more than {limit:e} evaluations")));
            }
            let difference = halves.zip(&whole, |a, b| a - b);
            let size = from.zip(&first, |y, rate| y.abs() + (h * rate).abs());
            let allowed = size.zip(&dynamics.scale(), |size, floor| accuracy.eps * (size + floor));
            let error = difference
                .zip(&allowed, |d, allowed| d.abs() / allowed)
                .components()
                .fold(0.0, worse);
            if error <= 1.0 {
                break (halves.plus(1.0 / 15.0, &difference), error);
            }
            if !halves.is_finite() && !from.is_finite() {
                return Ok(progress.finish());
            }
            let shrink = 0.9 * error.powf(-0.25);
            h *= if shrink.is_nan() { LEAST_SHRINK } else { shrink.max(LEAST_SHRINK) };
        };
        // 6e-4 = (4 / 0.9)^-5: below it the growth of 4 is reached.
        let growth = if error > 6e-4 { 0.9 * error.powf(-0.2) } else { 4.0 };
        let t_new = if h >= end_s - t { end_s } else { t + h };
        wanted = h * growth;
        progress.keep(dynamics, (t_new, last_s), state, observer)?;
    }
    Ok(progress.finish())
}

/// The larger of two errors; one that is not a number is the largest.
fn worse(a: f64, b: f64) -> f64 {
    if b.is_nan() || a.is_nan() { f64::NAN } else { a.max(b) }
}
