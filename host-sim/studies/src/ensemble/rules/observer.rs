//! The disturbance observer beside PD, and in sums with feedforward and SRNF: the hybrids of the
//! thesis's own laws.
//!
//! ```text
//! w = min(w_n, 0.08/h),  Kp = J w^2,  Kd = 1.74 J w - B
//! observer     w_e = min(110, 0.8/h),  J and B as told,  theta_o = 1.5 q,
//!              R = min(c, 0.012 s/h) F_lo/s,  largest F_hi,
//!              F = v_slip in a sum with feedforward, else 0
//! feedforward  v_slip = 0.85 sqrt(F_lo F_hi),  V_ff = 0.02 q/h,  B,  0.85 J
//! SRNF         v_ms = 0.5 sqrt(F_lo F_hi),  alpha = Kp/v_ms
//! ```
//!
//! The loop is slower than PD's own at long sample times: the observer takes away the friction that
//! damps it. A ramp of 0.012 F_lo a sample exceeds the friction by some hundredths of it when the
//! breakaway is seen, three or four samples late. The feedforward's inertia is less than what is
//! told, since the observer and a sample of delay add to it.

use stiction::control::laws::{
    DisturbanceObserverGains, FeedforwardGains, Gains, SmoothRobustNonlinearGains,
};
use stiction::control::pd::PdGains;

use super::{Rule, Told, Tuned};

/// Positions in the velocity's regression: half a sample less delay than with the thesis's five,
/// which counts where the observer has taken the friction away.
const VELOCITY_WINDOW: u32 = 4;

/// The constant c of all three, 1/s.
const CONSTANT: f64 = 3.0;
const TRIED: &[f64] = &[1.0, 3.0, 10.0];

/// The rule of the observer alone.
pub const ALONE: Rule = Rule {
    law: "observer",
    text: "PD's with w no more than 0.08/h, zeta 0.87 and a window of 4; w_e = min(110, 0.8/h), \
           J, B as told, band 1.5 q, ramp min(3, 0.012 s/h) F_lo/s, largest F_hi",
    constant: CONSTANT,
    tried: TRIED,
    tune: |told, c| around(told, vec![observer(told, c, 0.0)]),
};

/// The rule of the sum with feedforward.
pub const WITH_FEEDFORWARD: Rule = Rule {
    law: "feedforward+observer",
    text: "the observer's, F = v_slip; v_slip = 0.85 sqrt(F_lo F_hi), V_ff = 0.02 q/h, B, 0.85 J",
    constant: CONSTANT,
    tried: TRIED,
    tune: |told, c| around(told, vec![feedforward(told), observer(told, c, slip(told))]),
};

/// The rule of the sum with feedforward and SRNF.
pub const WITH_SRNF: Rule = Rule {
    law: "feedforward+srnf+observer",
    text: "feedforward+observer's; v_ms = 0.5 sqrt(F_lo F_hi), alpha = Kp/v_ms",
    constant: CONSTANT,
    tried: TRIED,
    tune: |told, c| {
        let v_ms = 0.5 * told.middle_breakaway();
        let alpha = told.inertia * frequency(told).powi(2) / v_ms;
        let srnf = SmoothRobustNonlinearGains { v_ms: v_ms as f32, alpha: alpha as f32 };
        let srnf = Gains::SmoothRobustNonlinear(srnf);
        around(told, vec![feedforward(told), srnf, observer(told, c, slip(told))])
    },
};

fn frequency(told: &Told) -> f64 {
    told.natural_frequency().min(0.08 / told.sample_time)
}

fn around(told: &Told, laws: Vec<Gains>) -> Tuned {
    let w = frequency(told);
    let kd = (1.74 * told.inertia * w - told.viscous).max(0.0);
    let pd = PdGains { kp: (told.inertia * w * w) as f32, kd: kd as f32 };
    Tuned { pd, velocity_window: VELOCITY_WINDOW, laws }
}

fn slip(told: &Told) -> f64 {
    0.85 * told.middle_breakaway()
}

fn feedforward(told: &Told) -> Gains {
    Gains::Feedforward(FeedforwardGains {
        v_slip: slip(told) as f32,
        v_ff: (0.02 * told.count / told.sample_time) as f32,
        viscous: told.viscous as f32,
        inertia: (0.85 * told.inertia) as f32,
    })
}

fn observer(told: &Told, c: f64, slip: f64) -> Gains {
    let h = told.sample_time;
    Gains::DisturbanceObserver(DisturbanceObserverGains {
        bandwidth: (0.8 / h).min(110.0) as f32,
        inertia: told.inertia as f32,
        viscous: told.viscous as f32,
        slip: slip as f32,
        band: (1.5 * told.count) as f32,
        ramp: (c.min(0.012 / h) * told.breakaway[0]) as f32,
        largest: told.breakaway[1] as f32,
    })
}
