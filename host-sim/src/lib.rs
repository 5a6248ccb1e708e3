//! The command line `stiction`, the studio and the report, on top of the other crates: [`files`]
//! reads files, the [`simulator`] runs them, `emulated` runs the flash image, and [`studies`]
//! evaluates them. [`dynamics`] has the joints and the solvers.
// Functions for a terminal, a port or a server are not used in a page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

// WebAssembly (`playground/`) has neither a terminal nor serial ports; it leaves out only this and
// the simulator's `device::port`.
#[cfg(not(target_family = "wasm"))]
pub mod cli;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "playground")]
pub mod studio;

pub use dynamics::{friction, joint, mechanism, solver};
#[cfg(feature = "emulator")]
pub use emulated::{emulator, firmware};
pub use files::{
    Error, data_sheet, document, encoder, error, goal, hardware, keys, lines, machine, setup,
    typed_number, written,
};
pub use simulator::{
    both_sides, closed_loop, device, draft, experiment, flash, identification, metrics, output,
    plant, properties, rules, run, settling, target,
};
pub use studies::{
    benchmark, ensemble, figure, lab, log_identification, missing_part, selftest, tuning,
};
