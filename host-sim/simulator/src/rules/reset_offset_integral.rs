//! ROI: an offset that grows once in the time in which PD comes to rest.
//!
//! ```text
//! T_roi = c/w_n,  V_roi = F_lo/(Kd + B)
//! ```
//!
//! A velocity error that requires less effort than the lowest friction counts as that of a joint at
//! rest.
//!
//! The thesis's own c is 0.73.

use stiction::control::laws::{Gains, ResetOffsetIntegralGains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "roi",
    knows: "inertia, viscous friction and the lowest breakaway effort",
    text: "PD's; T_roi = 0.73/w, V_roi = F_lo/(Kd + B)",
    constant: 0.73,
    tried: &[0.73, 1.5, 3.0, 6.0, 12.0],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let gains = ResetOffsetIntegralGains {
            t_roi: four_digits_single(c / pd.natural_frequency),
            v_roi: four_digits_single(joint.breakaway[0] / (pd.kd + joint.viscous)),
        };
        pd.with_laws(vec![Gains::ResetOffsetIntegral(gains)])
    },
};
