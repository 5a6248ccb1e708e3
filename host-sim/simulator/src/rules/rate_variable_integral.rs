//! RVI: an integral that leaks away at a speed of a few counts a sample.
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

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "rvi",
    knows: "inertia and viscous friction",
    text: "PD's; Ki = Kp w, gamma = (1.85 q/h)^2 h/20 ms",
    constant: 1.0,
    tried: &[0.5, 1.0, 3.0, 10.0, 29.0],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let (count, sample_time) = (joint.sampled.count, joint.sampled.sample_time);
        let gamma_h = (1.85 * count / sample_time).powi(2);
        let gains = RateVariableIntegralGains {
            ki: four_digits_single(c * pd.kp * pd.natural_frequency),
            gamma: four_digits_single(gamma_h * sample_time / 0.02),
        };
        pd.with_laws(vec![Gains::RateVariableIntegral(gains)])
    },
};
