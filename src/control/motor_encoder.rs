//! The encoder of the motor, on a joint with a second encoder on its load.
//!
//! With two encoders, the one on the load measures the position of the joint: it is the
//! [encoder](crate::control::encoder::Encoder) of the configuration, and all positions are in its
//! counts. The one on the motor measures the velocity and what the effort moves: the monitors of
//! wiring, stall and speed use it.
//!
//! The motor's encoder can be configured with the feature `two-encoders`, which the simulator and
//! the image for two encoders have. A user configures both encoders in a machine's file:
//! `[encoder]` is the motor's there, and `[load_encoder]` the load's. The values here are those of
//! a device, which a host derives from the file. A joint with one encoder has none of them.

#[cfg(feature = "two-encoders")]
use crate::control::encoder::{CounterBits, Direction, Encoder, EncoderOutput};
#[cfg(not(feature = "two-encoders"))]
use crate::units::error::Allowed;
#[cfg(feature = "two-encoders")]
use crate::units::error::HUGE;
#[cfg(not(feature = "two-encoders"))]
use crate::units::value::{About, Absent, InvalidBits, Key, Table, Values};
#[cfg(feature = "two-encoders")]
use crate::units::value::{Key, Table, choice, key, table};

#[cfg(feature = "two-encoders")]
choice! {
    /// Kind of the encoder on the load.
    pub enum LoadEncoderKind {
        /// It has two lines whose edges a timer counts.
        Incremental = 0 "incremental",
        /// It is a chip on SPI that reports the angle within a turn of the joint: 2^14 counts.
        As5047p = 1 "as5047p",
    }
}

#[cfg(feature = "two-encoders")]
table! {
    /// The encoder of the motor, and the kind of the one on the load; none by default.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MotorEncoder (motor) "motor_encoder" if (motor.count().is_some()) {
        /// Angle of a count of the motor's encoder, deg of the joint; zero: the joint has one
        /// encoder.
        count: f32 = 0x0C01 "resolution_deg", Between(0.0, HUGE), Needed(0.0);
        /// Which way the counter runs when the motor turns the joint the positive way.
        direction: Direction = 0x0C02 "direction", Any, Default(Direction::Forward);
        /// Output stage of the motor's encoder. The test for open lines at rest needs `push-pull`.
        output: EncoderOutput = 0x0C03 "output", Any, Default(EncoderOutput::Unknown);
        /// Largest twist at which a healthy gear rests, deg of the joint. Off: the twist is not
        /// monitored.
        twist: f32 = 0x0C04 "twist_deg", OrOff(0.0, HUGE), Default(0.0);
        /// Largest twist of a healthy gear while its sides move opposite ways, deg of the joint.
        swing: f32 = 0x0C05 "swing_deg", Between(motor.twist, HUGE), Default(0.0);
        /// Kind of the encoder on the load.
        load_kind: LoadEncoderKind = 0x0C06 "load_kind", Any,
            Default(LoadEncoderKind::Incremental);
        /// Reading of an absolute encoder on the load where the joint's position is zero, counts.
        load_zero: u32 = 0x0C07 "load_zero_counts", Between(0.0, 16383.0), Needed(0);
    }
}

/// Key of the configured value `load_kind`.
#[cfg(feature = "two-encoders")]
pub(crate) const LOAD_KIND: Key = key(MotorEncoder::ABOUT, "load_kind");

/// The encoder of the motor: there is none without the feature `two-encoders`.
#[cfg(not(feature = "two-encoders"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorEncoder;

impl MotorEncoder {
    /// A joint with one encoder.
    pub const NONE: Self = <Self as Table>::EXAMPLE;

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

    /// Returns the encoder that turns readings of the motor's counter into travel. The counter has
    /// 32 bits.
    #[cfg(feature = "two-encoders")]
    pub const fn encoder(&self) -> Encoder {
        Encoder {
            resolution: self.count,
            counter_bits: CounterBits::ThirtyTwo,
            direction: self.direction,
            output: self.output,
        }
    }
}

impl Default for MotorEncoder {
    fn default() -> Self {
        Self::NONE
    }
}

/// No parameter of a device with one encoder configures the motor's.
#[cfg(not(feature = "two-encoders"))]
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

#[cfg(not(feature = "two-encoders"))]
impl Table for MotorEncoder {
    const EXAMPLE: Self = Self;
    const ABOUT: &'static [About] = &[];
}
