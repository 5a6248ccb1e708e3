//! The base axis of the thesis's robot: one rigid joint behind a current amplifier, with viscous
//! and stick-slip friction, and no gravity.
//!
//! Thesis eq. 37, in degrees, seconds and volts:
//!
//! ```text
//! theta'' = kappa (v - v_f - b theta')
//! kappa = n Kt Ka / J
//! ```
//!
//! By Table 20, `kappa` = 1800 * 0.10 * 3.0 / 20 = 27. In SI this is 27 rad/s^2 per volt, with
//! which the thesis's own loop is unstable. With 27 deg/s^2 per volt, nearly every claim of Chapter
//! 3 is reproduced. We use the latter; the former is the variant `literal-si` of the experiment
//! `step-response`. `b` is already in volts per deg/s at the joint (eq. 26 and 37 print it once
//! with and once without the gear ratio), and eq. 37 prints Kf for Kt.

use crate::friction::{AddedFriction, Coulomb};

/// Parameters of the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotAxis {
    /// Acceleration per volt kappa, deg/s^2/V.
    pub gain: f64,
    /// Viscous friction b, V/(deg/s).
    pub viscous: f64,
    /// Stick-slip friction, V.
    pub friction: Coulomb,
    /// Friction that is added, all the time or at times, V.
    pub added: AddedFriction,
}

impl RobotAxis {
    /// Returns the time constant `1 / (kappa b)` of the slipping axis, s; infinite without viscous
    /// friction.
    pub fn time_constant_s(&self) -> f64 {
        1.0 / (self.gain * self.viscous)
    }

    /// Returns the stick-slip friction at a time (s), with the added friction, V.
    #[inline]
    pub fn friction_at(&self, time_s: f64) -> Coulomb {
        self.friction.raised(self.added.at(time_s))
    }
}
