//! Impulsive positioner: known values of the joint, beside the gains of PD.
//!
//! ```text
//! J, F_lo, F_hi and u_m as known
//! ```
//!
//! The law has no gain to tune.

use stiction::control::laws::{Gains, ImpulsiveGains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "impulsive",
    knows: "inertia, viscous friction, both bounds of the breakaway effort and the largest effort",
    text: "PD's; J, F_lo, F_hi and the largest effort as known",
    constant: 1.0,
    tried: &[],
    gains_with: |joint, _| {
        let gains = ImpulsiveGains {
            inertia: four_digits_single(joint.inertia),
            low: four_digits_single(joint.breakaway[0]),
            high: four_digits_single(joint.breakaway[1]),
            largest: four_digits_single(joint.sampled.largest_effort),
        };
        PdLoop::of(joint).with_laws(vec![Gains::Impulsive(gains)])
    },
};
