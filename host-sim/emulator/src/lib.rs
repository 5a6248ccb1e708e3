//! The flash image on an emulated microcontroller, with its pins wired to the simulated joint.
//!
//! The image is byte for byte the one that is flashed to the board. The parameter sector is beside
//! it, as a probe would write it.
//!
//! There is one [harness] for all uses. A [board under test](board_under_test) is halted between
//! two instructions until a command advances the time. Microcontroller and plant are coupled in
//! [lockstep] or [free-running](free_running); the pins are connected to a
//! [plant interface](plant_interface).
//!
//! | who has the board | for what |
//! |---|---|
//! | `runs.rs`, by `side_by_side.rs` | the motion of an experiment, [bit for bit](compare) |
//! | [`wire`] | a client on the command link |
//! | [`fault_injection`] | what hardware and program do in distress |
//! | [`counted`] | the instructions of every tick |
//!
//! [`firmware`] reads the image as machine code: its size, stack, calls and cycles.
//!
//! Not simulated: cycles, wait states and exception latency (an instruction takes one
//! cycle), the contents of the flash after a write, analog effects of any kind, and the pins'
//! electrical side.

pub mod as5047p;
pub mod board;
pub mod board_under_test;
pub mod bridge;
pub mod compare;
pub mod counted;
pub mod coupling;
pub mod encoder_edges;
pub mod fault_injection;
pub mod firmware;
pub mod free_running;
mod guard;
pub mod harness;
pub mod image;
pub mod last_tick;
pub mod lockstep;
pub mod log;
pub mod parameters;
pub mod plant_interface;
pub mod probe;
pub(crate) mod runs;
pub mod setup;
mod side_by_side;
pub mod spans;
pub mod tracer;
pub mod uart;
pub mod wire;
pub mod yardstick;

pub use compare::{Difference, first_difference};
pub use image::FirmwareImage;
pub use runs::{Emulation, Latency};
