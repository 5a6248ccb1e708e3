//! The option bytes with another brown-out level. Nothing here accesses a register, so that a test
//! on a host goes through the words.
//!
//! FLASH_OPTCR of an STM32F405 (RM0090, 3.9.9) has, from the lowest bit on:
//!
//! ```text
//!   0      OPTLOCK      no option byte: the register is locked
//!   1      OPTSTRT      no option byte: begins to program all of them
//!   3: 2   BOR_LEV      3 off, 2 level 1, 1 level 2, 0 level 3
//!   4      reserved     0
//!   7: 5   WDG_SW, nRST_STOP, nRST_STDBY
//!  15: 8   RDP          read protection: 0xAA none, 0xCC for ever, else until a mass erase
//!  27:16   nWRP         write protection of the twelve sectors
//!  31:28   reserved     0
//! ```
//!
//! Programming the option bytes erases their sector and writes all of them, so every bit that is to
//! stay has to be written unchanged. A wrong byte of protection cannot be undone: it costs the
//! program or the microcontroller. So the new word is the present one except for the two bits of
//! the level, and a word that does not look like that of an STM32F405 is refused.

/// Bits of the level in FLASH_OPTCR. Both clear is level 3: the microcontroller is reset below 2.7
/// V. From that supply on, its data sheet allows 168 MHz with 5 wait states, and writes to its
/// flash of 32 bits at a time.
const BOR_LEV: u32 = 0b11 << 2;

/// Bits that are no option bytes: lock and start.
const CONTROL: u32 = 0b11;

/// Bits that an STM32F405 does not have.
const RESERVED: u32 = 1 << 4 | 0b1111 << 28;

/// The permanent read protection, under which no option byte can be changed.
const FOR_EVER: u32 = 0xCC;

/// Reason why the option bytes are left unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untouchable {
    /// The microcontroller is permanently protected (RDP level 2).
    Protected,
    /// A bit is set that an STM32F405 does not have: this is another microcontroller, or the word
    /// was misread.
    Unknown,
}

/// Returns the word of the register for the highest brown-out level, with lock and start clear;
/// none if that level is already set.
///
/// # Errors
/// Returns the reason why the option bytes must not be changed.
pub const fn with_highest_level(before: u32) -> Result<Option<u32>, Untouchable> {
    if before & RESERVED != 0 {
        return Err(Untouchable::Unknown);
    }
    if before >> 8 & 0xFF == FOR_EVER {
        return Err(Untouchable::Protected);
    }
    if before & BOR_LEV == 0 {
        return Ok(None);
    }
    Ok(Some(before & !(BOR_LEV | CONTROL)))
}

/// Returns whether the register, read back, has the highest level, with every other option byte
/// unchanged.
pub const fn is_done(before: u32, after: u32) -> bool {
    after & BOR_LEV == 0 && (before ^ after) & !(BOR_LEV | CONTROL) == 0
}
