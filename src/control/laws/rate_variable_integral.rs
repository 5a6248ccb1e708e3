//! Rate variable integral (RVI): an integrator that leaks the faster, the faster the joint moves.
//!
//! Thesis eq. 30, after Morse et al.:
//!
//! ```text
//! v_c(t) = [v_c(t - h) + Ki theta_e h] gamma_h / (gamma_h + theta_a'^2)
//! ```
//!
//! The thesis uses `gamma` = 0.05 (deg/s)^2 for its loop of 20 ms (Table 17 prints it as beta). The
//! factor multiplies the whole integral once a sample, so that its leak per second depends on the
//! sample time. For small `theta_a'^2 / gamma` the leak per sample is `theta_a'^2 / gamma_h`, and
//! `gamma_h = gamma (0.02 s) / h` keeps the leak per second that of the thesis.
//!
//! Why this form: full integral action at rest, hence a high `Ki` without overshoot, and none at
//! speed. Guarantees: |v_c| never exceeds the full scale; at rest, the law is a plain integrator.
//! Does badly: it leaves the tracking error to the PD loop, since at constant velocity the integral
//! has leaked away. At rest it is an integrator with its hunting: simulated on the thesis's axis, 6
//! counts peak to peak where RI has 12.

use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

/// The sample time at which the thesis specifies gamma, s.
const THESIS_SAMPLE_TIME: f32 = 0.02;

table! {
    /// Gains of RVI.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RateVariableIntegralGains (law) "controller" {
        /// Integral gain Ki, V/(deg s).
        ki: f32 = 0x1201 "ki_v_per_deg_s", Between(0.0, HUGE), Needed(150.0);
        /// Rate constant gamma at 20 ms, (deg/s)^2. Not zero: the factor would be 0/0 at rest.
        gamma: f32 = 0x1202 "gamma_deg2_per_s2", Above(0.0, HUGE), Needed(0.05);
    }
}

/// The law RVI, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateVariableIntegral {
    /// Ki h, V/deg.
    ki_h: f32,
    /// gamma (0.02 s)/h, (deg/s)^2.
    gamma_h: f32,
    full_scale: f32,
}

/// The integral of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateVariableIntegralState {
    v_c: f32,
}

impl Law for RateVariableIntegral {
    type Gains = RateVariableIntegralGains;
    type State = RateVariableIntegralState;

    fn new(gains: &RateVariableIntegralGains, around: &Loop) -> Self {
        Self {
            ki_h: gains.ki * around.sample_time,
            gamma_h: gains.gamma * (THESIS_SAMPLE_TIME / around.sample_time),
            full_scale: around.full_scale,
        }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{Law, LawInput, Loop};
    /// use stiction::control::laws::{RateVariableIntegral, RateVariableIntegralGains};
    /// use stiction::control::laws::rate_variable_integral::RateVariableIntegralState;
    /// let around = Loop::EXAMPLE;
    /// let gains = RateVariableIntegralGains { ki: 50.0, gamma: 0.25 };
    /// let law = RateVariableIntegral::new(&gains, &around);
    /// let mut state = RateVariableIntegralState::default();
    /// let at_rest = LawInput { error: 0.5, ..LawInput::default() };
    /// assert_eq!(law.update(&mut state, &at_rest), 0.5);
    /// let moving = LawInput { velocity: 0.5, ..at_rest };
    /// assert_eq!(law.update(&mut state, &moving), 0.5); // (0.5 + 0.5) / 2
    /// ```
    fn update(&self, state: &mut RateVariableIntegralState, input: &LawInput) -> f32 {
        let rate_factor = self.gamma_h / (self.gamma_h + input.velocity * input.velocity);
        state.v_c =
            saturate((state.v_c + self.ki_h * input.error) * rate_factor, self.full_scale).0;
        state.v_c
    }
}
