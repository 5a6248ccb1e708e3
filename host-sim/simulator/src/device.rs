//! Devices: a simulated device, devices behind a wire, and the client that talks to both.
//! [`crate::experiment`] makes the parameters of a device for a run.

pub mod annotated;
pub mod beyond;
pub mod client;
pub mod clock;
pub mod contradiction;
pub mod found_load;
mod holding_brake;
pub mod homed;
pub mod identified;
pub mod into;
pub mod jog_offset;
pub mod jogged;
pub mod json;
pub mod log;
pub mod machine_file;
pub mod measured_gear;
mod merged;
pub mod merged_sheet;
pub mod moved;
#[cfg(not(target_family = "wasm"))]
pub mod port;
pub mod robust_joint;
pub mod shown_current;
pub mod signals;
pub mod simulated;
pub mod spread;
pub mod travel;
pub mod wire;
pub mod words;

pub use crate::experiment::{for_a_device as parameters, record, sectors};
