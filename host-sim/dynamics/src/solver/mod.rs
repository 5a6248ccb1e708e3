//! Solvers of a joint: how its motion between two samples is found.
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

/// A change between sticking and slipping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When, s. Within a call of [`AxisSolver::advance`]: since its begin.
    pub time_s: f64,
    /// What happened.
    pub kind: EventKind,
}

/// What can happen to a joint with stick-slip friction.
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
    /// Moves the axis on by `duration_s` under the constant effort `v`, and reports events on the
    /// way.
    fn advance(
        &mut self,
        v: f64,
        duration_s: f64,
        friction: &crate::friction::Coulomb,
        on: &mut impl FnMut(Event),
    );

    /// Joint position, deg.
    fn position(&self) -> f64;

    /// Position that the encoder's disc has, deg: another one if the disc sits on the motor of an
    /// elastic joint, or if its readings are noisy.
    #[inline]
    fn measured(&self) -> f64 {
        self.position()
    }

    /// Position that a disc on the motor has, of a joint with a second encoder there, deg.
    #[inline]
    fn measured_at_motor(&self) -> f64 {
        self.position()
    }

    /// True position of the side of the gear that the encoder sits on, deg.
    #[inline]
    fn at_encoder(&self) -> f64 {
        self.position()
    }

    /// True position of the load, deg.
    #[inline]
    fn at_load(&self) -> f64 {
        self.position()
    }

    /// Joint velocity, deg/s.
    fn velocity(&self) -> f64;

    /// Whether the joint is stuck.
    fn stuck(&self) -> bool;

    /// How often the acceleration was evaluated so far.
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
    fn stuck(&self) -> bool {
        (**self).stuck()
    }

    fn derivative_evaluations(&self) -> u64 {
        (**self).derivative_evaluations()
    }
}
