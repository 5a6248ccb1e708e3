//! Dahl's friction: a bristle that gives way little by little.
//!
//! ```text
//! F_f = sigma0 z,    z' = V (1 - sgn(V) sigma0 z / F_c)
//! ```
//!
//! Time can be divided out: friction is a function of the path. On a way without reversal it tends
//! to `F_c sgn(V)` exponentially, over the distance `F_c/sigma0`; the implicit solver uses this
//! form, exact however long the step:
//!
//! ```text
//! F+ = F_c sgn(V) + (F - F_c sgn(V)) exp(-sigma0 |dx| / F_c)
//! ```
//!
//! Does badly: there is no F_s above F_c and so no stick-slip; a ripple below F_c makes the body
//! drift ([`super::LuGre`] inherits it).

use super::{Implicit, SingleValued};
use dynamics::friction::Coulomb;

/// Stiffness at rest, and the friction in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dahl {
    /// sigma0, N/m or N m/rad.
    pub stiffness: f64,
    /// F_c, N or N m.
    pub coulomb: f64,
}

/// A part of F_c that counts as slipping: reached after a way of 4.6 F_c/sigma0 from rest.
const SLIPPING: f64 = 0.99;

impl Dahl {
    /// `F_c = F_d`, and the stiffness of the Reset Integrator's spring at p_o. F_s has no place in
    /// it.
    pub fn by_rules(levels: Coulomb, range: f64, _mass: f64) -> Self {
        Self { stiffness: levels.slip / range, coulomb: levels.slip }
    }
}

impl SingleValued<1> for Dahl {
    #[inline]
    fn force(&self, _: u8, _: f64, [z]: &[f64; 1]) -> f64 {
        self.stiffness * z
    }

    #[inline]
    fn rate(&self, _: u8, v: f64, [z]: &[f64; 1]) -> [f64; 1] {
        [v - v.abs() * self.stiffness * z / self.coulomb]
    }

    fn slips(&self, _: u8, v: f64, [z]: &[f64; 1]) -> bool {
        v * z > 0.0 && self.stiffness * z.abs() > SLIPPING * self.coulomb
    }

    fn state_scale(&self) -> [f64; 1] {
        [self.coulomb / self.stiffness]
    }
}

impl Implicit<1> for Dahl {
    fn friction(&self, h: f64, _: f64, [z]: &[f64; 1], v_end: f64) -> (f64, f64) {
        let full = self.coulomb.copysign(v_end);
        let left = (-self.stiffness * h * v_end.abs() / self.coulomb).exp();
        let missing = full - self.stiffness * z;
        (full - missing * left, self.stiffness * h * left * missing.abs() / self.coulomb)
    }

    fn largest(&self) -> f64 {
        self.coulomb
    }

    fn states(&self, h: f64, v: f64, z: &[f64; 1], v_end: f64) -> [f64; 1] {
        [self.friction(h, v, z, v_end).0 / self.stiffness]
    }
}
