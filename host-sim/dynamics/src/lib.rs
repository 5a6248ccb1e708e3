//! What moves: joints and mechanisms with friction, and the solvers that move them on.
//!
//! Nothing here knows of the control core, of files or of a command line, so an edit of a law
//! compiles none of it anew. The solvers of the friction lab know a mechanism and its friction as
//! traits; what is solved in closed form names its own, as the thesis's axis and [`joint`] do.

pub mod friction;
pub mod joint;
pub mod mechanism;
mod refused;
pub mod solver;

pub use refused::{InvalidModel, shown};
