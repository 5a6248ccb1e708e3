//! The command line `stiction`, the studio and the report on what the other crates do: [`files`] are
//! read, the [`simulator`] runs them, `emulated` runs the flash image, and [`studies`] find something
//! out. [`dynamics`] has the joints and the solvers.
// What a terminal, a port or a server asks for, nothing asks for in a page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

// WebAssembly (`playground/`) has no terminal and no serial ports. This and the simulator's
// `device::port` are all that is left out there.
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
    plant, properties, run, settling, target,
};
pub use studies::{
    benchmark, ensemble, figure, lab, log_identification, missing_part, selftest, tuning,
};
