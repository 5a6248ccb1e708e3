//! RI: the integral of a PID, active within the range in which PD comes to rest.
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

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "ri",
    knows: "inertia, viscous friction and the highest breakaway effort",
    text: "PD's; Ki = 0.25 Kp w, theta_ri = 1.25 F_hi/Kp",
    constant: 0.25,
    tried: &[0.1, 0.25, 0.5, 0.77, 1.0],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let gains = ResetIntegralGains {
            ki: four_digits_single(c * pd.kp * pd.natural_frequency),
            theta_ri: four_digits_single(1.25 * joint.breakaway[1] / pd.kp),
        };
        pd.with_laws(vec![Gains::ResetIntegral(gains)])
    },
};
