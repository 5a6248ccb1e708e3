//! Readings of a joint's encoders, as a plant shows them and a target takes them.

use stiction::servo::{EncoderReading, Input};

/// Readings of the counters of a joint's encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// Counter of the encoder that measures the position: of two, that of the load.
    pub position: u32,
    /// Counter of the motor's own encoder, if the joint has two.
    pub motor: Option<u32>,
}

impl Counters {
    /// Returns the reading of a joint with one encoder.
    pub const fn one(position: u32) -> Self {
        Self { position, motor: None }
    }

    /// Returns the input of a servo, with a reading of the supply, for driven lines and a closed
    /// contact of an emergency stop.
    pub const fn input(&self, supply: u16) -> Input {
        let Self { position, motor } = *self;
        let (counter, load) = match motor {
            Some(motor) => (motor, position),
            None => (position, 0),
        };
        Input {
            counter,
            supply,
            lines: Input::CONTACT,
            current: 0,
            load: EncoderReading { counter: load, lines: 0, is_missing: false },
        }
    }
}
