//! Absolute encoder on the load: from the frames of a chip to the position of the joint.
//!
//! ```text
//! bus -> as5047p::angle -> angle within a turn -> AbsoluteEncoder -> position of the joint, counts
//! ```
//!
//! An incremental encoder counts from the place of the last reset. An absolute one reports where
//! the joint is: [`AbsoluteEncoder::locate`] returns the position at power-on if the joint's range
//! is less than a turn of the encoder, and why not otherwise.
//!
//! The image for two encoders reads such a chip, and so may a firmware of your own. Nothing here
//! has run with a real chip.

pub mod absolute;
pub mod as5047p;

pub use absolute::{AbsoluteEncoder, AbsoluteState, Unlocated};
