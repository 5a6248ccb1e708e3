//! PD: a natural frequency and a damping ratio on the nominal joint.
//!
//! ```text
//! Kp = J w_n^2,  Kd = max(0, 2 zeta J w_n - B)       w_n = min(2 pi 8, 0.1/h), zeta = 0.9
//! ```

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "pd",
    text: "Kp = J w^2, Kd = 1.8 J w - B, with w = min(2 pi 8 Hz, 0.1/h), 2 Hz with the encoder on \
           the load",
    constant: 1.0,
    tried: &[],
    tune: |told, _| around_pd(told, None),
};
