//! The thesis: its friction lab, and the report that repeats its experiments.
//!
//! The friction [`lab`] does not use the control core: mechanisms, frictions and solvers (Chapter
//! 2). The `report` shows every figure and table of the thesis beside ours, and judges its claims.
//! A reader with a joint of their own needs nothing from here.

pub mod lab;
#[cfg(feature = "report")]
pub mod report;
