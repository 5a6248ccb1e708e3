//! A block on a rough floor, pulled by a spring whose far end moves (thesis Fig. 4).
//!
//! Thesis eq. 13, with the position `x` of the block for the integral of V, and `x_in` for `V_o t`:
//!
//! ```text
//! m x'' = K (x_in - x) - F_f
//! ```

use super::drive::Pull;
use dynamics::mechanism::{Mechanism, Terms};

/// One block, one spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringMass {
    /// m, kg.
    pub mass: f64,
    /// K, N/m.
    pub stiffness: f64,
    /// The spring's far end.
    pub pull: Pull,
}

impl Mechanism<1> for SpringMass {
    #[inline]
    fn terms(&self, t: f64, q: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[self.mass]], force: [self.stiffness * (self.pull.position(t) - q[0])] }
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.pull.next_corner(t)
    }
}
