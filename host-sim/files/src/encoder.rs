//! The encoder's disc: from the joint's true position to what the hardware counter reads.

use serde::{Deserialize, Serialize};
use stiction::control::encoder::{CounterBits, Direction};

/// How a position between two counts is read.
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

/// The wires of the encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wires {
    /// As they should be.
    #[default]
    Sound,
    /// Both cut: the counter stands.
    Cut,
    /// One cut: the other one's edges count up and down by turns.
    OneCut,
    /// The two exchanged.
    Swapped,
}

/// Model of an incremental encoder: `counter = round(position / resolution + phase)`, wrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderModel {
    /// Joint angle of one count, deg.
    pub resolution: f64,
    /// How positions between counts are read.
    pub rounding: Rounding,
    /// Where the joint's zero lies between two counts, in counts.
    pub phase: f64,
    /// Width of the counter.
    pub counter_bits: CounterBits,
    /// Sense of counting.
    pub direction: Direction,
}

impl EncoderModel {
    /// The true number of counts at a joint position (deg).
    #[inline]
    pub fn counts(&self, position: f64) -> i64 {
        let counts = position / self.resolution + self.phase;
        // Conversion truncates: without SSE 4.1 `round` and `floor` are calls, and this is the
        // simulator's inner loop.
        let whole = counts as i64;
        let rest = counts - whole as f64;
        match self.rounding {
            Rounding::Nearest => {
                whole.saturating_add(i64::from(rest >= 0.5)).saturating_sub(i64::from(rest <= -0.5))
            }
            Rounding::Floor => whole.saturating_sub(i64::from(rest < 0.0)),
        }
    }

    /// What the hardware counter reads there.
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
