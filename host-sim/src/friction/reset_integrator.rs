//! The Reset Integrator of Haessig and Friedland (thesis eqs. 2-5).

use super::{Coulomb, SingleValued};

/// Parameters of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResetIntegrator {
    /// F_s and F_d.
    pub levels: Coulomb,
    /// p_o.
    pub range: f64,
    /// K_r.
    pub stiffness: f64,
    /// beta.
    pub damping: f64,
    /// a.
    pub gradient: f64,
}

impl ResetIntegrator {
    /// Eqs. 4a-4c.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        let gradient = (levels.stick - levels.slip) / levels.slip;
        let stiffness = levels.slip / range;
        let damping = 0.707 * (stiffness * (1.0 + gradient) * mass).sqrt();
        Self { levels, range, stiffness, damping, gradient }
    }
}

impl SingleValued<1> for ResetIntegrator {
    fn force(&self, piece: u8, v: f64, z: &[f64; 1]) -> f64 {
        match piece {
            0 => self.stiffness * (1.0 + self.gradient) * z[0] + self.damping * v,
            1 => self.levels.slip,
            _ => -self.levels.slip,
        }
    }

    fn rate(&self, piece: u8, v: f64, _: &[f64; 1]) -> [f64; 1] {
        [if piece == 0 { v } else { 0.0 }]
    }

    fn slips(&self, piece: u8, _: f64, _: &[f64; 1]) -> bool {
        piece != 0
    }

    fn piece(&self, v: f64, z: &[f64; 1]) -> u8 {
        if v > 0.0 && z[0] >= self.range {
            1
        } else if v < 0.0 && z[0] <= -self.range {
            2
        } else {
            0
        }
    }

    fn ends(&self, piece: u8, v: f64, z: &[f64; 1]) -> [f64; 2] {
        match piece {
            0 => [self.range - z[0], self.range + z[0]],
            1 => [v, f64::INFINITY],
            _ => [-v, f64::INFINITY],
        }
    }

    fn next(&self, piece: u8, end: usize, _: f64, z: &mut [f64; 1]) -> u8 {
        match (piece, end) {
            (0, 0) => {
                z[0] = self.range;
                1
            }
            (0, _) => {
                z[0] = -self.range;
                2
            }
            _ => 0,
        }
    }

    fn settle(&self, z: &mut [f64; 1]) {
        z[0] = z[0].clamp(-self.range, self.range);
    }

    fn state_scale(&self) -> [f64; 1] {
        [self.range]
    }
}
