//! The classical Runge-Kutta method with a fixed step (`rk4`).
//!
//! Steps are split evenly between the corners of the mechanism's drive. Nothing else is located: a
//! switch of friction is noticed at the end of the step in which it happens, and the step's order
//! is lost there.
//!
//! Does badly: Karnopp's band must be wider than what a step does to a velocity, or the body jumps
//! over it and creeps; the Reset Integrator wants steps of 1e-4 s (springs) or 1e-5 s (arms) to be
//! stable.

use super::SolverFailure;
use super::dynamics::Dynamics;
use super::explicit::{Progress, classical};
use super::state::{Finish, Observer};

/// Runs a differential equation for `duration_s` with steps of at most `step_s`.
///
/// # Errors
/// If events do not end: with time and state. A state that is no longer finite ends the run, and is
/// no error.
pub fn run<const N: usize, const Z: usize, D: Dynamics<N, Z>, O: Observer<N>>(
    dynamics: &mut D,
    step_s: f64,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure> {
    let mut progress = Progress::start(dynamics, duration_s, observer);
    while progress.t < duration_s {
        let begin_s = progress.t;
        let corner_s = dynamics.next_corner(begin_s);
        let end_s = corner_s.min(duration_s);
        let last_s = if corner_s <= duration_s { end_s.next_down() } else { end_s };
        // A hair less than a whole number of steps is that number.
        let steps = ((end_s - begin_s) / step_s - 1e-9).ceil().max(1.0);
        let h = (end_s - begin_s) / steps;
        for i in 1..=steps as u64 {
            let (t, first) = (progress.t, progress.rates.rates);
            let state = classical(dynamics, t, last_s, &progress.state, &first, h);
            progress.evaluations += 3;
            let t = if i == steps as u64 { end_s } else { begin_s + i as f64 * h };
            progress.keep(dynamics, (t, last_s), state, observer)?;
            if !progress.state.is_finite() {
                return Ok(progress.finish());
            }
        }
    }
    Ok(progress.finish())
}
