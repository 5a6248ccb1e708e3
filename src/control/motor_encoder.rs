//! The encoder of a motor whose joint has another one on its load.
//!
//! With two encoders, the one on the load says where the joint is: it is the
//! [`Encoder`](crate::control::encoder::Encoder) of the configuration, and all positions are in its
//! counts. The one on the motor gives the velocity, and shows what the effort moves: the monitors
//! of wiring, stall and speed look at it.
//!
//! It is there with the feature `two-encoders`, which the simulator turns on: `[load_encoder]` of a
//! machine's file configures it. No image reads a second encoder yet.

use crate::units::error::Allowed;
use crate::units::value::{About, Absent, InvalidBits, Key, Table, Values};

/// The encoder of the motor; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorEncoder {
    /// Angle of a count, deg of the joint; zero: there is none.
    #[cfg(feature = "two-encoders")]
    pub count: f32,
    /// Largest twist at which a healthy gear rests, deg of the joint; zero: it is not watched.
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

    /// Returns the angle of a count (deg of the joint) if the joint has one on either side.
    #[inline]
    pub const fn count(&self) -> Option<f32> {
        #[cfg(feature = "two-encoders")]
        if self.count > 0.0 {
            return Some(self.count);
        }
        None
    }
}

/// No parameter of a device configures it.
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
