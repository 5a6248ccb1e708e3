//! PID: PD's gains, and an integral in multiples of what the loop without friction tolerates.
//!
//! ```text
//! Ki = c Kp w_n
//! ```
//!
//! The loop without friction is stable below c = 2 zeta = 1.8. The larger c is, the sooner the
//! joint breaks away, and the more often it hunts.

use stiction::control::laws::{Gains, PidGains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "pid",
    knows: "inertia and viscous friction",
    text: "PD's; Ki = 0.2 Kp w",
    constant: 0.2,
    tried: &[0.1, 0.2, 0.4],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let ki = four_digits_single(c * pd.kp * pd.natural_frequency);
        pd.with_laws(vec![Gains::Pid(PidGains { ki })])
    },
};
