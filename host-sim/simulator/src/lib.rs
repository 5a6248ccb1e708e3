//! The control core of [`stiction`] in a loop with a simulated joint.
//!
//! A machine's file (`files`) is split into runs ([`experiment`]). Each run connects the core to an
//! encoder, a D/A and an axis ([`closed_loop`]); a solver of `dynamics` moves the axis between
//! samples. The results are judged ([`metrics`]) and written ([`output`]). A
//! [`device`] is the same core as on a board, behind its link.
// Code for a terminal or a port is unused in a web page.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_mut))]

pub mod both_sides;
pub mod closed_loop;
pub mod counters;
pub mod current_periods;
pub mod dc_link;
pub mod device;
pub mod draft;
pub mod experiment;
pub mod flash;
pub mod guest;
pub mod home_sensors;
pub mod identification;
pub mod metrics;
pub mod motor_ntc;
pub mod output;
pub mod plant;
pub mod progress;
pub mod properties;
pub mod rules;
pub mod run;
pub mod settling;
pub mod shunt;
pub mod supply;
pub mod target;
pub mod winding_heat;
