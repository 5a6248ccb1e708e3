//! The crystal's frequency, measured against the internal oscillator: what needs no register to
//! decide.
//!
//! The crystal divided by 31 captures the count of a timer that counts the internal 16 MHz; every
//! eighth edge does (RM0090: HSE_RTC on channel 1 of TIM11).
//!
//! ```text
//! counts of 16 captures = 16 * 8 * 31 * f_internal / f_crystal
//!     7936 at 16 MHz and 8 MHz
//!     7262 to 8337 with the internal oscillator 8 % low to 4.5 % high (data sheet, -40 to 105 C)
//!                  and a crystal or resonator that is 0.5 % off; 2 counts are those of the edges
//! ```
//!
//! So 8 MHz is accepted with any part, and 4, 6, 10, 12, 16 and 25 MHz are refused with any part.
//! A frequency within a tenth of 8 MHz cannot be distinguished from it.
//!
//! The PLL comes after the measurement. With the dividers of 8 MHz it locks on 8 to 16 MHz, and
//! perhaps not on 4 or 25 MHz (its input has to be 0.95 to 2.1 MHz, data sheet): a crystal of these
//! would otherwise be reported as one that does not run. Nothing here knows a register, so that a
//! test on a host goes through both tolerances.

/// Divider of the crystal, the largest one there is: a timer's input of 0.84 MHz at most.
pub const DIVIDER: u8 = 31;

/// Captures that are measured over.
pub const CAPTURES: u32 = 16;

/// Edges of the divided crystal between two captures.
const EDGES: u32 = 8;

/// The internal oscillator, MHz.
const INTERNAL_MHZ: u32 = 16;

/// Counts of [`CAPTURES`] at 16 MHz and 8 MHz.
const EXPECTED: u32 = CAPTURES * EDGES * DIVIDER as u32 * INTERNAL_MHZ / 8;

/// The least and the most counts that a crystal of 8 MHz gives.
const ACCEPTED: [u32; 2] =
    [EXPECTED * 92 / 100 * 995 / 1000 - 2, EXPECTED * 1045 / 1000 * 1005 / 1000 + 3];

/// What is known of the crystal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crystal {
    /// The crystal runs at 8 MHz, within the tolerance of the internal oscillator.
    Right,
    /// The crystal runs. The timer has captured nothing in time, which says nothing of the crystal:
    /// its edges were counted when it was started, and the PLL has locked on it.
    NotMeasured,
    /// The crystal runs at another frequency: this one (MHz), to the internal oscillator's error.
    Wrong(f32),
    /// The crystal does not run, or the PLL does not lock on it though it has the right frequency.
    Absent,
}

impl Crystal {
    /// Judges a crystal by the counts of its captures; none if there were too few captures.
    pub fn of(counts: Option<u32>) -> Self {
        let [least, most] = ACCEPTED;
        match counts {
            None | Some(0) => Self::NotMeasured,
            Some(counts) if (least..=most).contains(&counts) => Self::Right,
            Some(counts) => Self::Wrong(8.0 * EXPECTED as f32 / counts as f32),
        }
    }

    /// Judges a crystal that may be used by the PLL, which locks on one that goes on running.
    pub fn with_pll(self, locks: impl FnOnce() -> bool) -> Self {
        if self.is_used() && !locks() { Self::Absent } else { self }
    }

    /// Returns whether the part runs from the crystal.
    pub const fn is_used(self) -> bool {
        matches!(self, Self::Right | Self::NotMeasured)
    }
}
