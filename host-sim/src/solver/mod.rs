//! Solvers: how the motion of a mechanism is found.
//!
//! Of the robot's axis: [`ExactAxis`], [`Rk4Axis`]. Of any mechanism of the friction lab: [`located`] and [`pieces`]
//! (`exact`), [`fixed`] (`rk4`), [`step_doubling`] (`rk4-adaptive`), [`nonsmooth`].

pub mod banded;
mod between;
mod dormand_prince;
pub mod dynamics;
mod exact;
mod explicit;
pub mod fixed;
mod linear;
pub mod located;
pub mod modes;
pub mod nonsmooth;
pub mod pieces;
mod rk4;
mod roots;
pub mod state;
pub mod step_doubling;
mod storm;
mod trouble;

pub use exact::ExactAxis;
pub use rk4::Rk4Axis;
pub use trouble::Trouble;

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
    /// Moves the axis on by `duration_s` under the constant effort `v`, and reports events on the way.
    fn advance(
        &mut self,
        v: f64,
        duration_s: f64,
        friction: &crate::friction::Coulomb,
        on: &mut impl FnMut(Event),
    );

    /// Joint position, deg.
    fn position(&self) -> f64;

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
