//! Position of a joint from an encoder that reports an angle within a turn.
//!
//! ```text
//! a = +-(reading - zero) mod 2^bits         angle, counts; - if the encoder runs backwards
//! position = the one of min..max that is a mod 2^bits                    at power-on
//! position += the difference of two readings, -2^(bits-1) .. 2^(bits-1) - 1       then
//! ```
//!
//! Integers only: nothing is rounded, and nothing drifts. The joint must move less than half a turn
//! of the encoder between two readings.

use crate::control::encoder::Direction;

/// Most bits of a turn: the position of a joint is an `i32`, and needs room for some turns.
const MOST_BITS: u32 = 24;

/// An absolute encoder on the load, and how it is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbsoluteEncoder {
    bits: u32,
    direction: Direction,
    zero: u32,
}

/// Position of the joint as of the last reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbsoluteState {
    reading: u32,
    position: i32,
}

/// Reason for which a reading does not give the position of the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlocated {
    /// No position of the range has this reading: the joint is outside, or the zero is wrong.
    OutOfRange,
    /// Several positions of the range have this reading: the number of turns is unknown.
    SeveralTurns,
}

impl AbsoluteEncoder {
    /// Returns an encoder with 2^`bits` counts in a turn, at most 2^24, which reads `zero` where
    /// the joint's position is zero.
    ///
    /// # Errors
    /// Returns `None` for zero bits, for more than 24, and for a `zero` of a turn or more.
    pub const fn new(bits: u32, direction: Direction, zero: u32) -> Option<Self> {
        if bits == 0 || bits > MOST_BITS || zero >> bits != 0 {
            return None;
        }
        Some(Self { bits, direction, zero })
    }

    /// Returns the position of the joint (counts) at power-on. The joint is between the positions
    /// `min` and `max`.
    ///
    /// ```
    /// use stiction::load_encoder::{AbsoluteEncoder, Unlocated};
    /// use stiction::control::encoder::Direction;
    ///
    /// // 14 bits, and a joint that reads 16000 at its zero.
    /// let encoder = AbsoluteEncoder::new(14, Direction::Forward, 16_000).unwrap();
    /// // A quarter of a turn either way: 4096 counts. The reading has passed the end of the turn.
    /// assert_eq!(encoder.locate(616, -4096, 4096), Ok(1000));
    /// assert_eq!(encoder.locate(8000, -4096, 4096), Err(Unlocated::OutOfRange));
    /// assert_eq!(encoder.locate(616, -16_384, 16_384), Err(Unlocated::SeveralTurns));
    /// ```
    ///
    /// # Errors
    /// Returns why there is no such position, or more than one.
    pub const fn locate(&self, reading: u32, min: i32, max: i32) -> Result<i32, Unlocated> {
        let turn = 1 << self.bits;
        // In 64 bits no range is too wide. The remainder of a power of two, without a division.
        let above_min = (self.signed(reading) as i64 - min as i64) & (turn - 1);
        let room = max as i64 - min as i64;
        if above_min > room {
            Err(Unlocated::OutOfRange)
        } else if above_min + turn <= room {
            Err(Unlocated::SeveralTurns)
        } else {
            Ok((min as i64 + above_min) as i32)
        }
    }

    /// Returns the state of a joint that is at `position` (counts) with this reading.
    pub const fn start(&self, reading: u32, position: i32) -> AbsoluteState {
        AbsoluteState { reading, position }
    }

    /// Updates the position with a new reading, and returns the travel since the last one, counts.
    pub const fn update(&self, state: &mut AbsoluteState, reading: u32) -> i32 {
        let travel = self.signed(reading.wrapping_sub(state.reading).wrapping_add(self.zero));
        state.reading = reading;
        state.position = state.position.wrapping_add(travel);
        travel
    }

    /// Returns the angle from the zero in the joint's direction, from minus half a turn on, counts.
    const fn signed(&self, reading: u32) -> i32 {
        let unused = u32::BITS - self.bits;
        let forward = reading.wrapping_sub(self.zero) << unused;
        let angle = match self.direction {
            Direction::Forward => forward,
            Direction::Reverse => forward.wrapping_neg(),
        };
        angle as i32 >> unused
    }
}

impl AbsoluteState {
    /// Returns the position of the joint as of the last reading, counts.
    pub const fn position(&self) -> i32 {
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: AbsoluteEncoder =
        AbsoluteEncoder { bits: 14, direction: Direction::Forward, zero: 16_000 };

    /// Every reading of an encoder of 14 bits, against the remainder of the true position.
    #[test]
    fn every_position_of_a_range_below_a_turn_is_found_from_its_reading() {
        for direction in [Direction::Forward, Direction::Reverse] {
            for zero in [0, 1, 8192, 16_383] {
                let encoder = AbsoluteEncoder::new(14, direction, zero).unwrap();
                for (min, max) in [(-8192, 8191), (0, 16_383), (-20_000, -3617)] {
                    for position in min..=max {
                        let sign = if direction == Direction::Forward { 1 } else { -1 };
                        let reading = (zero as i32 + sign * position).rem_euclid(16_384) as u32;
                        assert_eq!(encoder.locate(reading, min, max), Ok(position));
                    }
                }
            }
        }
    }

    /// A range of a turn and one position has two readings alike, at its ends.
    #[test]
    fn a_range_of_a_turn_is_ambiguous_at_its_ends_only() {
        for position in -8192_i32..=8192 {
            let reading = (16_000 + position).rem_euclid(16_384) as u32;
            let located = FORWARD.locate(reading, -8192, 8192);
            let is_end = i32::abs(position) == 8192;
            let expected = if is_end { Err(Unlocated::SeveralTurns) } else { Ok(position) };
            assert_eq!(located, expected);
        }
        assert_eq!(FORWARD.locate(0, i32::MIN, i32::MAX), Err(Unlocated::SeveralTurns));
        // The range ends a count before the joint.
        assert_eq!(FORWARD.locate(0, -100, 383), Err(Unlocated::OutOfRange));
        assert_eq!(FORWARD.locate(0, -100, 384), Ok(384));
    }

    #[test]
    fn turns_are_counted_both_ways_and_nothing_drifts() {
        for (direction, sign) in [(Direction::Forward, 1), (Direction::Reverse, -1)] {
            let encoder = AbsoluteEncoder::new(14, direction, 16_000).unwrap();
            let mut state = encoder.start(16_000, 0);
            // Just less than half a turn in each step: 100 turns, and back.
            let step = 8191;
            let mut true_position = 0_i32;
            for way in [1, -1] {
                for _ in 0..200 {
                    true_position += way * step;
                    let reading = (16_000 + sign * true_position).rem_euclid(16_384) as u32;
                    assert_eq!(encoder.update(&mut state, reading), way * step);
                    assert_eq!(state.position(), true_position);
                }
            }
            assert_eq!(state.position(), 0);
        }
    }

    #[test]
    fn an_encoder_without_room_for_its_turns_is_refused() {
        for (bits, zero) in [(0, 0), (25, 0), (14, 16_384), (24, 1 << 24)] {
            assert_eq!(AbsoluteEncoder::new(bits, Direction::Forward, zero), None);
        }
        for (bits, zero) in [(1, 1), (14, 16_383), (24, (1 << 24) - 1)] {
            assert!(AbsoluteEncoder::new(bits, Direction::Forward, zero).is_some());
        }
    }
}
