//! Proxy-based sliding mode: a PID between joint and proxy, and a surface twice as slow as it.
//!
//! ```text
//! w = min(w_n, 0.1/h),  K = J w^2,  D = 1.8 J w - B,  L = c K w,  H = 2/w
//! ```
//!
//! PD has the same gains. They are without effect, but the monitors' thresholds follow from them.

use stiction::control::laws::{Gains, ProxySlidingModeGains};

use super::{Rule, around_slower_pd, slower};

/// The rule.
pub const RULE: Rule = Rule {
    law: "proxy-sliding-mode",
    text: "K and D as PD's Kp and Kd with w no more than 0.1/h; L = 0.2 K w, H = 2/w",
    constant: 0.2,
    tried: &[0.1, 0.2, 0.4],
    tune: |told, c| {
        let w = slower(told);
        let gains = ProxySlidingModeGains {
            stiffness: (told.inertia * w * w) as f32,
            damping: (1.8 * told.inertia * w - told.viscous).max(0.0) as f32,
            integral: (c * told.inertia * w.powi(3)) as f32,
            surface_time: (2.0 / w) as f32,
        };
        around_slower_pd(told, Gains::ProxySlidingMode(gains))
    },
};
