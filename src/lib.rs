//! The control core of **stiction**: it positions a geared joint in spite of stick-slip friction.
//!
//! One tick reads like the block diagram (Fig. 21 of the thesis):
//!
//! ```text
//! counter -> encoder -> velocity -+
//!                                 v
//! reference -----------------> error -> PD (eq. 28) -+-> output stage
//!                                 |                  |
//!                                 +-> compensator ---+      (eqs. 29-36, or a sum of them)
//!
//! output stage: saturation -> supply scaling -> saturation -> drive code
//!                                            -> soft start and cap -> PWM compare
//! ```
//!
//! [`Controller::tick`] is that diagram, and [`Tick`] holds every term of it. The same source is
//! compiled for the microcontroller and for the host. It is written to give the same bits on both:
//! `f32` arithmetic with one rounding per written operation, integers for positions and for time,
//! and transcendental functions from [`libm`] on every platform. That the bits are the same was
//! shown for every term of every tick on an emulated microcontroller, not yet on a real one.
//!
//! [`Servo`] says when the output may be on, and owns the controller. [`Parameters`] are the
//! configuration of a device, with a record in its flash.
//!
//! The core has no heap, no panic, no `f64`, no `unsafe`, and no loop without a bound that is known
//! at compile time. Configuration ([`ControllerConfig`]) is validated once, by [`Controller::new`].
//! A tick validates nothing: a term that is not finite gives zero output and [`Tick::non_finite`].
//!
//! Units are degrees, degrees per second, seconds and volts of controller output. "The thesis" is
//! *Modelling and Compensation of Stick-Slip Friction for Robot Arm Control* (M.Sc., University of
//! Manitoba); gains carry its symbols.
#![no_std]
#![forbid(unsafe_code)]
// Some of what `device` uses is private to the crate, and unused without it.
#![cfg_attr(not(feature = "device"), allow(dead_code, unused_imports))]

#[cfg(all(feature = "rivals", target_os = "none"))]
compile_error!("the laws of `rivals` live on the host: build the image without that feature");

pub mod control;
#[cfg(feature = "device")]
pub mod device;
#[cfg(feature = "device")]
pub mod identification;
#[cfg(feature = "device")]
pub mod link;
pub mod load_encoder;
#[cfg(feature = "device")]
pub mod motion;
#[cfg(feature = "device")]
pub mod parameters;
pub mod positioner;
pub mod safety;
#[cfg(feature = "device")]
pub mod servo;
pub mod units;

pub use control::controller::{Controller, ControllerConfig, ControllerState, Reading};
pub use control::hardware::Hardware;
pub use control::profile::ProfileLimits;
pub use control::signal::Tick;
#[cfg(feature = "device")]
pub use device::Device;
#[cfg(feature = "device")]
pub use motion::{Course, CourseState, Motion};
#[cfg(feature = "device")]
pub use parameters::Parameters;
pub use safety::fault::Fault;
pub use safety::monitor::Limits;
#[cfg(feature = "device")]
pub use servo::Servo;
pub use units::error::{Allowed, InvalidValue};

/// The version of the core, which an image carries in its note.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
