//! SRNF: the largest breakaway effort by eq. 36, and a slope at the target in multiples of Kp.
//!
//! ```text
//! v_ms = F_hi + lsb,  alpha = min(c Kp/v_ms, 0.242/q)
//! ```
//!
//! The thesis's alpha is 0.242 a count. A slope of c Kp has the natural frequency sqrt(1 + c) w_n
//! and the damping ratio zeta/sqrt(1 + c) at the target.
//!
//! The thesis's own c is 40.

use stiction::control::laws::{Gains, SmoothRobustNonlinearGains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "srnf",
    text: "PD's; v_ms = F_hi + one step of the effort, alpha = min(30 Kp/v_ms, 0.242/q)",
    constant: 30.0,
    tried: &[3.0, 10.0, 30.0, 100.0],
    tune: |told, c| {
        let v_ms = told.breakaway[1] + told.lsb;
        let alpha = (c * told.kp() / v_ms).min(0.242 / told.count);
        let gains = SmoothRobustNonlinearGains { v_ms: v_ms as f32, alpha: alpha as f32 };
        around_pd(told, Some(Gains::SmoothRobustNonlinear(gains)))
    },
};
