//! `stiction device --port` on the built program, at one end of a pseudoterminal. At the other end
//! is a thread with the core of the firmware around the simulated joint, or something that should
//! not be there. These tests are blind to real ports: their baud rate, their drivers, their cables.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod board;
mod program;
mod questions;
mod refusals;
mod session;
mod watch;
