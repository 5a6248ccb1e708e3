//! The monitors, the faults that they trip, and the bounds of a motion without a closed loop.
//!
//! [`monitor`] judges each tick, one cause of a fault a file. [`fault`] declares the faults and
//! latches the first. [`open_loop`] bounds the effort, travel and speed of a jog and of an
//! identification. [`open_line`] finds an open wire of the encoder at rest. [`encoder_proof`] says
//! what an encoder in doubt has to show before the servo is armed again. [`deadline`] judges how
//! late a tick began and how long it took.

pub mod deadline;
pub mod encoder_proof;
pub mod fault;
pub mod monitor;
pub mod open_line;
pub mod open_loop;
