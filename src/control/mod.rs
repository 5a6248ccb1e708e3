//! The control loop: one tick, from the encoder's travel to the drive's duty.
//!
//! ```text
//! encoder -> velocity --------+
//!                             v
//! reference, profile -----> error -> pd (eq. 28) -+-> output -> drive
//!                             |                   |
//!                             +-----> laws -------+    (eqs. 29-36, or a sum of them)
//! ```
//!
//! [`controller`] runs these parts in this order, and [`signal`] holds every term of a tick.
//! [`hardware`] has the properties of a board with which a user's units are converted into codes.

pub mod brake_resistor;
pub mod controller;
pub mod current_limit;
pub mod current_loop;
pub mod current_sensor;
pub mod device_config;
pub mod drive;
pub mod encoder;
pub mod hardware;
pub mod laws;
pub mod motor_encoder;
pub mod motor_ntc;
mod output;
pub mod pd;
pub mod period_work;
pub mod profile;
pub mod reference;
pub mod signal;
pub mod velocity;
pub mod winding_pulses;
