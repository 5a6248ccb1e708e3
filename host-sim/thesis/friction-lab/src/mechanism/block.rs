//! A block on a rough floor, pushed by a wave of force (thesis section 2.3): `m x'' = F_i(t) -
//! F_f`.

use super::drive::Wave;
use dynamics::mechanism::{Mechanism, Terms};

/// One block and one force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenBlock {
    /// m, kg.
    pub mass: f64,
    /// F_i.
    pub push: Wave,
}

impl Mechanism<1> for DrivenBlock {
    fn terms(&self, t: f64, _: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[self.mass]], force: [self.push.force(t)] }
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.push.next_corner(t)
    }
}
