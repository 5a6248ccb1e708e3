//! Studies of simulated joints.
//!
//! An [`ensemble`] ranks laws on drawn joints, [`tuning`] searches gains on joints around that of a
//! file, a [`selftest`] compares a drive with its prediction, [`log_identification`] identifies a
//! joint from a log, a [`device_gear`] is measured by moves of a device, a [`winding`] is measured by pulses, and a [`benchmark`] ranks laws on the
//! joint of a file.
// A web page uses nothing that is for a terminal.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

pub mod benchmark;
pub mod device_gear;
pub mod ensemble;
pub mod log_identification;
pub mod selftest;
pub mod tuning;
pub mod winding;
