//! Unwrapping of a hardware counter, for a firmware of your own.

use crate::control::encoder::{Encoder, EncoderState};
use crate::units::value::Table;

pub use crate::control::encoder::{CounterBits, Direction};

/// Position from a hardware counter that wraps.
///
/// The joint must move less than half the counter's range between two calls. Integers only: nothing
/// drifts. The position wraps at 2^31 counts, which a positioner tolerates.
///
/// ```
/// use stiction::positioner::{Counter, CounterBits, Direction};
///
/// // A timer of 16 bits that stands at 1, and counts down when the joint moves forward.
/// let mut counter = Counter::new(CounterBits::Sixteen, Direction::Reverse, 1);
/// assert_eq!(counter.update(0xFFFF), 2);
/// // A homing switch at count -500.
/// counter.set_position(-500);
/// assert_eq!(counter.update(0xFFFE), -499);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counter {
    encoder: Encoder,
    state: EncoderState,
}

impl Counter {
    /// Returns a counter whose present reading is position 0.
    pub const fn new(bits: CounterBits, direction: Direction, reading: u32) -> Self {
        let encoder = Encoder { counter_bits: bits, direction, ..Encoder::EXAMPLE };
        Self { encoder, state: EncoderState::start(reading, 0) }
    }

    /// Updates the position with a reading of the counter, and returns it, counts.
    pub fn update(&mut self, reading: u32) -> i32 {
        self.encoder.update(&mut self.state, reading);
        self.position()
    }

    /// Returns the position at the last reading, counts.
    pub const fn position(&self) -> i32 {
        self.state.counts()
    }

    /// Sets the position of the last reading, counts. Call `restart` of the positioner as well.
    pub const fn set_position(&mut self, counts: i32) {
        self.state = EncoderState::start(self.state.counter(), counts);
    }
}
