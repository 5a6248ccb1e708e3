//! The encoder: from a wrapping hardware counter to a position in counts.
//!
//! The difference of two readings, taken modulo the counter's width and read as signed, is the
//! travel between them as long as the joint moves less than half the counter's range in one tick
//! (32 767 counts for 16 bits: 79 deg at 0.00242 deg). Everything is integer: nothing is rounded
//! and nothing drifts.

use crate::units::error::HUGE;
use crate::units::value::{Key, Table, choice, key, table};

choice! {
    /// Width of the hardware counter.
    pub enum CounterBits {
        /// Wraps at 2^16.
        Sixteen = 0 "16",
        /// Wraps at 2^32.
        ThirtyTwo = 1 "32",
    }
}

choice! {
    /// Which way the counter runs when the joint moves the positive way.
    pub enum Direction {
        /// It counts up.
        Forward = 0 "forward",
        /// It counts down.
        Reverse = 1 "reverse",
    }
}

choice! {
    /// What drives the encoder's lines at the input of the chip. It decides whether the
    /// [test for open lines](crate::safety::open_line) works.
    pub enum EncoderOutput {
        /// Nothing is said: the test is off.
        Unknown = 0 "unknown",
        /// The lines are driven up and down, without resistors that hold them: the test is on.
        PushPull = 1 "push-pull",
        /// The lines are driven down, and a resistor pulls them up: the test is off.
        OpenCollector = 2 "open-collector",
        /// A line receiver stands between cable and chip, and hides an open cable: the test is off.
        Receiver = 3 "receiver",
    }
}

table! {
    /// An incremental encoder at the joint.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Encoder (encoder) "encoder" {
        /// Joint angle of one count, deg.
        resolution: f32 = 0x0201 "resolution_deg", Above(0.0, HUGE), Needed(0.00242);
        /// Width of the hardware counter, bits.
        counter_bits: CounterBits = 0x0202 "counter_bits", Any, Needed(CounterBits::Sixteen);
        /// Which way the counter runs when the joint moves the positive way.
        direction: Direction = 0x0203 "direction", Any, Default(Direction::Forward);
        /// What drives the lines: only with `push-pull` are open ones found at rest.
        output: EncoderOutput = 0x0204 "output", Any, Default(EncoderOutput::Unknown);
    }
}

/// Key of the configured value `resolution_deg`.
pub(crate) const RESOLUTION: Key = key(Encoder::ABOUT, "resolution");

/// The state of the encoder from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderState {
    /// The last reading of the counter.
    counter: u32,
    /// Position since the start, counts.
    counts: i32,
}

impl EncoderState {
    /// Returns the state in which a reading of `counter` corresponds to the position `counts`.
    pub const fn start(counter: u32, counts: i32) -> Self {
        Self { counter, counts }
    }

    /// Returns the last reading of the counter.
    pub const fn counter(&self) -> u32 {
        self.counter
    }

    /// Returns the position in counts. It wraps.
    pub const fn counts(&self) -> i32 {
        self.counts
    }
}

impl Encoder {
    /// Updates the position with a reading of the counter, and returns the travel since the last
    /// reading, counts.
    ///
    /// ```
    /// use stiction::control::encoder::{
    ///     CounterBits, Direction, Encoder, EncoderOutput, EncoderState,
    /// };
    /// let encoder = Encoder {
    ///     resolution: 0.00242,
    ///     counter_bits: CounterBits::Sixteen,
    ///     direction: Direction::Reverse,
    ///     output: EncoderOutput::PushPull,
    /// };
    /// let mut state = EncoderState::start(1, 100);
    /// assert_eq!(encoder.update(&mut state, 0xFFFF), 2); // two down, across zero
    /// assert_eq!(state.counts(), 102);
    /// ```
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
