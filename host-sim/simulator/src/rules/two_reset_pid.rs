//! Two-reset PID: an integral within the paper's condition, and a load that is learned in a minute
//! of sliding.
//!
//! ```text
//! Ki = c Kp w_n,  T = 60 s
//! ```
//!
//! Kp Kd > Ki J holds for c < 1.8 on the nominal joint, and for c < 0.9 where the inertia is twice
//! that. With a shorter T the friction enters the estimate of the load.

use stiction::control::laws::{Gains, TwoResetPidGains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "two-reset-pid",
    knows: "inertia and viscous friction",
    text: "PD's; Ki = 0.4 Kp w, T = 60 s",
    constant: 0.4,
    tried: &[0.2, 0.4, 0.7],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let ki = four_digits_single(c * pd.kp * pd.natural_frequency);
        pd.with_laws(vec![Gains::TwoResetPid(TwoResetPidGains { ki, load_time: 60.0 })])
    },
};
