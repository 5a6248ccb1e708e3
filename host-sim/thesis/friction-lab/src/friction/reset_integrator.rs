//! The Reset Integrator model (thesis section 2.1.2, Fig. 3): at rest a damped spring of deflection
//! `p`, which ends at `p_o`.
//!
//! ```text
//! p'  = 0    V > 0 and p >= p_o, or V < 0 and p <= -p_o          (eq. 2, whose values are missing in print)
//!     = V    otherwise
//! F_f = K_r (1 + a) p + beta p'    |p| < p_o                     (eq. 3)
//!     = F_d sgn(p)                 p' = 0                        (eq. 5, K_r p at p = +-p_o)
//! ```
//!
//! `p` must not overshoot: a solver that locates switches sets it to exactly `+-p_o`, others clamp
//! it after each step, and the force in motion is F_d whatever rounding did to `p`.
//!
//! The force jumps: by `beta V` and from F_s to F_d where `p` reaches `p_o`, and from F_d back to
//! F_s at the instant at which the body comes to rest. From there it swings about the force that
//! holds the body, with damping ratio 0.354.
//!
//! Does badly: the friction at rest exceeds F_s by `beta V` at break-away, little under slow ramps
//! and much under blows (the thesis says so); and the spring is stiff: steps must be well below
//! `sqrt(m / (K_r (1 + a)))`.

use super::SingleValued;
use dynamics::friction::Coulomb;

/// A spring and damper that give way at `range`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResetIntegrator {
    /// F_s and F_d.
    pub levels: Coulomb,
    /// p_o, m or rad.
    pub range: f64,
    /// K_r, N/m or N m/rad.
    pub stiffness: f64,
    /// beta, N s/m or N m s/rad.
    pub damping: f64,
    /// a, static friction gradient.
    pub gradient: f64,
}

impl ResetIntegrator {
    /// With the parameters that the thesis derives from the levels, p_o and the mass (eqs. 4a-4c).
    /// 0.707 is half the square root of two, of which eq. 12 makes a fraction of critical damping:
    /// `2 * 0.354`.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        let gradient = (levels.stick - levels.slip) / levels.slip;
        let stiffness = levels.slip / range;
        let damping =
            std::f64::consts::FRAC_1_SQRT_2 * (stiffness * (1.0 + gradient) * mass).sqrt();
        Self { levels, range, stiffness, damping, gradient }
    }
}

/// Spring and damper; gives way upwards; gives way downwards.
const PIECES: [u8; 3] = [0, 1, 2];

impl SingleValued<1> for ResetIntegrator {
    #[inline]
    fn force(&self, piece: u8, v: f64, [p]: &[f64; 1]) -> f64 {
        match piece {
            1 => self.levels.slip,
            2 => -self.levels.slip,
            _ => self.stiffness * (1.0 + self.gradient) * p + self.damping * v,
        }
    }

    #[inline]
    fn rate(&self, piece: u8, v: f64, _: &[f64; 1]) -> [f64; 1] {
        [if piece == 0 { v } else { 0.0 }]
    }

    fn slips(&self, piece: u8, _: f64, _: &[f64; 1]) -> bool {
        piece != 0
    }

    #[inline]
    fn piece(&self, v: f64, [p]: &[f64; 1]) -> u8 {
        let [spring, up, down] = PIECES;
        if v > 0.0 && *p >= self.range {
            up
        } else if v < 0.0 && *p <= -self.range {
            down
        } else {
            spring
        }
    }

    fn ends(&self, piece: u8, v: f64, [p]: &[f64; 1]) -> [f64; 2] {
        match piece {
            1 => [v, f64::INFINITY],
            2 => [-v, f64::INFINITY],
            _ => [self.range - p, self.range + p],
        }
    }

    fn next(&self, piece: u8, end: usize, _: f64, z: &mut [f64; 1]) -> u8 {
        let [spring, up, down] = PIECES;
        if piece != spring {
            return spring;
        }
        *z = [if end == 0 { self.range } else { -self.range }];
        if end == 0 { up } else { down }
    }

    fn settle(&self, [p]: &mut [f64; 1]) {
        *p = p.clamp(-self.range, self.range);
    }

    fn state_scale(&self) -> [f64; 1] {
        [self.range]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables 2, 8 (its beta in rad, 4.3 N m s/deg) and 15. The other tables' beta differ from eq.
    /// 4c by up to 46 %.
    #[test]
    fn the_rules_give_the_thesis_s_tables() {
        let spring_mass = (Coulomb { stick: 0.25, slip: 0.20 }, 1e-5, 0.1);
        let pendulum = (Coulomb { stick: 1.2, slip: 0.96 }, 5.7e-4_f64.to_radians(), 1.0);
        let block = (Coulomb { stick: 0.8, slip: 0.6 }, 1e-4, 1.0);
        for ((levels, range, mass), stiffness, gradient) in
            [(spring_mass, 2.0e4, 0.25), (pendulum, 96.5e3, 0.25), (block, 6000.0, 1.0 / 3.0)]
        {
            let model = ResetIntegrator::by_rules(levels, range, mass);
            assert!((model.stiffness / stiffness - 1.0).abs() < 1e-4, "{model:?}");
            assert!((model.gradient / gradient - 1.0).abs() < 1e-12, "{model:?}");
            let top = model.force(0, 0.0, &[range]);
            assert!((top / levels.stick - 1.0).abs() < 1e-12, "{top}");
        }
        let model = ResetIntegrator::by_rules(pendulum.0, pendulum.1, pendulum.2);
        assert!((model.damping - 246.0).abs() < 0.5, "{model:?}");
    }

    #[test]
    fn the_integrator_is_off_only_while_the_body_moves_further_out() {
        let model = ResetIntegrator::by_rules(Coulomb { stick: 0.25, slip: 0.20 }, 1e-5, 0.1);
        for (v, p, piece, rate) in [
            (1.0, 0.9e-5, 0, 1.0),
            (1.0, 1e-5, 1, 0.0),
            (-1.0, 1e-5, 0, -1.0),
            (-1.0, -1e-5, 2, 0.0),
            (1.0, -1e-5, 0, 1.0),
            (0.0, 1e-5, 0, 0.0),
        ] {
            assert_eq!(model.piece(v, &[p]), piece, "V = {v}, p = {p}");
            assert_eq!(model.rate(piece, v, &[p]), [rate], "V = {v}, p = {p}");
        }
    }
}
