//! The positioner for C: `stiction.h` and `libstiction.a`.
//!
//! ```text
//! StictionConfig -> stiction_init -> Stiction (owned by the caller)
//! counts, target -> stiction_tick, stiction_follow -> effort -> your amplifier
//! counts, target, effort -> stiction_monitors_check -> 0: apply it;  else: turn the output off
//! ```
//!
//! This crate adds pointers, sizes and numbers to [`stiction::positioner`], and no arithmetic. It
//! allocates nothing and has no state of its own. A null or misaligned pointer, or a struct that
//! was not initialised, gives a code, an effort of 0, or a fault, and reads nothing further.
//!
//! What it cannot detect: a pointer to other memory, and two calls at once with one struct. The
//! second one includes a call from an interrupt during a call outside of it.
#![cfg_attr(target_os = "none", no_std)]
// The caller's memory comes as pointers, and a linker of C knows no mangled names.
#![allow(unsafe_code)]

mod codes;
mod config;
mod joint;
mod monitors;
mod owned;

pub use codes::*;
pub use config::{StictionConfig, StictionMonitorConfig, StictionRefusal, StictionTarget};
pub use joint::*;
pub use monitors::*;

/// A program in C has no handler of Rust's panics. The library has none to handle: the test of the
/// archive links a program that calls all of it, and finds no panic in there.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

#[cfg(test)]
mod header_tests;
#[cfg(test)]
mod tests;
