//! Tests of the whole device without a chip: link, parameters and faults, around the simulated
//! joint. They are blind to the microcontroller, its flash, its timing and its wires, and to real
//! friction.
#![allow(clippy::unwrap_used)]

/// Prints a figure for `tests/evidence/reliability.md`, a name and what was found, as `cargo xtask
/// reliability` reads it.
macro_rules! reliability {
    ($name:literal, $($key:ident $(= $value:expr)?),+ $(,)?) => {
        println!(
            concat!("reliability: ", $name, $(" | ", stringify!($key), "={}"),+),
            $(reliability!(@ $key $(= $value)?)),+
        )
    };
    (@ $key:ident = $value:expr) => { $value };
    (@ $key:ident) => { $key };
}

mod absolute_encoder;
mod arming_test;
mod autostart;
mod both_encoders;
mod brake_resistor;
mod bumper;
mod chaos;
mod controlled_stop;
mod current_loop;
mod current_sensor;
mod dead_encoder;
mod dead_time;
mod dying_encoder;
mod emergency_stop;
mod encoder_faults;
mod encoder_in_doubt;
mod encoder_index;
mod false_counts;
mod fast_loops;
mod first_motion;
#[path = "../first_run.rs"]
mod first_run;
mod fixture;
mod following_error;
mod fuzz;
mod heat;
mod held_effort;
mod holding_brake;
mod home_switch;
mod home_two_encoders;
mod homing;
mod hostile;
mod jog;
mod link;
mod machine_file;
mod matrix;
mod misbehaving_client;
mod motor_temperature;
mod no_supply;
mod noisy_encoder;
mod noisy_identification;
mod open_line;
mod oscillation;
mod play;
mod power_cuts;
mod profiled;
mod referenced;
mod seeds;
mod short_brake;
mod soak;
mod supply;
mod thesis;
mod wake_up;
mod winding_heat;
mod wrong_friction;
