//! A block on a rough floor, pulled by a spring whose far end moves (thesis Fig. 4).
//!
//! Thesis eq. 13, with the position `x` of the block for the integral of V:
//!
//! ```text
//! m x'' = K (x_in - x) - F_f          x_in = V_o t
//! ```

use super::{Mechanism, Terms};

/// One block, one spring, one end that moves at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringMass {
    /// m, kg.
    pub mass: f64,
    /// K, N/m.
    pub stiffness: f64,
    /// V_o of the spring's far end, m/s.
    pub speed: f64,
}

impl Mechanism<1> for SpringMass {
    fn terms(&self, t: f64, q: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[self.mass]], force: [self.stiffness * (self.speed * t - q[0])] }
    }
}
