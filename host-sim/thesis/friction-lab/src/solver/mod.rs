//! Solvers of the lab: how the motion of a mechanism is found.
//!
//! | solver | of | name for users |
//! |---|---|---|
//! | [`event_driven`] | set-valued friction | `exact` |
//! | [`piecewise_smooth`] | single-valued friction | `exact` |
//! | [`fixed_step`], [`step_doubling`] | either, without event location | `rk4`, `rk4-adaptive` |
//! | [`nonsmooth`] | either, by time stepping | `nonsmooth` |
//!
//! The first two locate events: a step of `dormand_prince.rs` is accepted by its error, its dense
//! output is searched for the first zero of an event function, and the motion is integrated up to
//! that. All solvers count their events by a guard against Zeno's.

pub mod banded;
mod dense_output;
mod dormand_prince;
pub mod dynamics;
pub mod event_driven;
mod explicit;
pub mod fixed_step;
pub mod nonsmooth;
pub mod piecewise_smooth;
pub mod state;
pub mod step_doubling;
mod trouble;
mod zeno_guard;

pub use trouble::SolverFailure;
