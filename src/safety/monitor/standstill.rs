//! The time for which the joint has stood still.
//!
//! The joint stands still while its position stays within two counts of an earlier one: an encoder
//! on an edge, or one with a wire cut, flickers by one. Creep, however slow, is no standstill,
//! because it leaves the band in the end; the caller decides how long a standstill has to last.

/// Half the width of the band, counts.
const BAND: u32 = 2;

/// A position and how long the joint has been near it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standstill {
    anchor: i32,
    ticks: u32,
}

impl Standstill {
    /// Updates the state with the position of a tick (counts). Returns the number of ticks for
    /// which the joint has stood still.
    ///
    /// ```
    /// let mut standstill = stiction::safety::monitor::Standstill::default();
    /// assert_eq!([0, 1, -1, 2, 3, 3].map(|counts| standstill.update(counts)), [1, 2, 3, 4, 0, 1]);
    /// ```
    #[inline]
    pub const fn update(&mut self, counts: i32) -> u32 {
        if counts.wrapping_sub(self.anchor).unsigned_abs() > BAND {
            *self = Self { anchor: counts, ticks: 0 };
        } else {
            self.ticks = self.ticks.saturating_add(1);
        }
        self.ticks
    }

    /// Returns the number of ticks for which the joint has stood still, as of the last tick.
    pub const fn ticks(&self) -> u32 {
        self.ticks
    }
}
