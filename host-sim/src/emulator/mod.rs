//! The flash image on an emulated microcontroller, with its pins wired to the simulated joint.
//!
//! The image is the one that is flashed to the board, to the byte, and the parameter sector lies beside it as a probe
//! would write it. See [`in_the_loop`] for how time passes, [`Lockstep`](lockstep::Lockstep) and
//! [`FreeRunning`](free_running::FreeRunning) for the two ways to couple joint and part, and [`compare`] for what "bit
//! for bit" means here.
//!
//! What this is blind to: cycles, wait states and exception latency (an instruction takes one cycle), the contents of
//! the flash after a write, analog effects of any kind, and the pins' electrical side.

pub mod bench;
pub mod board;
pub mod bridge;
pub mod compare;
pub mod encoder_edges;
pub mod free_running;
mod guard;
pub mod image;
pub mod in_the_loop;
pub mod joint;
pub mod last_tick;
pub mod lockstep;
pub mod log;
pub mod metered;
pub mod parameters;
pub mod powered;
pub mod probe;
pub mod rig;
pub(crate) mod runs;
pub mod spans;
pub mod tracer;
pub mod uart;
pub mod wire;
pub mod yardstick;

pub use compare::{Difference, first_difference};
pub use image::FirmwareImage;
pub use runs::{Emulation, Latency};
