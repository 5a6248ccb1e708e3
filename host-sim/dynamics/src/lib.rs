//! What moves: joints and mechanisms with friction, and the solvers that move them on.
//!
//! Nothing here knows of the control core, of files or of a command line, so an edit of a law
//! compiles none of it anew. [`mechanism`], [`friction`] and [`solver`] do not know each other by
//! name; [`joint`] puts them together.

pub mod friction;
pub mod joint;
pub mod mechanism;
mod refused;
pub mod solver;

pub use refused::{Refused, shown};
