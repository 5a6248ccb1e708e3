//! Smooth robust nonlinear feedback (SRNF): the static friction, turned on smoothly with the error.
//!
//! Thesis eq. 35, after Cai and Song:
//!
//! ```text
//! v_c(t) = v_ms tanh(alpha theta_e)
//! v_ms   = v_stick + epsilon            (eq. 36)
//! ```
//!
//! Why this form: a relay at the target (`alpha` to infinity) moves the joint for certain but bangs; the hyperbolic
//! tangent gives the same effort beyond about `2 / alpha` and a finite slope, `v_ms alpha`, at zero. `alpha` = 100 /deg
//! reaches 90 % of `v_ms` at 0.015 deg, six encoder counts of the thesis's robot.
//!
//! Guarantees: |v_c| <= v_ms, odd, no state. Tracks with the error that solves
//! `Kp e + v_ms tanh(alpha e) = v_slip + b theta_d'`. Does badly: it adds `v_ms alpha` to the proportional gain
//! near the target, so a delay or a coarse encoder makes it chatter; it does not adapt, and friction
//! beyond `v_ms` is left to PD.

use super::Sample;
use crate::error::{Error, HUGE, between};
use serde::{Deserialize, Serialize};

/// Gains of SRNF.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmoothRobustNonlinearGains {
    /// Compensated static friction v_ms, V.
    pub v_ms: f32,
    /// Steepness alpha, 1/deg.
    pub alpha: f32,
}

impl SmoothRobustNonlinearGains {
    /// Refuses gains that are negative or not finite.
    ///
    /// # Errors
    /// Names the gain.
    pub fn validate(&self) -> Result<(), Error> {
        between("v_ms_v", self.v_ms, 0.0, HUGE)?;
        between("alpha_per_deg", self.alpha, 0.0, HUGE)
    }
}

/// The SRNF law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothRobustNonlinear {
    gains: SmoothRobustNonlinearGains,
}

impl SmoothRobustNonlinear {
    /// Validates the gains.
    ///
    /// # Errors
    /// Names the gain.
    pub fn new(gains: &SmoothRobustNonlinearGains) -> Result<Self, Error> {
        gains.validate()?;
        Ok(Self { gains: *gains })
    }

    /// v_c for one sample, V.
    ///
    /// ```
    /// use stiction::compensator::{Sample, SmoothRobustNonlinear, SmoothRobustNonlinearGains};
    /// let law = SmoothRobustNonlinear::new(&SmoothRobustNonlinearGains { v_ms: 0.40, alpha: 100.0 }).unwrap();
    /// let v_c = law.update(&Sample { error: 0.01, ..Sample::default() });
    /// assert!((v_c - 0.304_637_7).abs() < 1e-6); // 0.40 tanh 1
    /// ```
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn update(&self, sample: &Sample) -> f32 {
        self.gains.v_ms * libm::tanhf(self.gains.alpha * sample.error)
    }
}
