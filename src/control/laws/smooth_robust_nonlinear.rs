//! Smooth robust nonlinear feedback (SRNF): the static friction, turned on smoothly with the error.
//!
//! Thesis eq. 35, after Cai and Song:
//!
//! ```text
//! v_c(t) = v_ms tanh(alpha theta_e)
//! v_ms   = v_stick + epsilon            (eq. 36)
//! ```
//!
//! Why this form: a relay at the target (`alpha` to infinity) moves the joint for certain but
//! bangs; the hyperbolic tangent has the same effort beyond about `2 / alpha` and a finite slope,
//! `v_ms alpha`, at zero. `alpha` = 100 /deg reaches 90 % of `v_ms` at 0.015 deg, six encoder
//! counts of the thesis's robot.
//!
//! Guarantees: |v_c| <= v_ms, odd, no state. Tracks with the error that solves `Kp e + v_ms
//! tanh(alpha e) = v_slip + b theta_d'`. Does badly: it adds `v_ms alpha` to the proportional gain
//! near the target, so a delay or a coarse encoder makes it chatter. It does not adapt, and
//! friction beyond `v_ms` is left to PD.

use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::value::table;

table! {
    /// Gains of SRNF.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SmoothRobustNonlinearGains (law) "controller" {
        /// Compensated static friction v_ms, V.
        v_ms: f32 = 0x1601 "v_ms_v", Between(0.0, HUGE), Needed(0.4);
        /// Steepness alpha, 1/deg.
        alpha: f32 = 0x1602 "alpha_per_deg", Between(0.0, HUGE), Needed(100.0);
    }
}

/// The law SRNF, prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothRobustNonlinear {
    gains: SmoothRobustNonlinearGains,
}

impl Law for SmoothRobustNonlinear {
    type Gains = SmoothRobustNonlinearGains;
    type State = ();

    fn new(gains: &SmoothRobustNonlinearGains, _: &Loop) -> Self {
        Self { gains: *gains }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{Law, LawInput, Loop};
    /// use stiction::control::laws::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
    /// let gains = SmoothRobustNonlinearGains { v_ms: 0.40, alpha: 100.0 };
    /// let law = SmoothRobustNonlinear::new(&gains, &Loop::EXAMPLE);
    /// let v_c = law.update(&mut (), &LawInput { error: 0.01, ..LawInput::default() });
    /// assert!((v_c - 0.304_637_7).abs() < 1e-6); // 0.40 tanh 1
    /// ```
    fn update(&self, (): &mut (), input: &LawInput) -> f32 {
        self.gains.v_ms * libm::tanhf(self.gains.alpha * input.error)
    }
}
