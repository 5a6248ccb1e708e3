//! RVI: an integral that a speed of a few counts a sample takes away.
//!
//! ```text
//! Ki = c Kp w_n,  gamma_h = (1.85 q/h)^2             gamma = gamma_h h/(0.02 s)
//! ```
//!
//! The thesis's gamma is that of 1.85 counts a sample (0.05 deg^2/s^2, 0.00242 deg, 20 ms). It is
//! given for 20 ms, and the law scales it with the sample time.
//!
//! The thesis's own c is 29.

use stiction::control::laws::{Gains, RateVariableIntegralGains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "rvi",
    text: "PD's; Ki = Kp w, gamma = (1.85 q/h)^2 h/20 ms",
    constant: 1.0,
    tried: &[0.5, 1.0, 3.0, 10.0, 29.0],
    tune: |told, c| {
        let gamma_h = (1.85 * told.count / told.sample_time).powi(2);
        let gains = RateVariableIntegralGains {
            ki: (c * told.kp() * told.natural_frequency()) as f32,
            gamma: (gamma_h * told.sample_time / 0.02) as f32,
        };
        around_pd(told, Some(Gains::RateVariableIntegral(gains)))
    },
};
