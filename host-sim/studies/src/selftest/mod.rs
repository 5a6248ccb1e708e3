//! `stiction device selftest`: compares the moves of a joint with a prediction from its file.
//!
//! ```text
//! file, device, range -> prepare.rs: checks the machine, and plans the prediction
//! file, spread -> prediction.rs: joints around the file's, each behind a simulated device --+
//! device -------------------------------------------------------------------------------+   |
//!                                                                                       v   v
//!        moves.rs: the same moves -> session.rs: over the link, the same samples -> measures.rs
//!                                                                                       |
//!              text.rs: words, JSON <- verdict.rs: compares measured with predicted figures
//! ```
//!
//! The prediction uses the same session as the device: client, moves, samples and verdict. So the
//! effects of link and sample rate on a measure are in both. The simulated devices run the
//! parameters of the device; only the joint is that of the file. Guarantees: the same prediction
//! for the same file, parameters and seed; nothing moves before the prediction is complete. Limits:
//! a difference that no measure shows passes, and effects that are not simulated (heat, wear,
//! resonance) are not tested.

mod measures;
mod moves;
mod prediction;
mod prepare;
mod session;
mod text;
mod verdict;

pub use self::measures::SIGNALS;
pub use self::measures::{AtLoad, MoveMeasures, SessionFigures};
pub use self::moves::{MoveRange, targets};
pub use self::prediction::{Prediction, PredictionInput};
pub use self::prepare::{JOINTS, MOVES, PlannedSelfTest, PreparedSelfTest, SEED, SelfTestRequest};
pub use self::session::{NextMove, SelfTestSession, Steps, run, run_while};
pub use self::text::{
    SelfTestResult, ends, late, late_at_load, object, rest_at_load, sentence, words,
};
pub use self::verdict::{SelfTestCheck, bounds, verdict};
