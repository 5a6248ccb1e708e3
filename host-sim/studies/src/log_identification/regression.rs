//! Regression over the rows of a log; chooses model, Stribeck velocity and delay.
//!
//! *Model*: asymmetric if friction differs between the directions by more than two standard
//! deviations, otherwise symmetric. *Stribeck velocity*: the model is linear in all coefficients
//! but v_s. The search tries 24 values in geometric steps, from the speed that 2 % of the rows do
//! not reach to half of the fast speed, then golden section between the neighbours of the best
//! value. *Delay*: a log can contain the commanded effort, which acts half a sample later on
//! average, and later with a slow drive. The residual's power is a parabola in the delay near its
//! minimum; this parabola is fitted through the best of -2 to 3 samples and its neighbours. The
//! delay is used only if it removes 2 % of the residual's power; otherwise it is 0.

use super::FitSettings;
use super::least_squares::Fit;
use super::model::{FittedModel, MachineModel, RegressionSample};
use super::moments::FilteredLog;

/// Least number of rows.
const FEWEST: usize = 60;
/// Least number of rows in each direction.
const FEWEST_EACH_WAY: usize = 15;

/// Tried delays, samples.
const DELAYS: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

/// Least share of the residual's power that a delay removes.
const DELAY_COUNTS: f64 = 0.02;

/// Least difference of the directions in an asymmetric model, standard deviations.
const DIFFER: f64 = 2.0;

const STRIBECK_VALUES: usize = 24;
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Fits a model to rows.
///
/// # Errors
/// Returns an error that names the term the log cannot separate from the others.
pub fn fit(model: MachineModel, moments: &[RegressionSample]) -> Result<FittedModel, String> {
    let names = model.coefficients();
    let rows = || moments.iter().map(move |at| (model.columns(at), at.effort));
    match Fit::of(names.len(), rows) {
        Ok(fit) => Ok(FittedModel { model, fit }),
        Err(column) => Err(format!(
            "`{}` cannot be separated from the other parameters: the motion has too little \
             variety; log several speeds and accelerations, both ways",
            names.get(column).copied().unwrap_or_default()
        )),
    }
}

type Regressed = (FittedModel, Vec<(&'static str, f64)>, f64, Vec<RegressionSample>);

/// Chooses the delay and the model (symmetric or asymmetric friction), and fits the model. Returns
/// the fit, the relative residual of each model (%) with its name, the delay (s), and the rows of
/// the regression.
///
/// # Errors
/// Returns a sentence with what the log lacks, and a remedy.
pub fn regress(
    filtered: &FilteredLog,
    request: &FitSettings,
    step_s: f64,
) -> Result<Regressed, String> {
    enough(&filtered.moments(0.0))?;
    let terms =
        MachineModel { is_asymmetric: false, stribeck: None, has_gravity: request.has_gravity };
    let wide = MachineModel { is_asymmetric: true, ..terms };
    let delay_s = match request.effort_delay_s {
        Some(delay_s) => delay_s,
        None => delay(step_s, |delay_s| {
            fit(wide, &filtered.moments(delay_s)).map(|one| one.fit.residual)
        })?,
    };
    let moments = filtered.moments(delay_s);
    let both = [fit(terms, &moments)?, fit(wide, &moments)?];
    let compared =
        both.iter().map(|one| (one.model.name(), one.relative_residual_percent())).collect();
    let differ = both[1].asymmetry().iter().any(|deviations| *deviations > DIFFER);
    let is_asymmetric = request.is_asymmetric.unwrap_or(differ);
    let mut fitted = if is_asymmetric { both[1].clone() } else { both[0].clone() };
    if request.has_stribeck {
        fitted = stribeck(fitted.model, &moments, filtered.creeping)?;
    }
    Ok((fitted, compared, delay_s, moments))
}

/// Checks that there are enough rows in both directions.
fn enough(moments: &[RegressionSample]) -> Result<(), String> {
    if moments.len() < FEWEST {
        return Err(format!(
            "only {} samples are usable (steady motion), at least {FEWEST} are needed: log some \
             seconds of motion over several counts, both ways, with few reversals, or raise \
             --cut-off",
            moments.len()
        ));
    }
    for (way, sign) in [("positive", 1.0), ("negative", -1.0)] {
        let count = moments.iter().filter(|at| at.velocity * sign > 0.0).count();
        if count < FEWEST_EACH_WAY {
            return Err(format!(
                "only {count} samples move the {way} way: friction cannot be separated from a \
                 constant load; log motion both ways"
            ));
        }
    }
    Ok(())
}

/// Returns the delay (s) with the least residual; 0 if no delay removes enough of the residual's
/// power. `residual_of` returns the residual's power for a delay (s).
///
/// # Errors
/// Returns the error of `residual_of`.
pub fn delay<E>(step_s: f64, residual_of: impl Fn(f64) -> Result<f64, E>) -> Result<f64, E> {
    let mut residuals = [0.0; DELAYS.len()];
    for (residual, samples) in residuals.iter_mut().zip(DELAYS) {
        *residual = residual_of(samples * step_s)?;
    }
    let lowest = (0..DELAYS.len()).min_by(|a, b| residuals[*a].total_cmp(&residuals[*b]));
    // A minimum at either end has no parabola around it, and is no delay of a few samples.
    let Some(lowest) = lowest.filter(|i| (1..DELAYS.len() - 1).contains(i)) else {
        return Ok(0.0);
    };
    let [before, at, behind] = [residuals[lowest - 1], residuals[lowest], residuals[lowest + 1]];
    let samples = DELAYS[lowest] + 0.5 * (before - behind) / (before - 2.0 * at + behind);
    let delay_s = samples * step_s;
    let gained = 1.0 - residual_of(delay_s)? / residuals[2];
    Ok(if gained > DELAY_COUNTS { delay_s } else { 0.0 })
}

/// Fits a model with the best Stribeck velocity.
///
/// # Errors
/// As [`fit`].
pub fn stribeck(
    model: MachineModel,
    moments: &[RegressionSample],
    creeping: f64,
) -> Result<FittedModel, String> {
    let mut speeds: Vec<f64> = moments.iter().map(|at| at.velocity.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    let Some(fast) = speeds.get(speeds.len() * 95 / 100).copied() else {
        return fit(model, moments);
    };
    let at = |velocity: f64| fit(MachineModel { stribeck: Some(velocity), ..model }, moments);
    let residual = |velocity: f64| at(velocity).map_or(f64::INFINITY, |one| one.fit.residual);
    let slow = speeds[speeds.len() * 2 / 100].max(creeping);
    let (low, high) = (slow.ln(), (0.5 * fast).max(2.0 * slow).ln());
    let step = (high - low) / (STRIBECK_VALUES - 1) as f64;
    let tried: Vec<f64> =
        (0..STRIBECK_VALUES).map(|i| residual((low + step * i as f64).exp())).collect();
    let best = (0..tried.len()).min_by(|a, b| tried[*a].total_cmp(&tried[*b])).unwrap_or(0);
    let (mut a, mut b) = (low + step * (best as f64 - 1.0), low + step * (best as f64 + 1.0));
    for _ in 0..16 {
        let (c, d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
        if residual(c.exp()) < residual(d.exp()) { b = d } else { a = c }
    }
    at((0.5 * (a + b)).exp())
}
