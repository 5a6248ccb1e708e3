//! RI: the integral of a PID whose range is where PD comes to rest.
//!
//! ```text
//! Ki = c Kp w_n,  theta_ri = 1.25 F_hi/Kp
//! ```
//!
//! PD rests within F_hi/Kp; the thesis's range is 1.25 times that of its joint. The loop without
//! friction is stable below c = 2 zeta.
//!
//! The thesis's own c is 0.77.

use stiction::control::laws::{Gains, ResetIntegralGains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "ri",
    text: "PD's; Ki = 0.25 Kp w, theta_ri = 1.25 F_hi/Kp",
    constant: 0.25,
    tried: &[0.1, 0.25, 0.5, 0.77, 1.0],
    tune: |told, c| {
        let kp = told.kp();
        let gains = ResetIntegralGains {
            ki: (c * kp * told.natural_frequency()) as f32,
            theta_ri: (1.25 * told.breakaway[1] / kp) as f32,
        };
        around_pd(told, Some(Gains::ResetIntegral(gains)))
    },
};
