//! Configured values with their units, and positions in encoder counts.
//!
//! [`value`] declares a configured value: its number ([`key`]), name, unit and bounds. [`error`]
//! reports a value that is out of bounds. [`position`] counts in whole encoder counts and a
//! fraction.

pub mod error;
pub mod key;
pub mod position;
pub(crate) mod saturation;
pub mod value;
