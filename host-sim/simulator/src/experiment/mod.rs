//! Experiments: a machine's file, taken apart into runs.
//!
//! ```text
//! Document -> Machine and its variants -> RunPlan: a controller, a Task -> models, Motion, Course
//! ```
//!
//! A [`RunPlan`] is checked as a whole before anything is run, and answers with the models, the
//! control core and the parameters of a board that the run needs.

mod assemble;
mod controller;
mod every_law;
mod motion;
mod parameters;
mod plan;
mod plant;
mod refusal;
mod task;
mod truth;

pub use self::controller::about_law;
pub use self::every_law::{every_controller, with_every_law};
pub use self::motion::position;
pub use self::parameters::{assembled, check_laws, validate};
pub use self::parameters::{for_a_device, parameters, record, sectors};
pub use self::plan::{Experiment, RunPlan};
pub use self::task::Task;
pub use crate::document::{Builtin, Document, Origin, builtins, find};
