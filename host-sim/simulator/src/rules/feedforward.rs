//! Feedforward: less than the slip friction, in the direction of the set point.
//!
//! ```text
//! v_slip = c F_lo,  V_ff = 0.02 q/h
//! ```
//!
//! Feedforward of more than the slip friction drives the joint on its own. F_lo is half of a data
//! sheet's slip friction, so c = 1.8 is a tenth less than it. The set point has no noise, so the
//! least speed only has to be above zero.
//!
//! Tuned on 100 joints each of eight families, seed 1000001, profiled moves; success is the mean of
//! the families. With a stick friction of 2 to 4 times the slip friction (`--hard`) it is the mean
//! of four:
//!
//! | rule | success, % | with `--hard`, % |
//! |---|---|---|
//! | v_slip = 0.8 sqrt(F_lo F_hi) | 17.0 | 13.2 |
//! | v_slip = 1.8 F_lo | 16.2 | 21.5 |
//!
//! In the sum with SRNF the two cannot be distinguished (62.6 and 62.0; 67.8 and 65.0).

use stiction::control::laws::{FeedforwardGains, Gains};

use super::{GainRule, JointBounds, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "feedforward",
    knows: "inertia, viscous friction and the lowest breakaway effort",
    text: "PD's; v_slip = 1.8 F_lo, V_ff = 0.02 q/h",
    constant: 1.8,
    tried: &[],
    gains_with: |joint, c| PdLoop::of(joint).with_laws(vec![law(joint, c)]),
};

/// Returns the law with a constant.
pub(super) fn law(joint: &JointBounds, c: f64) -> Gains {
    Gains::Feedforward(FeedforwardGains {
        v_slip: four_digits_single(c * joint.breakaway[0]),
        v_ff: four_digits_single(0.02 * joint.sampled.count / joint.sampled.sample_time),
        viscous: 0.0,
        inertia: 0.0,
    })
}
