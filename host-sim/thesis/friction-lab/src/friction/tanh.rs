//! Friction smoothed by a hyperbolic tangent, so that it is a function of velocity alone: no rest,
//! no switch.
//!
//! ```text
//! F_f = F_d tanh(10 u) + (F_s - F_d) u exp((1 - u^2)/2),    u = V / v_b
//! ```
//!
//! The thesis's idea of section 4.2 (its SRNF compensator has the same function). The second term
//! is ours: it has its maximum of one at `u = 1`, so that friction peaks at F_s at the break-away
//! speed v_b, up to `1 - tanh 10 = 4e-9`; without it nothing would stick and slip.
//!
//! Does badly: a body under a load below F_s never rests, it creeps. With `F_s = F_d` and a load P
//! at `v_b/10 atanh(P/F_d)`. The smaller v_b, the less creep and the stiffer the equations: the
//! velocity decays at the rate `(10 F_d + 1.65 (F_s - F_d)) / (m v_b)` near zero.

use super::{Implicit, SingleValued, bristle_speed};
use dynamics::friction::Coulomb;

/// Levels, and the speed that stands for rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tanh {
    /// F_s and F_d.
    pub levels: Coulomb,
    /// Break-away speed v_b, m/s or rad/s: below it the body counts as at rest.
    pub speed: f64,
}

impl Tanh {
    /// With a break-away speed of the size of [`super::Stribeck::by_rules`]'s v_s.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        Self { levels, speed: 0.1 * bristle_speed(levels, range, mass) }
    }

    /// The second term over its velocity.
    fn bump(&self, v: f64) -> f64 {
        let u = v / self.speed;
        (self.levels.stick - self.levels.slip) / self.speed * (0.5 * (1.0 - u * u)).exp()
    }

    fn smooth(&self, v: f64) -> f64 {
        self.levels.slip * (10.0 * v / self.speed).tanh()
    }
}

impl SingleValued<0> for Tanh {
    #[inline]
    fn force(&self, _: u8, v: f64, _: &[f64; 0]) -> f64 {
        self.smooth(v) + self.bump(v) * v
    }

    fn rate(&self, _: u8, _: f64, _: &[f64; 0]) -> [f64; 0] {
        []
    }

    fn slips(&self, _: u8, v: f64, _: &[f64; 0]) -> bool {
        v.abs() > self.speed
    }

    fn state_scale(&self) -> [f64; 0] {
        []
    }
}

/// The factor of the second term that falls with velocity is taken at the begin of the step.
impl Implicit<0> for Tanh {
    fn friction(&self, _: f64, v: f64, _: &[f64; 0], v_end: f64) -> (f64, f64) {
        let smooth = self.smooth(v_end);
        let part = smooth / self.levels.slip;
        let slope = 10.0 * self.levels.slip / self.speed * (1.0 - part * part);
        let bump = self.bump(v);
        (smooth + bump * v_end, slope + bump)
    }

    fn largest(&self) -> f64 {
        self.levels.stick
    }

    fn states(&self, _: f64, _: f64, _: &[f64; 0], _: f64) -> [f64; 0] {
        []
    }
}
