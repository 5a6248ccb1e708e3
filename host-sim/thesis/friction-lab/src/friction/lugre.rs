//! The LuGre model (Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Automatic Control
//! 40(3), 1995): Dahl's bristle with a level that depends on velocity, and damping.
//!
//! ```text
//! F_f = sigma0 z + sigma1 z' + sigma2 V,    z' = V - sigma0 |V| z / g(|V|)
//! ```
//!
//! with the Stribeck curve g of [`super::Stribeck`]. Implicit step of h, with |V| and g taken at
//! its begin:
//!
//! ```text
//! phi = 1/(1 + h sigma0 |V|/g),    z+ = phi (z + h V+),    F+ = sigma0 z+ + sigma1 (z+ - z)/h + sigma2 V+
//! ```
//!
//! Guarantees: `sigma0 |z| <= F_s` once it was. Energy is never given, in terms of velocity in and
//! force out, only if `sigma2 > sigma1 (F_s - F_d)/F_d` (Astrom and Canudas de Wit, IEEE Control
//! Systems 28(6), 2008); [`LuGre::is_passive`] checks this.
//!
//! Does badly: under a ripple below F_s the body drifts; per cycle of a slow one between `u1 F_s`
//! and `u2 F_s` (both of one sign) by `F_s/sigma0 ln((1 - u1^2)/(1 - u2^2))`. An explicit Euler
//! step diverges at `h sigma0 |V|/g > 2`, and other explicit steps not much later.

use super::{Implicit, SingleValued, Stribeck, impedance};
use dynamics::friction::Coulomb;

/// A bristle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuGre {
    /// sigma0, N/m or N m/rad.
    pub stiffness: f64,
    /// sigma1, N s/m or N m s/rad.
    pub damping: f64,
    /// Friction in steady motion: g and sigma2.
    pub sliding: Stribeck,
}

/// A part of g/sigma0 from which a deflection counts as slipping.
const SLIPPING: f64 = 0.99;

impl LuGre {
    /// The stiffness and damping of the Reset Integrator's spring (eqs. 4a-4c), and
    /// [`Stribeck::by_rules`]. With F_s above F_d this is not passive, as there is no viscous part.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        let stiffness = levels.stick / range;
        let damping = std::f64::consts::FRAC_1_SQRT_2 * impedance(stiffness, mass);
        Self { stiffness, damping, sliding: Stribeck::by_rules(levels, range, mass) }
    }

    /// Whether the friction can never give energy.
    pub fn is_passive(&self) -> bool {
        let Coulomb { stick, slip } = self.sliding.levels;
        stick == slip || self.sliding.viscous > self.damping * (stick - slip) / slip
    }

    /// `sigma0 |V| / g`, 1/s.
    #[inline]
    fn relaxation(&self, v: f64) -> f64 {
        self.stiffness * v.abs() / self.sliding.level(v.abs())
    }
}

impl SingleValued<1> for LuGre {
    #[inline]
    fn force(&self, piece: u8, v: f64, z: &[f64; 1]) -> f64 {
        let [rate] = self.rate(piece, v, z);
        self.stiffness * z[0] + self.damping * rate + self.sliding.viscous * v
    }

    #[inline]
    fn rate(&self, _: u8, v: f64, [z]: &[f64; 1]) -> [f64; 1] {
        [v - self.relaxation(v) * z]
    }

    fn slips(&self, _: u8, v: f64, [z]: &[f64; 1]) -> bool {
        v * z > 0.0 && self.stiffness * z.abs() > SLIPPING * self.sliding.level(v.abs())
    }

    fn state_scale(&self) -> [f64; 1] {
        [self.sliding.levels.stick / self.stiffness]
    }
}

impl Implicit<1> for LuGre {
    fn friction(&self, h: f64, v: f64, z: &[f64; 1], v_end: f64) -> (f64, f64) {
        let [z_end] = self.states(h, v, z, v_end);
        let relaxation = self.relaxation(v);
        let part = 1.0 / (1.0 + h * relaxation);
        // (z+ - z)/h, without the difference of two deflections that are nearly the same.
        let rate = part * (v_end - relaxation * z[0]);
        let viscous = self.sliding.viscous;
        (
            self.stiffness * z_end + self.damping * rate + viscous * v_end,
            (self.stiffness * h + self.damping) * part + viscous,
        )
    }

    fn largest(&self) -> f64 {
        self.sliding.levels.stick
    }

    fn states(&self, h: f64, v: f64, [z]: &[f64; 1], v_end: f64) -> [f64; 1] {
        [(z + h * v_end) / (1.0 + h * self.relaxation(v))]
    }
}
