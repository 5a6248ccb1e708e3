//! PD: a natural frequency and a damping ratio on the nominal joint ([`super::pd_loop`]).

use super::{GainRule, PdLoop};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "pd",
    knows: "inertia and viscous friction",
    text: "Kp = J w^2, Kd = 1.8 J w - B, with w = min(2 pi 8 Hz, 0.1/h), 2 Hz with the encoder on \
           the load",
    constant: 1.0,
    tried: &[],
    gains_with: |joint, _| PdLoop::of(joint).with_laws(vec![]),
};
