//! Detects causes of the residual that the model leaves out.
//!
//! For each cause, columns that would show it are fitted to the residual of one half of the log and
//! tried on the other half, and vice versa:
//!
//! ```text
//! share = 1 - sum (e - W b_other)^2 / sum e^2        part of the residual that is predicted
//! ```
//!
//! A half consists of every other of 20 blocks in time. A chance result in one half does not show
//! in the other, so noise has a share near or below 0 (cross-validation, M. Stone, *J. Royal
//! Statistical Society* B 36 (1974), 111). A cause is reported if its share is above 0.2 and it
//! explains more than 1.5 % of the effort; less is negligible. Two bodies with a spring between
//! them are detected by their inertia: it varies with the cut-off by more than 3 % and more than
//! two standard deviations.

use super::model::{FittedModel, RegressionSample};
use super::regression;

/// Number of blocks in time; every other one belongs to one half.
const BLOCKS: usize = 20;

/// Least share of a reported cause.
const REPORTED: f64 = 0.2;

/// Least part of the effort that a reported cause explains, %.
const MATTERS_PERCENT: f64 = 1.5;

/// Number of fine cells of the position.
const CELLS: usize = 40;
/// Number of coarse cells of the position, and of cells of the other quantities.
const FEW_CELLS: usize = 8;

/// Largest number of periods over the range of the position.
const PERIODS: usize = 400;

/// Least relative change of the inertia with the cut-off that shows two bodies.
const DRIFTS: f64 = 0.03;
/// Least change of the inertia that shows two bodies, standard deviations.
const SURELY: f64 = 2.0;

/// Ratio of the cut-off to the lower cut-off at which inertias are compared.
pub const SMOOTHER: f64 = 3.0;

/// Number of samples in the search for a period.
const SEARCHED: usize = 8_000;

/// A cause that the model leaves out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Misfit {
    /// Short name for scripts.
    pub cause: &'static str,
    /// Share of the residual's power that the cause predicts, in the half of the log to which it
    /// was not fitted. For `flexibility`: the share that a fit at the lower cut-off removes.
    pub share: f64,
    /// Sentence for the verdict.
    pub words: String,
}

/// A sample of the residual.
struct Sample {
    at: RegressionSample,
    error: f64,
    is_even: bool,
}

/// Returns the causes that the residual shows, the largest first. `smooth` are rows at a cut-off
/// lower by the factor [`SMOOTHER`].
pub fn misfits(
    fitted: &FittedModel,
    moments: &[RegressionSample],
    smooth: &[RegressionSample],
) -> Vec<Misfit> {
    let samples = residuals(fitted, moments);
    let way = |sample: &Sample| sample.at.velocity.signum();
    let [low, high] = range(samples.iter().map(|sample| sample.at.position));
    let [_, fast] = range(samples.iter().map(|sample| sample.at.velocity.abs()));
    let range = high - low;
    let cell = |sample: &Sample, cells: usize| {
        let cells = cells as f64;
        ((sample.at.position - low) / range * cells).min(cells - 1.0) as usize
    };
    let speed = |sample: &Sample| {
        let part = sample.at.velocity.abs() / fast;
        (part.sqrt() * FEW_CELLS as f64).min(FEW_CELLS as f64 - 1.0) as usize
    };
    // A tenth of the range, in cells of doubling width.
    let since = |sample: &Sample| {
        let part = sample.at.since_reversal / (0.1 * range);
        (part < 1.0).then(|| ((part * 256.0).max(1.0).log2() as usize).min(FEW_CELLS - 1))
    };
    let cells = |count: usize, of: &dyn Fn(&Sample) -> Option<usize>, sign: bool| {
        by_cell(&samples, count, of, |sample| if sign { way(sample) } else { 1.0 })
    };
    // Few cells find smooth changes in a short log, many cells rough ones, and a sine finer ones.
    let by_position = |sign: bool| {
        let shares =
            [FEW_CELLS, CELLS].map(|count| cells(count, &|sample| Some(cell(sample, count)), sign));
        shares[0].max(shares[1]).max(periodic(&samples, low, range, sign))
    };
    let found = [
        ("position_dependent_friction", by_position(true), "friction varies with the position"),
        (
            "position_dependent_load",
            by_position(false),
            "a load varies with the position, like gravity, a spring or cogging",
        ),
        (
            "reversal",
            cells(FEW_CELLS, &since, true),
            "the effort differs after a reversal, as with backlash or with friction that builds up \
             over a distance",
        ),
        (
            "velocity",
            cells(
                2 * FEW_CELLS,
                &|sample| Some(speed(sample) + if way(sample) > 0.0 { FEW_CELLS } else { 0 }),
                false,
            ),
            "friction is not linear in the velocity; --stribeck adds a term",
        ),
    ];
    let relative = fitted.relative_residual_percent();
    let mut misfits: Vec<Misfit> = found
        .into_iter()
        .filter(|(_, share, _)| *share > REPORTED && share.sqrt() * relative > MATTERS_PERCENT)
        .map(|(cause, share, words)| Misfit { cause, share, words: words.into() })
        .collect();
    misfits.extend(flexibility(fitted, smooth));
    misfits.sort_by(|a, b| b.share.total_cmp(&a.share));
    misfits
}

fn residuals(fitted: &FittedModel, moments: &[RegressionSample]) -> Vec<Sample> {
    let count = moments.len().max(1);
    let with_error = |(i, at): (usize, &RegressionSample)| Sample {
        at: *at,
        error: at.effort - fitted.fit.predict(&fitted.model.columns(at)),
        is_even: (i * BLOCKS / count).is_multiple_of(2),
    };
    moments.iter().enumerate().map(with_error).collect()
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// Returns the share of the residual's power that means over cells predict. The prediction outside
/// all cells is 0.
fn by_cell(
    samples: &[Sample],
    count: usize,
    cell: impl Fn(&Sample) -> Option<usize>,
    factor: impl Fn(&Sample) -> f64,
) -> f64 {
    let mut sums = vec![[[0.0f64; 2]; 2]; count];
    for sample in samples {
        if let Some(sum) = cell(sample).and_then(|cell| sums.get_mut(cell)) {
            let half = &mut sum[usize::from(sample.is_even)];
            *half = [half[0] + factor(sample) * sample.error, half[1] + 1.0];
        }
    }
    share(samples, |sample| {
        let other = cell(sample).and_then(|cell| sums.get(cell));
        let [sum, count] = other.map_or([0.0; 2], |sum| sum[usize::from(!sample.is_even)]);
        if count > 0.0 { factor(sample) * sum / count } else { 0.0 }
    })
}

/// Detects two bodies with a spring between them. A rigid machine has the same inertia at every
/// cut-off. Two bodies show their whole inertia below their resonance, and that of the driven body
/// above it.
fn flexibility(fitted: &FittedModel, smooth: &[RegressionSample]) -> Option<Misfit> {
    let below = regression::fit(fitted.model, smooth).ok()?;
    let [here, there] = [fitted.get("inertia")?, below.get("inertia")?];
    let drift = there.value / here.value - 1.0;
    let uncertain = here.sd.hypot(there.sd) / here.value;
    if drift.abs() < DRIFTS.max(SURELY * uncertain) {
        return None;
    }
    // Residual power that a model leaves at the lower cut-off.
    let left = |fitted: &FittedModel| -> f64 {
        residuals(fitted, smooth).iter().map(|sample| sample.error.powi(2)).sum()
    };
    let share = 1.0 - left(&below) / left(fitted);
    let larger = if drift > 0.0 { "larger" } else { "smaller" };
    let percent = (100.0 * drift.abs()).round();
    let words = format!(
        "the inertia is {percent} % {larger} at a third of the cut-off, like that of two bodies \
         with a spring or a backlash between them"
    );
    Some(Misfit { cause: "flexibility", share, words })
}

fn share(samples: &[Sample], predicted: impl Fn(&Sample) -> f64) -> f64 {
    let left: f64 = samples.iter().map(|one| (one.error - predicted(one)).powi(2)).sum();
    let all: f64 = samples.iter().map(|one| one.error.powi(2)).sum();
    if all > 0.0 { 1.0 - left / all } else { 0.0 }
}

/// Returns the share of the residual's power that a sine of the position predicts. Its period and
/// amplitude are found in one half of the log and tried on the other.
fn periodic(samples: &[Sample], low: f64, range: f64, has_way: bool) -> f64 {
    let angle = |sample: &Sample, periods: usize| {
        std::f64::consts::TAU * periods as f64 * (sample.at.position - low) / range
    };
    let factor = |sample: &Sample| if has_way { sample.at.velocity.signum() } else { 1.0 };
    // Sums of sine, cosine and count for each half.
    let wave = |stride: usize, periods: usize| {
        let mut sums = [[0.0f64; 3]; 2];
        for sample in samples.iter().step_by(stride) {
            let (sine, cosine) = angle(sample, periods).sin_cos();
            let half = &mut sums[usize::from(sample.is_even)];
            let value = factor(sample) * sample.error;
            *half = [half[0] + value * sine, half[1] + value * cosine, half[2] + 1.0];
        }
        sums
    };
    let stride = samples.len().div_ceil(SEARCHED).max(1);
    let power = |[sine, cosine, _]: [f64; 3]| sine * sine + cosine * cosine;
    let waves: Vec<_> = (1..=PERIODS).map(|periods| wave(stride, periods)).collect();
    let best = |half: usize| {
        let by_power =
            waves.iter().enumerate().max_by(|a, b| power(a.1[half]).total_cmp(&power(b.1[half])));
        by_power.map_or(1, |(i, _)| i + 1)
    };
    let periods = [best(0), best(1)];
    let sums = periods.map(|periods| wave(1, periods));
    share(samples, |sample| {
        let other = usize::from(!sample.is_even);
        let [sine, cosine, count] = sums[other][other];
        if count == 0.0 {
            return 0.0;
        }
        let (s, c) = angle(sample, periods[other]).sin_cos();
        factor(sample) * 2.0 * (sine * s + cosine * c) / count
    })
}
