//! The flash image in the loop: the very bytes that are flashed, on the emulated part, against the
//! simulated joint.
//!
//! Blind to cycle timing, wait states, the flash's contents, pins and silicon.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

#[cfg(feature = "emulator")]
mod bad_input;
#[cfg(feature = "emulator")]
mod bit_for_bit;
#[cfg(feature = "emulator")]
mod both_encoders;
#[cfg(feature = "emulator")]
mod brake_resistor;
#[cfg(feature = "emulator")]
mod bridge_modes;
#[cfg(feature = "emulator")]
mod common;
#[cfg(feature = "emulator")]
mod cost;
#[cfg(feature = "emulator")]
mod crashes;
#[cfg(feature = "emulator")]
mod current_loop;
#[cfg(feature = "emulator")]
mod current_sensor;
#[cfg(feature = "emulator")]
mod device_link;
#[cfg(feature = "emulator")]
mod differences;
#[cfg(feature = "emulator")]
mod driver;
#[cfg(feature = "emulator")]
mod emergency_stop;
#[cfg(feature = "emulator")]
mod fault_injection;
#[cfg(feature = "emulator")]
#[path = "../first_run.rs"]
mod first_run;
#[cfg(feature = "emulator")]
mod free_running;
#[cfg(feature = "emulator")]
mod hardware_faults;
#[cfg(feature = "emulator")]
mod holding_brake;
#[cfg(feature = "emulator")]
mod homing;
#[cfg(feature = "emulator")]
mod identification;
#[cfg(feature = "emulator")]
mod inputs;
#[cfg(feature = "emulator")]
mod jog;
#[cfg(feature = "emulator")]
mod link;
#[cfg(feature = "emulator")]
mod matrix;
#[cfg(feature = "emulator")]
mod motor_temperature;
#[cfg(feature = "emulator")]
mod open_line;
#[cfg(feature = "emulator")]
mod owner_and_stop;
#[cfg(feature = "emulator")]
mod parameters;
#[cfg(feature = "emulator")]
mod ramps;
#[cfg(feature = "emulator")]
mod short_brake;
#[cfg(feature = "emulator")]
mod side_by_side;
#[cfg(feature = "emulator")]
mod stuck;
#[cfg(feature = "emulator")]
mod supply_and_crystal;
#[cfg(feature = "emulator")]
mod timing;
#[cfg(feature = "emulator")]
mod winding;

/// Stands for all of them in a build without the emulator, so that they are not left out in
/// silence.
#[cfg(not(feature = "emulator"))]
#[test]
#[ignore = "the flash image in the loop: cargo xtask test"]
fn the_flash_image_in_the_loop() {
    panic!("built without the emulator: run `cargo xtask test`");
}
