//! What is found out with simulated joints.
//!
//! Laws are ranked on the [`ensemble`] of drawn joints, gains are looked for on joints around one
//! ([`tuning`]), a drive is held against its prediction ([`selftest`]), and a joint is read from a
//! log ([`log_identification`]). The friction [`lab`] knows nothing of the control core:
//! mechanisms, frictions and solvers. A [`figure`] shows what came out.
// What a terminal asks for, nothing asks for in a page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

pub mod benchmark;
pub mod ensemble;
pub mod figure;
pub mod lab;
pub mod log_identification;
pub mod missing_part;
pub mod selftest;
pub mod tuning;

pub use dynamics::{friction, joint, mechanism, solver};
pub use simulator::{
    Error, both_sides, closed_loop, data_sheet, device, document, draft, encoder, error,
    experiment, goal, hardware, lines, machine, metrics, output, plant, rules, run, settling,
    setup, target, typed_number, written,
};
