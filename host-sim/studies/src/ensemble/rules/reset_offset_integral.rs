//! ROI: an offset that grows once in the time in which PD comes to rest.
//!
//! ```text
//! T_roi = c/w_n,  V_roi = F_lo/(Kd + B)
//! ```
//!
//! A velocity error that takes less effort than the least friction is that of a joint at rest.
//!
//! The thesis's own c is 0.73.

use stiction::control::laws::{Gains, ResetOffsetIntegralGains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "roi",
    text: "PD's; T_roi = 0.73/w, V_roi = F_lo/(Kd + B)",
    constant: 0.73,
    tried: &[0.73, 1.5, 3.0, 6.0, 12.0],
    tune: |told, c| {
        let gains = ResetOffsetIntegralGains {
            t_roi: (c / told.natural_frequency()) as f32,
            v_roi: (told.breakaway[0] / (told.kd() + told.viscous)) as f32,
        };
        around_pd(told, Some(Gains::ResetOffsetIntegral(gains)))
    },
};
