//! Impulsive positioner: what is told of the joint, behind a slower PD.
//!
//! ```text
//! w = min(w_n, 0.1/h),  Kp = J w^2,  Kd = 1.8 J w - B;  J, F_lo, F_hi and U as told
//! ```
//!
//! The law has no gain of its own to be picked. At 20 ms the slower PD keeps light joints with a
//! delay from ringing.

use stiction::control::laws::{Gains, ImpulsiveGains};

use super::{Rule, around_slower_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "impulsive",
    text: "PD's with w no more than 0.1/h; J, F_lo, F_hi and the largest effort as told",
    constant: 1.0,
    tried: &[],
    tune: |told, _| {
        let gains = ImpulsiveGains {
            inertia: told.inertia as f32,
            low: told.breakaway[0] as f32,
            high: told.breakaway[1] as f32,
            largest: told.full_scale as f32,
        };
        around_slower_pd(told, Gains::Impulsive(gains))
    },
};
