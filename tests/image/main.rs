//! The flash image in the loop: the very bytes that are flashed, on the emulated part, against the simulated joint.
//!
//! Blind to cycle timing, wait states, the flash's contents, pins and silicon.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bad_input;
mod bench;
mod bit_for_bit;
mod common;
mod cost;
mod crashes;
mod differences;
mod free_running;
mod mishaps;
mod parameters;
mod ramps;
mod stuck;
