//! The option bytes with another brown-out level: what needs no register to decide.
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
//! To program them is to erase the sector that they are in and to write all of them, so every bit
//! that shall stay has to be written as it was. A wrong byte of protection cannot be taken back: it
//! costs the program or the part. So what is asked of the part is the very word that it has, but
//! for the two bits of the level, and a word that does not look like one of this part is refused.
//!
//! Nothing here knows a register, so that a test on a host goes through the words.

/// The level, in FLASH_OPTCR. None of its bits set is level 3: the part is reset below 2.7 V, where
/// its data sheet begins to allow 168 MHz with 5 wait states, and 32 bits at a time to its flash.
const BOR_LEV: u32 = 0b11 << 2;

/// Bits that are no option bytes: lock and start.
const CONTROL: u32 = 0b11;

/// Bits that an STM32F405 does not have.
const RESERVED: u32 = 1 << 4 | 0b1111 << 28;

/// The read protection that nothing ends, and under which no option byte can be changed.
const FOR_EVER: u32 = 0xCC;

/// The reason why the option bytes are left alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untouchable {
    /// The part is protected for ever (RDP level 2).
    Protected,
    /// A bit is set that this part does not have: it is another part, or it was misread.
    Unknown,
}

/// Returns what the register has to be for the highest brown-out level, without lock and start;
/// none if the level is that already.
///
/// # Errors
/// Says why the option bytes may not be touched.
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

/// Returns whether the register, read back, has the highest level, and every other option byte as
/// it was.
pub const fn is_done(before: u32, after: u32) -> bool {
    after & BOR_LEV == 0 && (before ^ after) & !(BOR_LEV | CONTROL) == 0
}
