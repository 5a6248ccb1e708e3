//! The monitors, the faults that they trip, and the bounds of a motion without a closed loop.
//!
//! [`monitor`] checks each tick; each of its files detects one cause of a fault. [`fault`] declares
//! the faults and their log. [`open_loop`] bounds the effort, travel and speed of a jog and of an
//! identification. [`open_line`] finds an open wire of the encoder at rest. [`encoder_proof`]
//! defines the proof that an encoder in doubt needs before the servo is armed again. [`deadline`]
//! judges how late a tick began and how long it took.

pub mod current_offset;
pub mod deadline;
pub mod encoder_index;
pub mod encoder_proof;
pub mod fault;
pub mod monitor;
pub mod motor_current;
pub mod motor_temperature;
pub mod open_line;
pub mod open_loop;
