//! Joints with friction, and their solvers.
//!
//! This crate does not depend on the control core, files or a command line, so that an edit of a
//! law does not recompile it.

pub mod friction;
pub mod joint;
pub mod mechanism;
mod refused;
pub mod solver;

pub use refused::{InvalidModel, shown};
