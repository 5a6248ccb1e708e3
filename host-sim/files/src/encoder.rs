//! Model of the encoder: from the joint's true position to the reading of the hardware counter.

use serde::{Deserialize, Serialize};
use stiction::control::encoder::{CounterBits, Direction};

/// Rounding of a position between two counts.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Rounding {
    /// To the nearest count.
    #[default]
    Nearest,
    /// Down: a count begins at its edge.
    Floor,
}

/// State of the encoder's wires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wires {
    /// Intact.
    #[default]
    Sound,
    /// Both cut: the counter does not change.
    Cut,
    /// One wire is cut: the edges of the intact one alternately count up and down.
    OneCut,
    /// The two lines are exchanged.
    Swapped,
}

impl Wires {
    /// Returns the levels of the two input lines (bit 0: A, bit 1: B) at a count of the disc.
    /// Line A rises first in the direction that counts up. A line that is cut follows its resistor:
    /// a pull-up if `pulls_up` is true, or else a pull-down.
    pub const fn lines(self, counts: u32, pulls_up: bool) -> u8 {
        let driven = [0b00, 0b01, 0b11, 0b10][counts as usize % 4];
        let pulled = if pulls_up { 0b11 } else { 0b00 };
        match self {
            Self::Sound => driven,
            Self::Cut => pulled,
            Self::OneCut => (pulled & 0b01) | (driven & 0b10),
            Self::Swapped => (driven >> 1) | (driven << 1 & 0b10),
        }
    }
}

/// Model of an incremental encoder: `counter = round(position / resolution + phase)`, wrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderModel {
    /// Joint angle of one count, deg.
    pub resolution: f64,
    /// Rounding of positions between counts.
    pub rounding: Rounding,
    /// Place of the joint's zero between two counts, in counts.
    pub phase: f64,
    /// Width of the counter.
    pub counter_bits: CounterBits,
    /// Sense of counting.
    pub direction: Direction,
}

/// The largest number below one half. Added away from zero before truncation, it rounds half away
/// from zero, exactly: a half would also round up the number below 0.5, and odd whole numbers from
/// 2^52 on.
const BELOW_HALF: f64 = 0.499_999_999_999_999_94;

impl EncoderModel {
    /// Returns the number of counts at a joint position (deg), not wrapped.
    #[inline]
    pub fn counts(&self, position: f64) -> i64 {
        let counts = position / self.resolution + self.phase;
        // Conversion truncates: without SSE 4.1 `round` and `floor` are calls, and this is the
        // simulator's inner loop, each step of which waits for the one before.
        match self.rounding {
            Rounding::Nearest => (counts + BELOW_HALF.copysign(counts)) as i64,
            Rounding::Floor => {
                let whole = counts as i64;
                whole.saturating_sub(i64::from(counts < whole as f64))
            }
        }
    }

    /// Returns the reading of the hardware counter at a joint position (deg).
    #[inline]
    pub fn counter(&self, position: f64) -> u32 {
        let counts = self.counts(position);
        let counted = match self.direction {
            Direction::Forward => counts,
            Direction::Reverse => counts.wrapping_neg(),
        };
        match self.counter_bits {
            CounterBits::Sixteen => u32::from(counted as u16),
            CounterBits::ThirtyTwo => counted as u32,
        }
    }
}
