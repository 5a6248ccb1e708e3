//! A held effort behind a first-order lag: `tau u' = target - u`, in closed form.
//!
//! The rest of the former effort, `r exp(-t/tau)`, moves a free inertia J by
//!
//! ```text
//! velocity(t) = (r tau/J) (1 - E)    position(t) = (r tau/J) (t - tau (1 - E))    E = exp(-t/tau)
//! ```
//!
//! With these two in closed form, the polynomials of a step need not follow the lag.

use super::runge_kutta::NODES;

/// Part of the effort below which the rest of the former effort counts as zero.
const NOTHING: f64 = 1e-15;

/// Effort behind its lag.
#[derive(Clone, Debug)]
pub struct Lag {
    tau: f64,
    target: f64,
    left: f64,
    /// `1 - E` at the nodes of a step of the length `step_s`. Nearly all steps have the same
    /// length.
    step_s: f64,
    risen: [f64; 7],
}

impl Lag {
    /// Creates a lag with a time constant (s), without effort.
    pub const fn new(tau: f64) -> Self {
        Self { tau, target: 0.0, left: 0.0, step_s: 0.0, risen: [0.0; 7] }
    }

    /// Sets the target of the effort from now on.
    #[inline]
    pub fn set(&mut self, target: f64) {
        if self.tau > 0.0 {
            self.left += self.target - target;
        }
        self.target = target;
    }

    /// Returns the target of the effort.
    #[inline]
    pub const fn target(&self) -> f64 {
        self.target
    }

    /// Returns the rest of the former effort: the present effort minus its target.
    #[inline]
    pub const fn left(&self) -> f64 {
        self.left
    }

    /// Returns the present effort.
    #[inline]
    pub const fn now(&self) -> f64 {
        self.target + self.left
    }

    /// Returns the effort after a time (s).
    pub fn after(&self, time_s: f64) -> f64 {
        if self.left == 0.0 {
            return self.target;
        }
        self.target + self.left * libm::exp(-time_s / self.tau)
    }

    /// Returns the rate of the effort if the rest of the former effort is `left`.
    #[inline]
    pub fn rate_of(&self, left: f64) -> f64 {
        if left == 0.0 { 0.0 } else { -left / self.tau }
    }

    /// Returns the time (s) after which the effort leaves a range that it is in; `None` if it does
    /// not leave it within a time (s).
    pub fn leaves(&self, range: [f64; 2], within_s: f64) -> Option<f64> {
        let rises = self.left < 0.0;
        let edge = if rises { range[1] } else { range[0] };
        let end = self.after(within_s);
        let is_inside = if rises { end <= edge } else { end >= edge };
        if self.left == 0.0 || is_inside {
            return None;
        }
        Some((self.tau * libm::log(self.left / (edge - self.target))).clamp(0.0, within_s))
    }

    /// Prepares a step of this length (s).
    #[inline]
    pub fn prepare(&mut self, step_s: f64) {
        if self.left != 0.0 && self.step_s != step_s {
            self.step_s = step_s;
            self.risen = NODES.map(|node| -libm::expm1(-node * step_s / self.tau));
        }
    }

    /// Returns the velocity and the distance that the rest of the former effort causes, times the
    /// inertia, at a stage of the prepared step.
    #[inline]
    pub fn impulse(&self, stage: usize) -> [f64; 2] {
        if self.left == 0.0 {
            return [0.0; 2];
        }
        let impulse = self.left * self.tau;
        let risen = self.risen[stage];
        [impulse * risen, impulse * (NODES[stage] * self.step_s - self.tau * risen)]
    }

    /// Returns the rest of the former effort at the end of the prepared step.
    #[inline]
    pub fn left_at_end(&self) -> f64 {
        if self.left == 0.0 { 0.0 } else { self.left * (1.0 - self.risen[6]) }
    }

    /// Advances the lag by the prepared step.
    #[inline]
    pub fn pass(&mut self) {
        self.left = self.left_at_end();
        if self.left.abs() <= NOTHING * self.target.abs() {
            self.left = 0.0;
        }
    }
}
