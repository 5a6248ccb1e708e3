//! The samples of telemetry: signals of a tick, as they are sent to a client that has subscribed.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::control::signal::{MAX_LAW_SIGNALS, SIGNALS};

/// The number of signals for which a sample has room, 4 bytes each.
pub const MAX_SIGNALS: usize = 40;

const _: () =
    assert!(SIGNALS.len() + MAX_LAW_SIGNALS <= MAX_SIGNALS, "a sample has no room for all signals");

/// A sample of telemetry: signals of one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the sample. It counts every sample that was due: a gap shows how many were lost.
    pub number: u32,
    /// Ticks since power-on.
    pub clock: u32,
    /// The signals that the sample has: a sum of 1 << place.
    pub signals: u64,
    /// The signals' values in ascending order of their places, four bytes each, little endian.
    pub values: Vec<u8, { 4 * MAX_SIGNALS }>,
}

impl Sample {
    /// Returns the bits of a signal, by its place, if the sample has the signal.
    ///
    /// ```
    /// use stiction::link::Sample;
    /// let values = [1, 0, 0, 0, 254, 255, 255, 255].into_iter().collect();
    /// let sample = Sample { number: 0, clock: 0, signals: 1 << 1 | 1 << 12, values };
    /// let value = |place| sample.value(place).map(|bits| bits as i32);
    /// assert_eq!([1, 6, 12].map(value), [Some(1), None, Some(-2)]);
    /// ```
    pub fn value(&self, place: usize) -> Option<u32> {
        let bit = 1u64.checked_shl(u32::try_from(place).ok()?)?;
        if self.signals & bit == 0 {
            return None;
        }
        let before = (self.signals & (bit - 1)).count_ones() as usize;
        self.values.get(4 * before..)?.first_chunk().copied().map(u32::from_le_bytes)
    }
}
