//! Chooses the cut-off of the low-pass from the data.
//!
//! The acceleration is a regressor, and noise in a regressor makes its coefficient too small: by
//! the noise's share of its power (errors in variables). With white position noise, the power of
//! the noise in the acceleration below `fc` is
//!
//! ```text
//! N(fc) = n fc^5        for counts c: n = (c^2/12) (2/fs) (2 pi)^4/5
//! ```
//!
//! n is the larger of the count noise and `(V(f_1) - V(f_1/2))/(f_1^5 (1 - 1/32))`. V is the power
//! of the logged acceleration below a cut-off, and f_1 = fs/8 is the highest cut-off tried. The
//! chosen one is the highest of `f_1 2^(-k/4)` with `N(fc) <= 0.002 V(fc)`: the inertia loses at
//! most 0.2 %.
//!
//! Guarantees: all motion in the uppermost octave counts as noise, so the cut-off errs on the low
//! side; effort and position pass the same low-pass, so that this costs information, but adds no
//! bias. Limits: the noise of counts that change more slowly than the cut-off is not white.

use super::butterworth::LowPass;
use super::derivative::derivatives;
use super::time_grid::TimeGrid;

/// Largest share of the noise in the acceleration's power.
const NOISE: f64 = 0.002;

/// Highest cut-off, as a share of the sampling frequency.
const HIGHEST: f64 = 0.125;

/// Lowest cut-off tried, as a share of the highest.
const RANGE: f64 = 1.0 / 512.0;

/// Number of cut-offs per octave.
const TO_AN_OCTAVE: f64 = 4.0;

/// Least duration of a stretch, in periods of the cut-off.
pub const PERIODS: f64 = 12.0;

/// Cut-off of the low-pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOff {
    /// Frequency at which the gain is 1/2, Hz.
    pub hz: f64,
    /// Estimated share of the noise in the acceleration's power at this cut-off.
    pub noise: f64,
    /// Whether the user has set it.
    pub is_given: bool,
}

/// Returns the power of the acceleration below a cut-off.
fn power(grid: &TimeGrid, hz: f64) -> f64 {
    let low_pass = LowPass::new(hz * grid.step_s);
    // Samples at either end that depend on the mirror image.
    let edge = (1.0 / (hz * grid.step_s)).ceil() as usize;
    let (mut sum, mut count) = (0.0, 0.0);
    for stretch in &grid.stretches {
        let [_, acceleration] = derivatives(&low_pass.apply(&stretch.position), grid.step_s);
        if let Some(inner) = acceleration.get(edge..acceleration.len().saturating_sub(edge)) {
            sum += inner.iter().map(|a| a * a).sum::<f64>();
            count += inner.len() as f64;
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Returns the highest cut-off at which a log of this sample time can be differentiated, Hz.
pub fn highest(step_s: f64) -> f64 {
    HIGHEST / step_s
}

/// Chooses the cut-off, or evaluates the given one. `count` is one count of the position.
pub fn choose(grid: &TimeGrid, count: f64, given: Option<f64>) -> CutOff {
    let top = highest(grid.step_s);
    let two_pi = std::f64::consts::TAU;
    let counted = count * count / 12.0 * 2.0 * grid.step_s * two_pi.powi(4) / 5.0;
    let [all, lower] = [top, 0.5 * top].map(|hz| power(grid, hz));
    let seen = (all - lower) / (top.powi(5) * (1.0 - 1.0 / 32.0));
    let noise = |hz: f64| {
        let power = power(grid, hz);
        if power > 0.0 { counted.max(seen) * hz.powi(5) / power } else { f64::INFINITY }
    };
    if let Some(hz) = given {
        return CutOff { hz, noise: noise(hz), is_given: true };
    }
    let longest = grid.stretches.iter().map(|one| one.position.len()).max().unwrap_or(0);
    let lowest = (RANGE * top).max(PERIODS / (longest as f64 * grid.step_s));
    let mut best = CutOff { hz: top, noise: f64::INFINITY, is_given: false };
    let mut hz = top;
    while hz >= lowest {
        let noise = noise(hz);
        if noise < best.noise {
            best = CutOff { hz, noise, is_given: false };
        }
        if noise <= NOISE {
            break;
        }
        hz *= 0.5f64.powf(1.0 / TO_AN_OCTAVE);
    }
    best
}
