//! DNPF: its threshold by eq. 34, with a share of the largest breakaway effort.
//!
//! ```text
//! theta_b = (c F_hi + u_q)/Kp
//! ```
//!
//! With c below 1 the joints with the most friction stop short; with c at 1, those with the least
//! receive several times the effort that they need.

use stiction::control::laws::{DiscontinuousNonlinearProportionalGains, Gains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "dnpf",
    knows: "inertia, viscous friction and the highest breakaway effort",
    text: "PD's; theta_b = (0.5 F_hi + one step of the effort)/Kp",
    constant: 0.5,
    tried: &[0.3, 0.5, 0.7, 1.0],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let theta_b = four_digits_single((c * joint.breakaway[1] + joint.sampled.lsb) / pd.kp);
        let gains = DiscontinuousNonlinearProportionalGains { theta_b };
        pd.with_laws(vec![Gains::DiscontinuousNonlinearProportional(gains)])
    },
};
