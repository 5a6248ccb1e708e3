//! Elastic Coulomb friction (Kikuuwe, Takesue, Sano, Mochiyama and Fujimoto, IEEE Trans. Robotics
//! 22(6), 2006): a damped spring whose far end slides as soon as, and only while, its force is at
//! the limit.
//!
//! ```text
//! F_f = clamp(K s + D V, -g(|V|), g(|V|)) + sigma2 V,    s' = (F_f - sigma2 V - K s) / D
//! ```
//!
//! which is `s' = V` below the limit. Implicit step of h, with g at its begin:
//!
//! ```text
//! f = clamp(K (s + h V+) + D V+, -g, g),    s+ = (f + D s/h) / (K + D/h),    F+ = f + sigma2 V+
//! ```
//!
//! The clamp is the paper's; the continuous form is the limit `h -> 0` of it, and g, which depends
//! on velocity here, is [`super::Stribeck`]'s.
//!
//! Guarantees: no drift. Below its limit it is a spring and a damper and nothing else. Does badly:
//! pre-sliding has no hysteresis beyond the damper's.

use super::{Implicit, SingleValued, Stribeck, impedance};
use dynamics::friction::Coulomb;

/// A damped spring with a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticCoulomb {
    /// K, N/m or N m/rad.
    pub stiffness: f64,
    /// D, N s/m or N m s/rad; not zero.
    pub damping: f64,
    /// The limit g, and sigma2.
    pub sliding: Stribeck,
}

impl ElasticCoulomb {
    /// Returns the model with stiffness and damping of the Reset Integrator's spring (eqs. 4a-4c),
    /// and the limit of [`Stribeck::by_rules`].
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        let stiffness = levels.stick / range;
        let damping = std::f64::consts::FRAC_1_SQRT_2 * impedance(stiffness, mass);
        Self { stiffness, damping, sliding: Stribeck::by_rules(levels, range, mass) }
    }

    /// What spring and damper would do without a limit, and the limit.
    #[inline]
    fn wanted(&self, v: f64, s: f64) -> (f64, f64) {
        (self.stiffness * s + self.damping * v, self.sliding.level(v.abs()))
    }

    /// The force of the clamp in a step, and its slope over the velocity at the end.
    fn clamped(&self, h: f64, v: f64, s: f64, v_end: f64) -> (f64, f64) {
        let wanted = self.stiffness * (s + h * v_end) + self.damping * v_end;
        let limit = self.sliding.level(v.abs());
        let slope = if wanted.abs() < limit { self.stiffness * h + self.damping } else { 0.0 };
        (wanted.max(-limit).min(limit), slope)
    }
}

impl SingleValued<1> for ElasticCoulomb {
    #[inline]
    fn force(&self, _: u8, v: f64, [s]: &[f64; 1]) -> f64 {
        let (wanted, limit) = self.wanted(v, *s);
        wanted.max(-limit).min(limit) + self.sliding.viscous * v
    }

    #[inline]
    fn rate(&self, _: u8, v: f64, [s]: &[f64; 1]) -> [f64; 1] {
        let (wanted, limit) = self.wanted(v, *s);
        if wanted.abs() <= limit {
            return [v];
        }
        [(limit.copysign(wanted) - self.stiffness * s) / self.damping]
    }

    fn slips(&self, _: u8, v: f64, [s]: &[f64; 1]) -> bool {
        let (wanted, limit) = self.wanted(v, *s);
        wanted.abs() > limit
    }

    fn state_scale(&self) -> [f64; 1] {
        [self.sliding.levels.stick / self.stiffness]
    }
}

impl Implicit<1> for ElasticCoulomb {
    fn friction(&self, h: f64, v: f64, [s]: &[f64; 1], v_end: f64) -> (f64, f64) {
        let (force, slope) = self.clamped(h, v, *s, v_end);
        (force + self.sliding.viscous * v_end, slope + self.sliding.viscous)
    }

    fn largest(&self) -> f64 {
        self.sliding.levels.stick
    }

    fn states(&self, h: f64, v: f64, [s]: &[f64; 1], v_end: f64) -> [f64; 1] {
        let (force, _) = self.clamped(h, v, *s, v_end);
        [(force * h + self.damping * s) / (self.stiffness * h + self.damping)]
    }
}
