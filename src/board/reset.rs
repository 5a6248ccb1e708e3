//! The reset: why the part was reset.

use stiction::Fault;
use stm32f4xx_hal::pac;

/// The cause of the last reset.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Power came up.
    PowerOn,
    /// The supply sagged below the brown-out level. Only parts whose option bytes enable that level
    /// tell it from power-on.
    BrownOut,
    /// The independent watchdog was not fed.
    Watchdog,
    /// The program or a debugger asked for the reset.
    Software,
    /// The reset pin was pulled.
    Pin,
    /// The cause is none that this firmware uses.
    Other,
}

impl Cause {
    /// Reads the cause from the flags, and clears them for the next time.
    pub fn take(rcc: &pac::RCC) -> Self {
        let flags = rcc.csr().read();
        rcc.csr().modify(|_, w| w.rmvf().clear());
        // Every internal reset pulls the pin as well, and power-on sets the brown-out flag: the
        // order decides.
        if flags.porrstf().is_reset() {
            Self::PowerOn
        } else if flags.borrstf().is_reset() {
            Self::BrownOut
        } else if flags.wdgrstf().is_reset() {
            Self::Watchdog
        } else if flags.sftrstf().is_reset() {
            Self::Software
        } else if flags.padrstf().is_reset() {
            Self::Pin
        } else {
            Self::Other
        }
    }

    /// Returns the fault that the cause is by itself, given whether the motor was being driven.
    pub const fn fault(self, was_armed: bool) -> Option<Fault> {
        match self {
            Self::Watchdog => Some(Fault::Watchdog),
            Self::BrownOut => Some(Fault::BrownOut),
            _ if was_armed => Some(Fault::ResetWhileArmed),
            _ => None,
        }
    }

    /// Returns a few words for a log.
    pub const fn describe(self) -> &'static str {
        match self {
            Self::PowerOn => "power on",
            Self::BrownOut => "brown-out",
            Self::Watchdog => "watchdog",
            Self::Software => "software or debugger",
            Self::Pin => "reset pin",
            Self::Other => "other",
        }
    }
}
