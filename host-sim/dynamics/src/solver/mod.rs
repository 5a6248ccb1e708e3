//! Solvers: the motion of a joint between two samples.
//!
//! [`ExactAxis`] is the closed form of the robot's axis, and [`Rk4Axis`] the thesis's method
//! (`exact` and `rk4` for users). A body with friction is a hybrid system: it has discrete
//! [`modes`] (stick, slip one way or the other), a smooth motion in each, and events at which the
//! mode changes.

mod exact;
pub mod linear;
pub mod modes;
mod rk4;
pub mod roots;

pub use exact::ExactAxis;
pub use rk4::Rk4Axis;

/// Change of a body's motion: it breaks away, sticks, or reverses without rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time of the event, s; in a call of [`AxisSolver::advance`], since the start of the call.
    pub time_s: f64,
    /// Kind of the change.
    pub kind: EventKind,
}

/// Kind of an [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EventKind {
    /// From rest to motion.
    Break,
    /// From motion to rest.
    Stick,
    /// From motion one way to motion the other way, without rest.
    Reverse,
}

/// A moving axis whose input is constant over an interval.
pub trait AxisSolver {
    /// Moves the axis for `duration_s` under the constant effort `v` (V), and reports the events in
    /// this time.
    fn advance(
        &mut self,
        v: f64,
        duration_s: f64,
        friction: &crate::friction::Coulomb,
        on: &mut impl FnMut(Event),
    );

    /// Returns the joint position, deg.
    fn position(&self) -> f64;

    /// Returns the position that the encoder reads, deg. It differs from [`Self::position`] if the
    /// disc sits on the motor of an elastic joint, or if the readings are noisy.
    #[inline]
    fn measured(&self) -> f64 {
        self.position()
    }

    /// Returns the position that the motor's encoder of a joint with two encoders reads, deg.
    #[inline]
    fn measured_at_motor(&self) -> f64 {
        self.position()
    }

    /// Returns the true position of the encoder's side of the gear, deg.
    #[inline]
    fn at_encoder(&self) -> f64 {
        self.position()
    }

    /// Returns the true position of the load, deg.
    #[inline]
    fn at_load(&self) -> f64 {
        self.position()
    }

    /// Returns the joint velocity, deg/s.
    fn velocity(&self) -> f64;

    /// Returns the velocity of the motor behind the gear, deg/s of the joint.
    #[inline]
    fn motor_velocity(&self) -> f64 {
        self.velocity()
    }

    /// Returns the rest of the former effort behind the lag of the winding, V: the present effort
    /// minus the held one.
    #[inline]
    fn effort_left(&self) -> f64 {
        0.0
    }

    /// Takes a part of the viscous friction away, V s/deg: the back-EMF of a winding that is open.
    /// 0 closes the winding. Without effect on a solver without a motor.
    fn open_winding(&mut self, _back_emf: f64) {}

    /// Returns whether the joint is stuck.
    fn stuck(&self) -> bool;

    /// Returns the number of evaluations of the acceleration so far.
    fn derivative_evaluations(&self) -> u64;
}

impl<S: AxisSolver> AxisSolver for &mut S {
    #[inline]
    fn advance(
        &mut self,
        v: f64,
        duration_s: f64,
        friction: &crate::friction::Coulomb,
        on: &mut impl FnMut(Event),
    ) {
        (**self).advance(v, duration_s, friction, on);
    }

    #[inline]
    fn position(&self) -> f64 {
        (**self).position()
    }

    #[inline]
    fn measured(&self) -> f64 {
        (**self).measured()
    }

    #[inline]
    fn measured_at_motor(&self) -> f64 {
        (**self).measured_at_motor()
    }

    #[inline]
    fn at_encoder(&self) -> f64 {
        (**self).at_encoder()
    }

    #[inline]
    fn at_load(&self) -> f64 {
        (**self).at_load()
    }

    #[inline]
    fn velocity(&self) -> f64 {
        (**self).velocity()
    }

    #[inline]
    fn motor_velocity(&self) -> f64 {
        (**self).motor_velocity()
    }

    #[inline]
    fn effort_left(&self) -> f64 {
        (**self).effort_left()
    }

    fn open_winding(&mut self, back_emf: f64) {
        (**self).open_winding(back_emf);
    }

    #[inline]
    fn stuck(&self) -> bool {
        (**self).stuck()
    }

    fn derivative_evaluations(&self) -> u64 {
        (**self).derivative_evaluations()
    }
}
