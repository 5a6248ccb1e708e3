//! The sum of feedforward and SRNF, `both` in a first file: feedforward acts in motion, SRNF at
//! rest. Each has the gains of its own rule.

use super::{GainRule, PdLoop, feedforward, smooth_robust_nonlinear as srnf};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "feedforward+srnf",
    knows: "inertia, viscous friction, both bounds of the breakaway effort and the largest load",
    text: "feedforward's and srnf's",
    constant: srnf::CONSTANT,
    tried: srnf::TRIED,
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let feedforward = feedforward::law(joint, feedforward::RULE.constant);
        pd.with_laws(vec![feedforward, srnf::law(joint, &pd, c)])
    },
};
