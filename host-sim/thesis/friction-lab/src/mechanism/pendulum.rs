//! One link with its weight at its end (thesis Fig. 8), hanging down at `theta = 0`.
//!
//! ```text
//! m l^2 theta'' = T - m g l sin(theta) - T_f
//! ```
//!
//! Thesis eq. 15 omits gravity; the results that it describes need it (with it the first two
//! turning points take more than `T_s`, and the third does not).

use dynamics::mechanism::{GRAVITY, Mechanism, Terms};

/// One link under a constant torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pendulum {
    /// m, kg.
    pub mass: f64,
    /// l, m.
    pub length: f64,
    /// T, N m.
    pub torque: f64,
    /// theta at the begin, rad.
    pub start: f64,
}

impl Mechanism<1> for Pendulum {
    #[inline]
    fn terms(&self, _: f64, q: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        let arm = self.mass * self.length;
        Terms { mass: [[arm * self.length]], force: [self.torque - arm * GRAVITY * q[0].sin()] }
    }

    fn start(&self) -> [f64; 1] {
        [self.start]
    }
}
