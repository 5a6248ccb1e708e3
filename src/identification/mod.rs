//! The identification of a joint: its friction levels from a ramp (`ramp`), and all of its
//! parameters from a bounded sequence of motions (`sequence`).
//!
//! ```text
//! sequence.rs   what the joint does, one phase after the other, within the bounds of open_loop.rs
//!   settings.rs    its bounds, and what follows from them
//!   plan.rs        its steps
//!   pulses.rs      two efforts from rest -> a rough inertia
//!   breakaway.rs   effort rises until the joint leaves its place
//!   follower.rs    a stiff loop leads the joint along speeds that the sequence asks for
//!   progress.rs    effort beyond the friction moves the joint, or the sequence ends
//!   window.rs      a stretch of sliding -> a row of the regression, in integral form
//!   givens.rs      rows -> a triangle, by rotations
//! model.rs      the triangle -> parameters, standard deviations, relative residual
//! findings.rs   the report over the link, and its doubts
//! ```

mod breakaway;
mod findings;
mod follower;
pub mod givens;
mod model;
mod plan;
mod progress;
mod pulses;
mod ramp;
mod sequence;
mod settings;
mod window;

pub use breakaway::{Breakaway, Push};
pub use findings::{BreakawayLevels, Doubts, Findings, MapPoint, Outcome, Summary};
pub use follower::Follower;
pub use model::{CANDIDATES, COLUMNS, Model, ModelEstimate, Search};
pub use plan::{PLACES, SPEEDS};
pub(crate) use ramp::{HOLD, RATE};
pub use ramp::{MAX_TICKS, Ramp, RampFindings, RampState};
pub use sequence::Identification;
pub(crate) use settings::{EFFORT, SPEED, TIME, TRAVEL};
pub use settings::{IdentificationPlan, IdentificationRequest, LEAST_TRAVEL_COUNTS};
pub use window::{RegressionRow, Window};
