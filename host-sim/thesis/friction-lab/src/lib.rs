//! The thesis's friction lab: friction models, mechanisms, and the solvers that run them (Chapter 2
//! and Appendix A.1). In SI throughout.
//!
//! A solver knows a mechanism and its friction as traits. Nothing here uses the control core; a
//! reader with a joint of their own needs nothing from here.

pub mod friction;
pub mod mechanism;
pub mod solver;
