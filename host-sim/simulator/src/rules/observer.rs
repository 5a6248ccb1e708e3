//! The disturbance observer beside PD, and in sums with feedforward and SRNF: the hybrids of the
//! thesis's own laws.
//!
//! ```text
//! w = min(w_n, 0.08/h),  Kp = J w^2,  Kd = 1.74 J w - B
//! observer     w_e = min(110, 0.8/h),  J and B as known,  theta_o = 1.5 q,
//!              R = min(c, 0.012 s/h) F_lo/s,  largest F_hi,
//!              F = v_slip in a sum with feedforward, else 0
//! feedforward  v_slip = 0.85 sqrt(F_lo F_hi),  V_ff = 0.02 q/h,  B,  0.85 J
//! SRNF         v_ms = 0.5 sqrt(F_lo F_hi),  alpha = Kp/v_ms
//! ```
//!
//! The loop is slower than PD's own at long sample times: the observer cancels the friction that
//! damps it. A ramp of 0.012 F_lo a sample exceeds the friction by some hundredths of it when the
//! breakaway is seen, three or four samples late. The feedforward's inertia is less than the
//! joint's, since the observer and a sample of delay add to it.

use stiction::control::laws::{
    DisturbanceObserverGains, FeedforwardGains, Gains, SmoothRobustNonlinearGains,
};

use super::{ControllerGains, GainRule, JointBounds, PdLoop, four_digits_single};

/// Number of positions in the velocity's regression: the delay is half a sample less than with the
/// thesis's five, which matters where the observer has cancelled the friction.
const VELOCITY_WINDOW: u32 = 4;

/// Damping ratio of the loop on the nominal joint.
const DAMPING_RATIO: f64 = 0.87;

/// Constant c of the three rules, 1/s.
const CONSTANT: f64 = 3.0;
const TRIED: &[f64] = &[1.0, 3.0, 10.0];

/// Values of the joint that the three rules use.
const KNOWS: &str = "inertia, viscous friction and both bounds of the breakaway effort";

/// The rule of the observer alone.
pub const ALONE: GainRule = GainRule {
    law: "observer",
    knows: KNOWS,
    text: "PD's with w no more than 0.08/h, zeta 0.87 and a window of 4; w_e = min(110, 0.8/h), \
           J, B as known, band 1.5 q, ramp min(3, 0.012 s/h) F_lo/s, largest F_hi",
    constant: CONSTANT,
    tried: TRIED,
    gains_with: |joint, c| around(joint, vec![observer(joint, c, 0.0)]),
};

/// The rule of the sum with feedforward.
pub const WITH_FEEDFORWARD: GainRule = GainRule {
    law: "feedforward+observer",
    knows: KNOWS,
    text: "the observer's, F = v_slip; v_slip = 0.85 sqrt(F_lo F_hi), V_ff = 0.02 q/h, B, 0.85 J",
    constant: CONSTANT,
    tried: TRIED,
    gains_with: |joint, c| around(joint, vec![feedforward(joint), observer(joint, c, slip(joint))]),
};

/// The rule of the sum with feedforward and SRNF.
pub const WITH_SRNF: GainRule = GainRule {
    law: "feedforward+srnf+observer",
    knows: KNOWS,
    text: "feedforward+observer's; v_ms = 0.5 sqrt(F_lo F_hi), alpha = Kp/v_ms",
    constant: CONSTANT,
    tried: TRIED,
    gains_with: |joint, c| {
        let v_ms = 0.5 * joint.middle_breakaway();
        let srnf = SmoothRobustNonlinearGains {
            v_ms: four_digits_single(v_ms),
            alpha: four_digits_single(pd_loop(joint).kp / v_ms),
        };
        let srnf = Gains::SmoothRobustNonlinear(srnf);
        around(joint, vec![feedforward(joint), srnf, observer(joint, c, slip(joint))])
    },
};

fn pd_loop(joint: &JointBounds) -> PdLoop {
    let fastest = PdLoop::of(joint).natural_frequency;
    PdLoop::with(joint, fastest.min(0.08 / joint.sampled.sample_time), DAMPING_RATIO)
}

fn around(joint: &JointBounds, laws: Vec<Gains>) -> ControllerGains {
    ControllerGains { velocity_window: VELOCITY_WINDOW, ..pd_loop(joint).with_laws(laws) }
}

fn slip(joint: &JointBounds) -> f64 {
    0.85 * joint.middle_breakaway()
}

fn feedforward(joint: &JointBounds) -> Gains {
    Gains::Feedforward(FeedforwardGains {
        v_slip: four_digits_single(slip(joint)),
        v_ff: four_digits_single(0.02 * joint.sampled.count / joint.sampled.sample_time),
        viscous: four_digits_single(joint.viscous),
        inertia: four_digits_single(0.85 * joint.inertia),
    })
}

fn observer(joint: &JointBounds, c: f64, slip: f64) -> Gains {
    let h = joint.sampled.sample_time;
    Gains::DisturbanceObserver(DisturbanceObserverGains {
        bandwidth: four_digits_single((0.8 / h).min(110.0)),
        inertia: four_digits_single(joint.inertia),
        viscous: four_digits_single(joint.viscous),
        slip: four_digits_single(slip),
        band: four_digits_single(1.5 * joint.sampled.count),
        ramp: four_digits_single(c.min(0.012 / h) * joint.breakaway[0]),
        largest: four_digits_single(joint.breakaway[1]),
    })
}
