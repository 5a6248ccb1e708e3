//! Two links with their weights at their ends (thesis Fig. 10), hanging down at zero; the second
//! angle is relative to the first link, so that each joint's friction acts on its own coordinate.
//!
//! Thesis eqs. 16 and 17, with `c2 = cos theta2`, `s2 = sin theta2`:
//!
//! ```text
//! D11 = (m1 + m2) l1^2 + m2 l2^2 + 2 m2 l1 l2 c2      D12 = m2 l2^2 + m2 l1 l2 c2      D22 = m2 l2^2
//! T1 = D11 theta1'' + D12 theta2'' - m2 l1 l2 s2 (2 theta1' theta2' + theta2'^2) + D1 + Tf1
//! T2 = D12 theta1'' + D22 theta2'' + m2 l1 l2 s2 theta1'^2 + D2 + Tf2
//! D1 = (m1 + m2) g l1 sin theta1 + m2 g l2 sin(theta1 + theta2)      D2 = m2 g l2 sin(theta1 + theta2)
//! ```

use super::{GRAVITY, Mechanism, Terms};

/// Two links under constant torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLinkArm {
    /// Weights m_1 and m_2 at the ends of the links, kg.
    pub mass: [f64; 2],
    /// Lengths l_1 and l_2 of the links, m.
    pub length: [f64; 2],
    /// Torques T_1 and T_2 at the joints, N m.
    pub torque: [f64; 2],
    /// Angles at the start, rad.
    pub start: [f64; 2],
}

impl Mechanism<2> for TwoLinkArm {
    #[inline]
    fn terms(&self, _: f64, q: &[f64; 2], v: &[f64; 2]) -> Terms<2> {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        let ((s1, c1), (s2, c2)) = (q[0].sin_cos(), q[1].sin_cos());
        let cross = m2 * l1 * l2;
        let d22 = m2 * l2 * l2;
        let d12 = d22 + cross * c2;
        let d11 = (m1 + m2) * l1 * l1 + d22 + 2.0 * cross * c2;
        let outer = m2 * GRAVITY * l2 * (s1 * c2 + c1 * s2);
        let inner = (m1 + m2) * GRAVITY * l1 * s1;
        let whirl = cross * s2;
        Terms {
            mass: [[d11, d12], [d12, d22]],
            force: [
                self.torque[0] + whirl * (2.0 * v[0] + v[1]) * v[1] - inner - outer,
                self.torque[1] - whirl * v[0] * v[0] - outer,
            ],
        }
    }

    fn start(&self) -> [f64; 2] {
        self.start
    }
}
