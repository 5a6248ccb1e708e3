//! PID: PD's gains, and an integral in multiples of what the loop without friction bears.
//!
//! ```text
//! Ki = c Kp w_n
//! ```
//!
//! The loop without friction is stable below c = 2 zeta = 1.8. The larger c is, the sooner the
//! joint breaks away, and the more often it hunts.

use stiction::control::laws::{Gains, PidGains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "pid",
    text: "PD's; Ki = 0.2 Kp w",
    constant: 0.2,
    tried: &[0.1, 0.2, 0.4],
    tune: |told, c| {
        let ki = (c * told.kp() * told.natural_frequency()) as f32;
        around_pd(told, Some(Gains::Pid(PidGains { ki })))
    },
};
