//! From a wrapping hardware counter to a position in counts.
//!
//! The difference of two readings, taken modulo the counter's width and read as signed, is the travel between
//! them as long as the joint moves less than half the counter's range in one tick (32 767 counts for 16 bits:
//! 79 deg at 0.00242 deg). Everything is integer: nothing is rounded and nothing drifts.

use crate::error::{Error, HUGE, above};
use serde::{Deserialize, Serialize};

/// Width of the hardware counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CounterBits {
    /// Wraps at 2^16.
    Sixteen,
    /// Wraps at 2^32.
    ThirtyTwo,
}

/// Which way the counter runs when the joint moves the positive way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// It counts up.
    Forward,
    /// It counts down.
    Reverse,
}

/// An incremental encoder at the joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Encoder {
    /// Joint angle of one count, deg.
    pub resolution: f32,
    /// Width of the counter.
    pub counter_bits: CounterBits,
    /// Sense of counting.
    pub direction: Direction,
}

/// What is remembered from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderState {
    /// The last reading of the counter.
    counter: u32,
    /// Position since the start, in counts.
    counts: i32,
}

impl EncoderState {
    /// Starts with the counter at `counter` and calls that position `counts`.
    pub const fn start(counter: u32, counts: i32) -> Self {
        Self { counter, counts }
    }

    /// The last reading of the counter.
    pub const fn counter(&self) -> u32 {
        self.counter
    }

    /// Position in counts. Wraps.
    pub const fn counts(&self) -> i32 {
        self.counts
    }
}

impl Encoder {
    /// Refuses a resolution that is not a positive number.
    ///
    /// # Errors
    /// Names `resolution_deg`.
    pub fn validate(&self) -> Result<(), Error> {
        above("resolution_deg", self.resolution, 0.0, HUGE)
    }

    /// Takes one reading of the counter, and returns the travel since the last one, in counts.
    ///
    /// ```
    /// use stiction::encoder::{CounterBits, Direction, Encoder, EncoderState};
    /// let encoder =
    ///     Encoder { resolution: 0.00242, counter_bits: CounterBits::Sixteen, direction: Direction::Reverse };
    /// let mut state = EncoderState::start(1, 100);
    /// assert_eq!(encoder.update(&mut state, 0xFFFF), 2); // two down, across zero
    /// assert_eq!(state.counts(), 102);
    /// ```
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn update(&self, state: &mut EncoderState, counter: u32) -> i32 {
        let raw = counter.wrapping_sub(state.counter);
        let travel = match self.counter_bits {
            CounterBits::Sixteen => i32::from(raw as u16 as i16),
            CounterBits::ThirtyTwo => raw as i32,
        };
        let travel = match self.direction {
            Direction::Forward => travel,
            Direction::Reverse => travel.wrapping_neg(),
        };
        state.counter = counter;
        state.counts = state.counts.wrapping_add(travel);
        travel
    }
}
