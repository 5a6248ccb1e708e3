//! The crystal's frequency, measured against the internal oscillator. Nothing here accesses a
//! register, so that a test on a host covers both tolerances.
//!
//! A timer counts the internal 16 MHz. Every eighth edge of the crystal's signal divided by 31
//! captures the count (RM0090: HSE_RTC on channel 1 of TIM11).
//!
//! ```text
//! counts of 16 captures = 16 * 8 * 31 * f_internal / f_crystal
//!     7936, 5290, 3968 and 2539 at 16 MHz and 8, 12, 16 and 25 MHz
//!     of 8 MHz: 7262 to 8337 with the internal oscillator 8 % low to 4.5 % high (data sheet, -40
//!                  to 105 C) and a crystal or resonator that is 0.5 % off; 2 counts are those of
//!                  the edges
//! ```
//!
//! The ranges of the four crystals in [`FITTED_MHZ`] do not overlap. So on any microcontroller,
//! each of the four is recognised, and 4, 6, 10 and 20 MHz are refused. A frequency within a tenth
//! of one of the four cannot be distinguished from it: 24 and 26 MHz may pass as 25 MHz.
//!
//! The PLL comes after the measurement. Its input is 1 MHz from any of the four, and has to be 0.95
//! to 2.1 MHz (data sheet). With dividers of another crystal it might not lock, and the crystal
//! would be reported as one that does not run.

/// Divider of the crystal, the largest one there is: a timer's input of 0.84 MHz at most.
pub const DIVIDER: u8 = 31;

/// Number of captures in a measurement.
pub const CAPTURES: u32 = 16;

/// Edges of the divided crystal between two captures.
const EDGES: u32 = 8;

/// Frequency of the internal oscillator, MHz.
const INTERNAL_MHZ: u32 = 16;

/// Counts of [`CAPTURES`] at 16 MHz, times the crystal's frequency (MHz).
const COUNTS_MHZ: u32 = CAPTURES * EDGES * DIVIDER as u32 * INTERNAL_MHZ;

/// Frequencies of a crystal from which the microcontroller runs, MHz: the usual ones on its boards.
pub const FITTED_MHZ: [u8; 4] = [8, 12, 16, 25];

/// The frequency of a crystal that runs and could not be measured, MHz: that of the board on the
/// wiring page.
const ASSUMED_MHZ: u8 = 8;

/// Returns the range of counts of a crystal of `mhz` (MHz).
const fn accepted(mhz: u8) -> core::ops::RangeInclusive<u32> {
    let expected = COUNTS_MHZ / mhz as u32;
    expected * 92 / 100 * 995 / 1000 - 2..=(expected + 1) * 1045 / 1000 * 1005 / 1000 + 3
}

/// State of the crystal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crystal {
    /// The crystal runs at this frequency of [`FITTED_MHZ`], within the tolerance of the internal
    /// oscillator.
    Measured(u8),
    /// The crystal runs, but the timer has captured nothing in time. The crystal may still be good:
    /// its edges were counted when it was started, and the PLL has locked on it as on 8 MHz.
    NotMeasured,
    /// The crystal runs at another frequency: this one (MHz), within the error of the internal
    /// oscillator.
    Wrong(f32),
    /// The crystal does not run, or the PLL does not lock on it though it has a right frequency.
    Absent,
}

impl Crystal {
    /// Returns the state of a crystal with these counts of its captures; none: there were too few
    /// captures.
    pub fn of(counts: Option<u32>) -> Self {
        match counts {
            None | Some(0) => Self::NotMeasured,
            Some(counts) => FITTED_MHZ
                .into_iter()
                .find(|mhz| accepted(*mhz).contains(&counts))
                .map_or(Self::Wrong(COUNTS_MHZ as f32 / counts as f32), Self::Measured),
        }
    }

    /// Tests a usable crystal with the PLL, which locks only on a crystal that keeps running.
    /// `locks` returns whether the PLL locks on a crystal of that frequency, MHz. If not, the
    /// crystal is absent.
    pub fn with_pll(self, locks: impl FnOnce(u8) -> bool) -> Self {
        if self.mhz().is_some_and(|mhz| !locks(mhz)) { Self::Absent } else { self }
    }

    /// Returns the frequency of the crystal from which the microcontroller runs, MHz; none if it
    /// runs from its internal oscillator.
    pub const fn mhz(self) -> Option<u8> {
        match self {
            Self::Measured(mhz) => Some(mhz),
            Self::NotMeasured => Some(ASSUMED_MHZ),
            Self::Wrong(_) | Self::Absent => None,
        }
    }
}
