//! The simulated joint around the control core of [`stiction`].
//!
//! A file is opened as a [`document`]. That of a machine ([`machine`]) is taken apart into runs
//! ([`experiment`]); each run wires the core to an encoder, a D/A and an axis ([`closed_loop`]),
//! whose motion between samples a solver finds ([`solver`]); what comes out is judged ([`metrics`])
//! and written ([`output`], [`figure`]).
//!
//! Apart from the control core there is the friction lab ([`lab`]): mechanisms, frictions and
//! solvers that know nothing of each other.
// What a terminal, a port or a server asks for, nothing asks for in a page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

pub mod benchmark;
// WebAssembly (`playground/`) has no terminal and no serial ports. This and `device::port` are all
// that is left out there.
#[cfg(not(target_family = "wasm"))]
pub mod cli;
pub mod closed_loop;
pub mod data_sheet;
pub mod device;
pub mod document;
pub mod draft;
#[cfg(feature = "emulator")]
pub mod emulator;
pub mod encoder;
pub mod ensemble;
mod error;
pub mod experiment;
pub mod figure;
#[cfg(feature = "emulator")]
pub mod firmware;
pub mod flash;
pub mod friction;
pub mod hardware;
pub mod identification;
pub mod joint;
pub mod keys;
pub mod lab;
pub mod log_identification;
pub mod machine;
pub mod mechanism;
pub mod metrics;
pub mod output;
pub mod plant;
pub mod properties;
#[cfg(feature = "report")]
pub mod report;
pub mod run;
pub mod selftest;
pub mod setup;
pub mod solver;
#[cfg(feature = "playground")]
pub mod studio;
pub mod target;
pub mod tuning;
pub mod written;

pub use error::Error;
