//! Proxy-based sliding mode: a PID between joint and proxy, and a surface twice as slow as it.
//!
//! ```text
//! K = Kp,  D = Kd,  L = c Kp w_n,  H = 2/w_n
//! ```
//!
//! PD has the same gains. They are without effect, but the monitors' thresholds follow from them.

use stiction::control::laws::{Gains, ProxySlidingModeGains};

use super::{GainRule, PdLoop, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "proxy-sliding-mode",
    knows: "inertia and viscous friction",
    text: "K and D as PD's Kp and Kd; L = 0.2 K w, H = 2/w",
    constant: 0.2,
    tried: &[0.1, 0.2, 0.4],
    gains_with: |joint, c| {
        let pd = PdLoop::of(joint);
        let gains = ProxySlidingModeGains {
            stiffness: four_digits_single(pd.kp),
            damping: four_digits_single(pd.kd),
            integral: four_digits_single(c * pd.kp * pd.natural_frequency),
            surface_time: four_digits_single(2.0 / pd.natural_frequency),
        };
        pd.with_laws(vec![Gains::ProxySlidingMode(gains)])
    },
};
