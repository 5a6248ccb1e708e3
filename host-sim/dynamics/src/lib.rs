//! Joints with friction, and the solvers that move them on.
//!
//! Nothing here uses the control core, files or a command line, so that an edit of a law does not
//! recompile it.

pub mod friction;
pub mod joint;
pub mod mechanism;
mod refused;
pub mod solver;

pub use refused::{InvalidModel, shown};
