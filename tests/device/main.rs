//! The whole device without a chip: link, parameters, faults, around the simulated joint. Blind to the microcontroller,
//! its flash, its timing and its wires, and to real friction.
#![allow(clippy::unwrap_used)]

mod chaos;
mod fixture;
mod fuzz;
mod link;
mod matrix;
mod power_cuts;
mod soak;
mod thesis;
