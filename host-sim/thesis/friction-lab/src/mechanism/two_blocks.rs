//! Two blocks and two springs in a row, the far end of the first spring moving.
//!
//! ```text
//! m1 x1'' = K1 (x_in - x1) - K2 (x1 - x2) - F_1
//! m2 x2'' = K2 (x1 - x2) - F_2
//! ```
//!
//! Coupled (thesis Fig. 6, eq. 14): the first friction acts between the blocks, on `V1 - V2`, so
//! that its reaction drives block 2: `F_1 = F_f1`, `F_2 = F_f2 - F_f1`. In the coordinates
//! `r = x1 - x2` and `x2` each friction has one of its own:
//!
//! ```text
//! [ m1   m1      ] [ r''  ]   [ f1      ]   [ F_f1 ]
//! [ m1   m1 + m2 ] [ x2'' ] = [ f1 + f2 ] - [ F_f2 ]
//! ```
//!
//! Independent (thesis Fig. 60, eq. 38): both frictions are those of the floor. The thesis prints
//! `K_1 V_o t` for the drive in both equations; it is `K_1 x_in`, with `x_in` the integral of V_o.

use super::drive::Pull;
use dynamics::mechanism::{Mechanism, Terms};

/// Masses, springs and drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoBlocks {
    /// m_1 and m_2, kg.
    pub mass: [f64; 2],
    /// K_1 and K_2, N/m.
    pub stiffness: [f64; 2],
    /// The far end of the first spring.
    pub pull: Pull,
}

impl TwoBlocks {
    #[inline]
    fn forces(&self, t: f64, x1: f64, x2: f64) -> [f64; 2] {
        let between = self.stiffness[1] * (x1 - x2);
        [self.stiffness[0] * (self.pull.position(t) - x1) - between, between]
    }
}

/// Friction 1 between the blocks, friction 2 between block 2 and the floor; coordinates `x1 - x2`
/// and `x2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledBlocks(pub TwoBlocks);

impl Mechanism<2> for CoupledBlocks {
    #[inline]
    fn terms(&self, t: f64, q: &[f64; 2], _: &[f64; 2]) -> Terms<2> {
        let [m1, m2] = self.0.mass;
        let [f1, f2] = self.0.forces(t, q[0] + q[1], q[1]);
        Terms { mass: [[m1, m1], [m1, m1 + m2]], force: [f1, f1 + f2] }
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.0.pull.next_corner(t)
    }

    fn bodies(&self, q: &[f64; 2]) -> [f64; 2] {
        [q[0] + q[1], q[1]]
    }
}

/// Both frictions between a block and the floor; coordinates `x1` and `x2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndependentBlocks(pub TwoBlocks);

impl Mechanism<2> for IndependentBlocks {
    #[inline]
    fn terms(&self, t: f64, q: &[f64; 2], _: &[f64; 2]) -> Terms<2> {
        let [m1, m2] = self.0.mass;
        Terms { mass: [[m1, 0.0], [0.0, m2]], force: self.0.forces(t, q[0], q[1]) }
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.0.pull.next_corner(t)
    }
}
