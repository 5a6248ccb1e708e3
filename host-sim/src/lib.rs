//! The command line `stiction`, the studio, and the page on a user's joint.
//!
//! The other crates do the work: `files` reads files, the `simulator` runs them, the `emulator`
//! runs the flash image, `studies` evaluates many runs, `figure` draws them, and `thesis` repeats
//! the thesis. `dynamics` has the joints and the solvers.
// Functions for a terminal, a port or a server are not used in a page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

// WebAssembly (`playground/`) has neither a terminal nor serial ports; it leaves out only this and
// the simulator's `device::port`.
#[cfg(not(target_family = "wasm"))]
pub mod cli;
#[cfg(feature = "report")]
pub mod joint_page;
#[cfg(feature = "playground")]
pub mod studio;
