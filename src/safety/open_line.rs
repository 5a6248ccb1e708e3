//! An open line of the encoder, found at rest by the resistors of its input.
//!
//! ```text
//!   at rest   ____|~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~
//!   pull      ~~~~~~~~~~\__/~~\_____/~~\__/~~~~\__     32 readings, 1 ms each, or fewer
//!   open      ~~~~~~~~~~\__/~~\_____/~~\__/~~~~\__     follows each of them
//!   driven    ____________________________________     agrees by chance: until one reading differs
//! ```
//!
//! The input has a pull-up and a pull-down resistor inside the chip, some 40 kOhm each. An open
//! line follows the resistor that is on. A line that a push-pull output drives does not. The test
//! begins 10 ms after the joint last moved, and again after each second of rest, with the output on
//! or off. It ends at the first reading at which no line has followed all pulls so far: after two
//! for an encoder that stands still. The order of the pulls is a maximum-length sequence, so that a
//! line that flickers at its edge under vibration does not follow it.
//!
//! Guarantees: a line that is open and quiet is found within 42 ms of rest, or 33 ticks if those
//! are longer, and before arming ([`EncoderOutput::PushPull`] only). A driven line that reads at
//! random passes for an open one in one of 2^32 tests.
//!
//! Does badly: a line receiver or an external pull-up close to the chip hides an open cable behind
//! it. An open-collector output without a pull-up other than the chip's looks open. So the test is
//! off with both, and with an undeclared output. An open line with so much noise that it does not
//! follow the resistors is not found, nor are two lines that touch. An encoder without its supply
//! may hold its lines low. Two open lines that follow the resistors one after the other make counts
//! in a test: 36, two for each change of the pull.

use crate::control::encoder::EncoderOutput;

/// Time at rest after which the test begins, s. A test of 32 readings is over before the servo
/// accepts the joint as at rest (50 ms).
const START: f32 = 0.01;

/// Time from a pull to its reading, s: 40 kOhm and 10 nF of cable and filter are 0.4 ms.
const SETTLED: f32 = 0.001;

/// Time from one test to the next, s.
const AGAIN: f32 = 1.0;

/// Pull resistor at each reading, from the lowest bit on: 1 pulls the lines up, 0 down. It is the
/// pseudo-random sequence of x^5 + x^2 + 1 with a zero appended. The first two bits differ, so that
/// a driven line at rest passes after two readings.
const PULLS: u32 = 0x0AEC_7CD2;
const READINGS: u8 = 32;

/// Both lines: A is bit 0, B is bit 1.
const BOTH: u8 = 0b11;

/// The test for open lines, prepared for the encoder of a loop.
#[derive(Clone, Copy, Debug)]
pub struct OpenLineTest {
    is_on: bool,
    /// Ticks at rest before a test begins.
    start: u32,
    /// Ticks from a pull to its reading.
    settled: u32,
    /// Ticks from one test to the next.
    again: u32,
}

/// Progress of the test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenLineState {
    /// Ticks until the next reading of the test, or until the next test.
    left: u32,
    /// Number of the present reading, from one; zero: no test runs.
    reading: u8,
    /// Lines that have followed every pull of this test.
    suspects: u8,
    /// Whether a test has ended without an open line since the joint last moved.
    passed: bool,
}

impl OpenLineTest {
    /// Makes the test for an encoder's output and a sample time, s.
    pub fn new(output: EncoderOutput, sample_time: f32) -> Self {
        let ticks = |s: f32| (libm::ceilf(s / sample_time) as u32).max(1);
        Self {
            is_on: matches!(output, EncoderOutput::PushPull),
            start: ticks(START),
            settled: ticks(SETTLED),
            again: ticks(AGAIN),
        }
    }

    /// Runs a tick of the test, with the levels of the lines (bit 0: A, bit 1: B) at the start of
    /// the tick and the number of ticks for which the joint has stood still. Returns the open lines
    /// that a test has found; zero if none.
    #[inline]
    pub fn update(&self, state: &mut OpenLineState, lines: u8, standstill: u32) -> u8 {
        if standstill == 0 && state.reading == 0 {
            (state.left, state.passed) = (self.start, false);
        }
        if state.left > 0 {
            state.left -= 1;
            return 0;
        }
        self.look(state, lines, standstill)
    }

    /// Returns whether no test has passed yet since the joint last moved.
    pub const fn is_due(&self, state: &OpenLineState) -> bool {
        self.is_on && !state.passed
    }

    /// Takes one reading of a running test, or begins a test.
    // Out of line: most ticks do not come here.
    #[cold]
    #[inline(never)]
    fn look(&self, state: &mut OpenLineState, lines: u8, standstill: u32) -> u8 {
        if !self.is_on {
            state.left = u32::MAX;
            return 0;
        }
        if state.reading == 0 {
            if standstill >= self.start {
                (state.reading, state.suspects, state.left) = (1, BOTH, self.settled - 1);
            }
            return 0;
        }
        let pulled = if state.pulls_down() { 0 } else { BOTH };
        state.suspects &= !(lines ^ pulled);
        if state.suspects == 0 || state.reading == READINGS {
            let open = state.suspects;
            *state =
                OpenLineState { left: self.again, passed: open == 0, ..OpenLineState::default() };
            return open;
        }
        state.reading += 1;
        state.left = self.settled - 1;
        0
    }
}

impl OpenLineState {
    /// Returns whether a test runs. Open lines may count without a motion meanwhile.
    pub const fn is_running(&self) -> bool {
        self.reading > 0
    }

    /// Returns whether the resistors pull down from this tick to the next. They pull up otherwise.
    #[inline]
    pub const fn pulls_down(&self) -> bool {
        self.reading > 0 && (PULLS >> (self.reading - 1)) & 1 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the test at rest with ticks of 1 ms. `lines` returns the levels of the lines, given the
    /// tick and whether the resistors pull down. Returns the tick of the first find and the open
    /// lines.
    fn found(ticks: u32, mut lines: impl FnMut(u32, bool) -> u8) -> Option<(u32, u8)> {
        let test = OpenLineTest::new(EncoderOutput::PushPull, 1e-3);
        let mut state = OpenLineState::default();
        (0..ticks).find_map(|tick| {
            let lines = lines(tick, state.pulls_down());
            let open = test.update(&mut state, lines, tick + 1);
            (open > 0).then_some((tick + 1, open))
        })
    }

    #[test]
    fn a_line_that_follows_every_pull_is_found_within_42_ms() {
        for driven in [0b00, 0b01, 0b10, 0b11] {
            for open in [0b01, 0b10, 0b11] {
                let lines = |_, down: bool| (if down { 0 } else { open }) | (driven & !open);
                assert_eq!(found(100, lines), Some((42, open)), "{driven:02b} {open:02b}");
            }
            assert_eq!(found(100_000, |_, _| driven), None, "{driven:02b}");
        }
    }

    #[test]
    fn lines_that_flicker_in_step_with_any_vibration_are_driven() {
        // Square waves of every period up to 64 ms and of every phase, on both lines.
        for period in 2..=64 {
            for phase in 0..period {
                let wave = |tick: u32| u8::from((tick + phase) % period < period / 2);
                assert_eq!(found(3000, |tick, _| 0b11 * wave(tick)), None, "{period} {phase}");
            }
        }
    }

    #[test]
    fn a_still_encoder_is_pulled_down_for_a_single_reading() {
        let test = OpenLineTest::new(EncoderOutput::PushPull, 1e-3);
        for driven in [0b00, 0b01, 0b10, 0b11] {
            let mut state = OpenLineState::default();
            let mut down = 0;
            for tick in 1..=900 {
                test.update(&mut state, driven, tick);
                down += u32::from(state.pulls_down());
            }
            assert_eq!((down, test.is_due(&state)), (1, false), "{driven:02b}");
        }
    }

    #[test]
    fn no_test_begins_while_the_joint_moves_and_an_output_that_forbids_it_passes_at_once() {
        let test = OpenLineTest::new(EncoderOutput::PushPull, 1e-3);
        let mut state = OpenLineState::default();
        for tick in 0..1000 {
            test.update(&mut state, 0, tick % 10);
            assert!(test.is_due(&state) && !state.pulls_down());
        }
        for output in
            [EncoderOutput::Unknown, EncoderOutput::OpenCollector, EncoderOutput::Receiver]
        {
            let test = OpenLineTest::new(output, 1e-3);
            let mut state = OpenLineState::default();
            for tick in 0..1000 {
                assert_eq!(test.update(&mut state, 0b11, tick), 0);
                assert!(!test.is_due(&state) && !state.pulls_down(), "{output:?}");
            }
        }
    }
}
