//! Experiments: a machine's file, taken apart into runs.

mod assemble;
mod builtin;
mod document;
mod plan;
mod plant;

pub(crate) use assemble::about_law;
pub use assemble::position;
pub use builtin::{Builtin, builtins, find};
pub use document::{Document, Origin};
pub use plan::{Experiment, Motion, RunPlan};
