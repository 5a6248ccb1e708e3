//! The plant in the loop, on the host: the core around the simulated axis, and the axis by itself.
//! Blind to the microcontroller, to its timing, and to real friction.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

mod axis;
mod chapter3;
mod closed_loop;
mod common;
mod metrics;
mod snapshot;
