//! Two-reset PID: a slower PD, an integral within the paper's condition, and a load that is learned
//! in a minute of sliding.
//!
//! ```text
//! w = min(w_n, 0.1/h),  Kp = J w^2,  Kd = 1.8 J w - B,  Ki = c Kp w,  T = 60 s
//! ```
//!
//! Kp Kd > Ki J holds for c < 1.8 on the nominal joint, and for c < 0.9 where the inertia is twice
//! that. A reset is late by what the velocity is late, hence the slower loop at long sample times.
//! A shorter T has the friction enter the load.

use stiction::control::laws::{Gains, TwoResetPidGains};

use super::{Rule, around_slower_pd, slower};

/// The rule.
pub const RULE: Rule = Rule {
    law: "two-reset-pid",
    text: "PD's with w no more than 0.1/h; Ki = 0.4 Kp w, T = 60 s",
    constant: 0.4,
    tried: &[0.2, 0.4, 0.7],
    tune: |told, c| {
        let w = slower(told);
        let ki = (c * told.inertia * w.powi(3)) as f32;
        around_slower_pd(told, Gains::TwoResetPid(TwoResetPidGains { ki, load_time: 60.0 }))
    },
};
