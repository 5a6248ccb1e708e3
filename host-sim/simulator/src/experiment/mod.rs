//! Experiments: splits a machine's file into runs.
//!
//! ```text
//! Document -> Machine and its variants -> RunPlan: a controller, a Task -> models, Motion, Course
//! ```
//!
//! A [`RunPlan`] is checked completely before any run. It builds the models, the control core and
//! the parameters of a board for its run.

mod assemble;
mod controller;
mod every_law;
mod home_sensors;
mod joint_bounds;
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
pub use self::parameters::{
    assembled, check_laws, for_a_device, parameters, record, sectors, validate,
};
pub use self::plan::{Experiment, RunPlan};
pub use self::task::Task;
pub use files::document::{Builtin, Document, Origin, builtins, find};
