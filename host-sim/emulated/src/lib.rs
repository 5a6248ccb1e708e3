//! The flash image: on an emulated microcontroller ([`emulator`]), and as machine code
//! ([`firmware`]).

pub mod emulator;
pub mod firmware;

pub use dynamics::{joint, solver};
pub use simulator::{Error, closed_loop, device, encoder, error, experiment, hardware, machine};
pub use simulator::{plant, run, target};
