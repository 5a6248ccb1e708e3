//! Feedforward: the slip friction that is likely, in the direction of the set point.
//!
//! ```text
//! v_slip = c sqrt(F_lo F_hi),  V_ff = 0.02 q/h
//! ```
//!
//! The slip level lies below the breakaway level, which is all that is told. The set point has no
//! noise, so that the least speed only has to be none.

use stiction::control::laws::{FeedforwardGains, Gains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "feedforward",
    text: "PD's; v_slip = 0.8 sqrt(F_lo F_hi), V_ff = 0.02 q/h",
    constant: 0.8,
    tried: &[],
    tune: |told, c| {
        let gains = FeedforwardGains {
            v_slip: (c * told.middle_breakaway()) as f32,
            v_ff: (0.02 * told.count / told.sample_time) as f32,
            viscous: 0.0,
            inertia: 0.0,
        };
        around_pd(told, Some(Gains::Feedforward(gains)))
    },
};
