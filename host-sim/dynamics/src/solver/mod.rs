//! Solvers: how the motion of a mechanism is found.
//!
//! A body with friction is a hybrid system: it has discrete modes (stick, slip one way or the
//! other), a smooth motion in each, and events at which the mode changes.
//!
//! | solver | of | name for users |
//! |---|---|---|
//! | [`ExactAxis`], [`Rk4Axis`] | the robot's axis | `exact`, `rk4` |
//! | [`event_driven`] | set-valued friction | `exact` |
//! | [`piecewise_smooth`] | single-valued friction | `exact` |
//! | [`fixed_step`], [`step_doubling`] | either, without event location | `rk4`, `rk4-adaptive` |
//! | [`nonsmooth`] | either, by time stepping | `nonsmooth` |
//!
//! The first two of the friction lab locate events: a step of `dormand_prince.rs` is accepted by
//! its error, its dense output is searched for the first zero of an event function, and the motion
//! is integrated up to that. All solvers count their events by a guard against Zeno's.

pub mod banded;
mod dense_output;
mod dormand_prince;
pub mod dynamics;
pub mod event_driven;
mod exact;
mod explicit;
pub mod fixed_step;
mod linear;
pub mod modes;
pub mod nonsmooth;
pub mod piecewise_smooth;
mod rk4;
pub(crate) mod roots;
pub mod state;
pub mod step_doubling;
mod trouble;
mod zeno_guard;

pub use exact::ExactAxis;
pub use rk4::Rk4Axis;
pub use trouble::SolverFailure;

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
