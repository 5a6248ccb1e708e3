//! Free run: simulation of the identified machine with the logged effort, from the logged first
//! state.
//!
//! ```text
//! J dv/dt in u(t) - g(q) - F(v)      F(0) = [-F-, F+], the effort below which it sticks
//! ```
//!
//! An implicit step of friction (nonsmooth time stepping, J. J. Moreau 1988): the new velocity is
//! that of a slip the positive way if it is positive, of a slip the negative way if it is negative,
//! and else 0. The step is a twentieth of J/B, but no less than 1/50 and no more than 1/4 of a
//! sample. Errors are of the first order in it.
//!
//! No feedback ties the simulated position to the logged one, so an effort error accumulates in it.
//! Friction damps a velocity error, so the velocity is the fairer check of a long log. Both are
//! reported.

use super::model::FittedModel;
use super::moments::FilteredLog;
use super::time_grid::TimeGrid;

/// Least number of steps per sample.
const STEPS: f64 = 4.0;

/// Steps per time constant J/B, and the largest number per sample.
const TO_A_TIME_CONSTANT: f64 = 20.0;
const MOST_STEPS: f64 = 50.0;

/// Largest number of points of a free run that are kept for figures. A longer log is thinned out.
const KEPT: usize = 20_000;

/// Comparison of the free run with the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FreeRun {
    /// Root mean square of simulated minus logged position, SI.
    pub rms: f64,
    /// Explained share of the position's variance, at most 1.
    pub r2: f64,
    /// Root mean square of simulated minus logged velocity, SI.
    pub velocity_rms: f64,
    /// Explained share of the velocity's variance, at most 1.
    pub velocity_r2: f64,
    /// Time (s), logged and simulated position of some samples; NaN in a gap.
    pub kept: Vec<[f64; 3]>,
}

/// Sums for the error and for the variance of the log.
#[derive(Default)]
struct Sums {
    count: f64,
    error: f64,
    mean: f64,
    spread: f64,
}

impl Sums {
    fn add(&mut self, logged: f64, simulated: f64) {
        self.count += 1.0;
        self.error += (simulated - logged).powi(2);
        // Welford's method, since positions can be far from 0.
        let before = logged - self.mean;
        self.mean += before / self.count;
        self.spread += before * (logged - self.mean);
    }

    fn rms(&self) -> f64 {
        (self.error / self.count.max(1.0)).sqrt()
    }

    fn explained(&self) -> f64 {
        1.0 - self.error / self.spread
    }
}

/// Simulates the machine over the whole log; each stretch starts from the logged state.
pub fn free_run(
    fitted: &FittedModel,
    grid: &TimeGrid,
    filtered: &FilteredLog,
    delay_s: f64,
) -> FreeRun {
    let h = grid.step_s;
    let inertia = fitted.inertia();
    let [b, other] = fitted.viscous();
    let steps = (TO_A_TIME_CONSTANT * h * b.max(other) / inertia).clamp(STEPS, MOST_STEPS).ceil();
    let part = h / steps;
    let total: usize = grid.stretches.iter().map(|one| one.position.len()).sum();
    let stride = total.div_ceil(KEPT).max(1);
    let (mut position, mut velocity) = (Sums::default(), Sums::default());
    let mut kept = Vec::new();
    for (stretch, smooth) in grid.stretches.iter().zip(&filtered.stretches) {
        let mut q = smooth.position.first().copied().unwrap_or(0.0);
        let mut v = smooth.velocity.first().copied().unwrap_or(0.0);
        if !kept.is_empty() {
            kept.push([stretch.begin_s, f64::NAN, f64::NAN]);
        }
        let driving = stretch.driving();
        for (i, logged) in stretch.position.iter().enumerate() {
            position.add(*logged, q);
            velocity.add(smooth.velocity[i], v);
            if i % stride == 0 {
                kept.push([stretch.begin_s + h * i as f64, *logged, q]);
            }
            for k in 0..steps as usize {
                let at = i as f64 + (k as f64 + 0.5) / steps - delay_s / h;
                let effort = at_place(&driving, at) - fitted.gravity(q);
                let before = v;
                v = step(fitted, v, effort, part, inertia);
                q += 0.5 * part * (before + v);
            }
        }
    }
    FreeRun {
        rms: position.rms(),
        r2: position.explained(),
        velocity_rms: velocity.rms(),
        velocity_r2: velocity.explained(),
        kept,
    }
}

/// Returns the velocity after a step.
fn step(fitted: &FittedModel, v: f64, effort: f64, h: f64, inertia: f64) -> f64 {
    let [forward, backward] = fitted.levels();
    let [b_forward, b_backward] = fitted.viscous();
    let stribeck = fitted.stribeck(v);
    let slip = |level: f64, b: f64| (v + h / inertia * (effort - level)) / (1.0 + h * b / inertia);
    let up = slip(forward + stribeck, b_forward);
    let down = slip(-backward - stribeck, b_backward);
    if up > 0.0 {
        up
    } else if down < 0.0 {
        down
    } else {
        0.0
    }
}

/// Interpolates a series between two samples.
fn at_place(series: &[f64], at: f64) -> f64 {
    let last = series.len() - 1;
    let at = at.clamp(0.0, last as f64);
    let i = at as usize;
    let share = at - i as f64;
    series[i] + share * (series[(i + 1).min(last)] - series[i])
}
