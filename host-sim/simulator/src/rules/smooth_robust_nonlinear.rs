//! SRNF: the largest effort that starts the joint by eq. 36, and a slope at the target in multiples
//! of Kp.
//!
//! ```text
//! v_ms  = F_hi + u_L + u_q
//! alpha = min(c Kp/v_ms, (J (0.66/h)^2 - Kp)/v_ms, 0.242/q)
//! c     = 100; no more than zeta/(1.5 w_n h) - 1 where a load drives the joint (u_L > 0)
//! ```
//!
//! Near the target the law adds the stiffness `v_ms alpha` to Kp. A slope of c Kp has the natural
//! frequency sqrt(1 + c) w_n and the damping ratio zeta/sqrt(1 + c) there. 0.66/h is the natural
//! frequency that the thesis's own gains have there at 20 ms (Kp 1, v_ms 0.4, alpha 100), and their
//! alpha is 0.242 a count. The thesis's own c is 40.
//!
//! Tuned on 100 joints each of eight families, seed 1000001, profiled moves; success is the mean of
//! the families:
//!
//! | rule | success at 1 kHz, % | at 200 Hz, four families, % |
//! |---|---|---|
//! | v_ms = 0.5 F_hi + u_L, which of a data sheet is its stick friction and load, c = 30 | 41.4 | 27.0 |
//! | v_ms = 0.7 F_hi + u_L, c = 30 | 50.6 | 33.5 |
//! | v_ms = F_hi + u_L, c = 30 | 54.6 | 32.8 |
//! | v_ms = F_hi + u_L, c = 100, no more than 0.66/h | 60.0 | 33.5 |
//!
//! Without u_L an overhauling joint succeeds in 19 % instead of 47 % of the cases. c = 100 has more
//! false trips than c = 30 where the encoder is on the load (47 instead of 37 of 100 joints).
//!
//! With a slope of 100 Kp the loop is stable only by friction, which ends its swings, since they
//! are no larger than the friction. With u_L in v_ms the swings are larger, and the motor
//! overheats. So where a load drives the joint, the loop has to be stable without friction. A
//! position is 1.5 samples late (half of a held output, and a computation of up to one), which
//! reduces the damping `Kd = 2 zeta J w_n` of PD by `(1 + c) Kp 1.5 h`. The bound above leaves half
//! of that damping. It was compared on 100 joints each of three overhauling families, seeds 1000001
//! and 1000005, profiled moves: 31 to 48 % succeed, and none of 600 trips a monitor. Without it,
//! 215 of 500 `overhauling` joints of seed 2028 overheat, and with it none.

use stiction::control::laws::{Gains, SmoothRobustNonlinearGains};

use super::{DAMPING_RATIO, GainRule, JointBounds, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "srnf",
    knows: "inertia, viscous friction, the highest breakaway effort and the largest load",
    text: "PD's; v_ms = F_hi + the largest load + one step of the effort, alpha = min(100 Kp, J \
           (0.66/h)^2 - Kp)/v_ms, no more than 0.242/q; with a load, (0.9/(1.5 w_n h) - 1) Kp \
           instead of 100 Kp if that is less",
    constant: CONSTANT,
    tried: TRIED,
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        pd.with_laws(vec![law(joint, &pd, c)])
    },
};

/// The constant c.
pub(super) const CONSTANT: f64 = 100.0;
pub(super) const TRIED: &[f64] = &[3.0, 10.0, 30.0, 100.0];

/// Largest natural frequency at the target times sample time, rad, as on the thesis's axis.
const STIFFEST: f64 = 0.66;

/// Delay of a position in the loop, samples: half of a held output, and a computation of up to one.
const LATE: f64 = 1.5;

/// alpha times the angle of a count, as on the thesis's axis.
const PER_COUNT: f64 = 0.242;

/// Returns the law around a PD loop with a constant.
pub(super) fn law(joint: &JointBounds, pd: &PdLoop, c: f64) -> Gains {
    let sampled = &joint.sampled;
    let v_ms = joint.breakaway[1] + joint.load + sampled.lsb;
    let stiffest = joint.inertia * (STIFFEST / sampled.sample_time).powi(2) - pd.kp;
    let stable = DAMPING_RATIO / (LATE * pd.natural_frequency * sampled.sample_time) - 1.0;
    let c = if joint.load > 0.0 { c.min(stable) } else { c };
    let alpha = ((c * pd.kp).min(stiffest) / v_ms).min(PER_COUNT / sampled.count);
    Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains {
        v_ms: four_digits_single(v_ms),
        alpha: four_digits_single(alpha),
    })
}
