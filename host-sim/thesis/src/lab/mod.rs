//! The friction lab: a mechanism, frictions and a solver from a TOML file, run and judged (thesis
//! Chapter 2 and Appendix A.1). In SI throughout.
//!
//! [`Setup`] is the file, [`plan`] makes runs of it, [`run_all`] runs them; [`output`] and
//! [`figures`] show them. A new mechanism for the command line is a variant of [`MechanismKind`]
//! and a line in `build.rs`; a new model one of [`FrictionModel`] and a line in `models.rs`.

mod build;
mod figure;
mod models;
pub mod output;
mod plan;
mod recorder;
mod run;

pub use figure::figures;
pub use files::setup::{FrictionModel, MechanismKind, Setup, SolverName};
pub use plan::{LabPlan, plan};
pub use recorder::{LabMetrics, LabSample};
pub use run::{LabResult, run, run_all};
