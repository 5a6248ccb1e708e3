//! Set-valued Stribeck friction: the level at rest falls to that of motion over a velocity, not at
//! once.
//!
//! ```text
//! V = 0:   |F_f| <= F_s, whatever keeps the body at rest
//! V != 0:  F_f = sgn(V) g(|V|) + sigma2 V
//! g(v) = F_d + (F_s - F_d) exp(-(v/v_s)^d)
//! ```
//!
//! The curve g is shared by the models with an internal state ([`super::LuGre`],
//! [`super::ElasticCoulomb`], [`super::MaxwellSlip`]), whose own friction tends to it in steady
//! motion.
//!
//! Friction that falls with velocity drives motion on: growth at the rate `(F_s - F_d)/(m v_s)` or
//! so. A step must be well below the inverse of that.

use super::bristle_speed;
use dynamics::friction::{Coulomb, SetValued};

/// Two levels, and the way from one to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// F_s and F_d.
    pub levels: Coulomb,
    /// Stribeck velocity v_s, m/s or rad/s.
    pub speed: f64,
    /// d, usually from 0.5 to 2.
    pub exponent: f64,
    /// Viscous coefficient sigma2, N s/m or N m s/rad.
    pub viscous: f64,
}

impl Stribeck {
    /// With a v_s that is a tenth of the speed at which a bristle of `range` would throw the body,
    /// so that it is small against the speeds of a stick-slip motion; exponent 2, no viscous part.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        Self {
            levels,
            speed: 0.1 * bristle_speed(levels, range, mass),
            exponent: 2.0,
            viscous: 0.0,
        }
    }

    /// g at a speed >= 0: friction in motion without its viscous part.
    #[inline]
    pub fn level(&self, speed: f64) -> f64 {
        let Coulomb { stick, slip } = self.levels;
        slip + (stick - slip) * (-(speed / self.speed).powf(self.exponent)).exp()
    }
}

impl SetValued for Stribeck {
    fn stick(&self) -> f64 {
        self.levels.stick
    }

    fn slip(&self, speed: f64) -> f64 {
        self.level(speed) + self.viscous * speed
    }
}
