//! `stiction device selftest`: does a joint do what its file says?
//!
//! ```text
//! file, device, range -> prepare.rs: the same machine? what is predicted?
//! file, spread -> prediction.rs: joints around the file's, each behind a simulated device --+
//! device -------------------------------------------------------------------------------+   |
//!                                                                                       v   v
//!        moves.rs: the same moves -> session.rs: over the link, the same samples -> measures.rs
//!                                                                                       |
//!              text.rs: words, JSON <- verdict.rs: what was measured within what was predicted
//! ```
//!
//! The prediction goes through the same session as the device: the same client, moves, samples and
//! judgement, so that what a link or a rate of samples does to a measure is in both. The simulated
//! devices run the parameters that the device runs; only the joint is the file's. Guarantees: the
//! same prediction for the same file, parameters and seed; nothing moves before the prediction is
//! there. Does badly: a joint that differs in what none of the measures shows passes, and what was
//! not simulated (heat, wear, resonance) is not tested.

mod measures;
mod moves;
mod prediction;
mod prepare;
mod session;
mod text;
mod verdict;

pub use self::measures::SIGNALS;
pub use self::measures::{AtLoad, Figures, MoveMeasures};
pub use self::moves::{MoveRange, targets};
pub use self::prediction::{Prediction, PredictionRequest};
pub use self::prepare::{JOINTS, MOVES, PlannedSelfTest, PreparedSelfTest, SEED, SelfTestRequest};
pub use self::session::{NextMove, SelfTestSession, Steps, run, run_while};
pub use self::text::{
    SelfTestResult, ends, late, late_at_load, object, rest_at_load, sentence, words,
};
pub use self::verdict::{SelfTestCheck, bounds, verdict};
