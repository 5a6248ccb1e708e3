//! The cause of a reset, and whether the reset may have been a dip of the supply, from the flags of
//! the registers (RM0090: RCC_CSR, and BOR_LEV of FLASH_OPTCR).
//!
//! The factory's setting of the brown-out reset is off. A dip of the supply then causes a reset
//! only below 1.8 V, with the flags of power-on. So with the brown-out reset off, a dip cannot be
//! distinguished from power-on, and nothing arms automatically unless the parameters allow it. With
//! the brown-out reset on, a dip below its level has a flag of its own, and a reset with the flags
//! of power-on means that the supply was below 1.8 V. The RAM may have survived that; if it shows
//! that the motor was being driven, this is a fault in either case.

use stiction::Fault;

/// Flags in RCC_CSR: brown-out, pin, power-on, software and the independent watchdog.
const BORRSTF: u32 = 1 << 25;
const PINRSTF: u32 = 1 << 26;
const PORRSTF: u32 = 1 << 27;
const SFTRSTF: u32 = 1 << 28;
const IWDGRSTF: u32 = 1 << 29;

/// The cause of the last reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// Power came up.
    PowerOn,
    /// The supply sagged below the brown-out level. Only a microcontroller whose option bytes
    /// enable that level distinguishes this from power-on.
    BrownOut,
    /// The independent watchdog was not fed.
    Watchdog,
    /// The program or a debugger requested the reset.
    Software,
    /// The reset pin was pulled.
    Pin,
    /// Another cause, which this firmware does not use.
    Other,
}

impl ResetCause {
    /// Returns the cause that the flags of RCC_CSR show.
    pub const fn of(flags: u32) -> Self {
        // Every internal reset pulls the pin as well, and power-on sets the brown-out flag: the
        // order decides.
        if flags & PORRSTF != 0 {
            Self::PowerOn
        } else if flags & BORRSTF != 0 {
            Self::BrownOut
        } else if flags & IWDGRSTF != 0 {
            Self::Watchdog
        } else if flags & SFTRSTF != 0 {
            Self::Software
        } else if flags & PINRSTF != 0 {
            Self::Pin
        } else {
            Self::Other
        }
    }

    /// Returns whether the reset may have been a dip of the supply that no flag shows.
    pub const fn may_be_dip(self, brown_out: BrownOut) -> bool {
        matches!(self, Self::PowerOn | Self::Other) && !brown_out.is_on()
    }

    /// Returns the fault of the cause, if any; `was_armed`: the motor was being driven.
    pub const fn fault(self, was_armed: bool) -> Option<Fault> {
        match self {
            Self::Watchdog => Some(Fault::Watchdog),
            Self::BrownOut => Some(Fault::BrownOut),
            _ if was_armed => Some(Fault::ResetWhileArmed),
            _ => None,
        }
    }

    /// Returns a short description for a log.
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

/// The level of the brown-out reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrownOut(u8);

impl BrownOut {
    /// Returns the level that the option bytes (FLASH_OPTCR) have.
    pub const fn of(options: u32) -> Self {
        Self(3 - (options >> 2 & 3) as u8)
    }

    /// Returns whether a brown-out resets the microcontroller.
    pub const fn is_on(self) -> bool {
        self.0 > 0
    }

    /// Returns the level for a log: the supply below which the microcontroller is reset, at least.
    pub const fn describe(self) -> &'static str {
        match self.0 {
            0 => "off (1.8 V)",
            1 => "level 1 (2.1 V)",
            2 => "level 2 (2.4 V)",
            _ => "level 3 (2.7 V)",
        }
    }
}
