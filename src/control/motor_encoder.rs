//! The encoder of the motor, on a joint with a second encoder on its load.
//!
//! With two encoders, the one on the load measures the position of the joint: it is the
//! [`Encoder`](crate::control::encoder::Encoder) of the configuration, and all positions are in its
//! counts. The one on the motor measures the velocity and what the effort moves: the monitors of
//! wiring, stall and speed use it.
//!
//! The motor's encoder can be configured with the feature `two-encoders`, which the simulator turns
//! on, by `[load_encoder]` of a machine's file. No image reads a second encoder yet.

use crate::units::error::Allowed;
use crate::units::value::{About, Absent, InvalidBits, Key, Table, Values};

/// The encoder of the motor; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorEncoder {
    /// Angle of a count, deg of the joint; zero: the joint has one encoder.
    #[cfg(feature = "two-encoders")]
    pub count: f32,
    /// Largest twist at which a healthy gear rests, deg of the joint; zero: the twist is not
    /// monitored.
    #[cfg(feature = "two-encoders")]
    pub twist: f32,
    /// Largest twist of a healthy gear while its sides move opposite ways, deg of the joint.
    #[cfg(feature = "two-encoders")]
    pub swing: f32,
}

impl MotorEncoder {
    /// A joint with one encoder.
    pub const NONE: Self = Self {
        #[cfg(feature = "two-encoders")]
        count: 0.0,
        #[cfg(feature = "two-encoders")]
        twist: 0.0,
        #[cfg(feature = "two-encoders")]
        swing: 0.0,
    };

    /// Returns the angle of a count of the motor's encoder (deg of the joint) if the joint has two
    /// encoders.
    #[inline]
    pub const fn count(&self) -> Option<f32> {
        #[cfg(feature = "two-encoders")]
        if self.count > 0.0 {
            return Some(self.count);
        }
        None
    }
}

/// No parameter of a device configures the motor's encoder.
impl Values for MotorEncoder {
    fn nth(&self, _: &mut usize) -> Option<(Key, Absent)> {
        None
    }

    fn get(&self, _: Key) -> Option<u32> {
        None
    }

    fn with_bounds(&self, _: Key) -> Option<(f32, Allowed)> {
        None
    }

    fn set(&mut self, _: Key, _: u32) -> Result<bool, InvalidBits> {
        Ok(false)
    }
}

impl Table for MotorEncoder {
    const EXAMPLE: Self = Self::NONE;
    const ABOUT: &'static [About] = &[];
}
