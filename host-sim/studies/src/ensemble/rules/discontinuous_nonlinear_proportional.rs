//! DNPF: its threshold by eq. 34, with the largest breakaway effort that is told.
//!
//! ```text
//! theta_b = (c F_hi + lsb)/Kp
//! ```
//!
//! With c below 1 the joints of the most friction stop short; with c at 1, those of the least are
//! struck with several times what they need.

use stiction::control::laws::{DiscontinuousNonlinearProportionalGains, Gains};

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "dnpf",
    text: "PD's; theta_b = (0.5 F_hi + one step of the effort)/Kp",
    constant: 0.5,
    tried: &[0.3, 0.5, 0.7, 1.0],
    tune: |told, c| {
        let theta_b = (c * told.breakaway[1] + told.lsb) / told.kp();
        let gains = DiscontinuousNonlinearProportionalGains { theta_b: theta_b as f32 };
        around_pd(told, Some(Gains::DiscontinuousNonlinearProportional(gains)))
    },
};
