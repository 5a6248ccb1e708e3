//! The parameter sectors: 10 and 11 of the flash, 128 KiB each; and the option bytes, which are in
//! a sector of their own ([`super::option_bytes`]).
//!
//! There is one bank: while a sector is erased or a word is written, nothing can be fetched, and
//! the processor stands still with all its interrupts. An erase takes 1 to 2 s at 32 bits of
//! parallelism (data sheet; 4 s at 8). The caller ensures that nothing is driven, that no tick is
//! due, and that the watchdog waits. The code does not have to be in RAM: the processor stalls at
//! its next fetch and continues afterwards. A processor that does not stall (an emulated one)
//! sleeps.

use core::ptr;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use stiction::Parameters;
use stiction::parameters::{DecodeError, ROOM};
use stm32f4xx_hal::pac;

use super::option_bytes::{self, Untouchable};

/// Address of sector 10; sector 11 follows.
const BEGIN: usize = 0x080C_0000;
const SECTOR: usize = 128 * 1024;
const FIRST: u8 = 10;

/// Places of the store's two slots, bytes from the start of sector 10.
pub const SLOTS: [u32; 2] = [0, SECTOR as u32];

/// The keys that unlock the control register, in this order (RM0090, 3.6.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// The keys that unlock the register of the option bytes, in this order (RM0090, 3.7.2).
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// Flags of the status register that report an error: operation, protection, alignment,
/// parallelism, sequence.
const ERRORS: u32 = 0b1111_0010;

/// Returns the first bytes of both sectors, which hold the records.
fn records() -> [&'static [u8]; 2] {
    // SAFETY: flash that is always mapped, outside of the program (memory.x), and that is not
    // written meanwhile.
    [BEGIN, BEGIN + SECTOR]
        .map(|address| unsafe { core::slice::from_raw_parts(address as *const u8, ROOM) })
}

/// Returns whether a sector holds data that is no valid record.
#[inline(never)]
pub fn are_damaged() -> bool {
    records().into_iter().any(Parameters::is_damaged)
}

/// Returns the newest valid parameters, the number of saves, and the number of their sector.
#[inline(never)]
pub fn read() -> Result<(Parameters, u32, u8), DecodeError> {
    let (parameters, saves, which) = Parameters::newest(records())?;
    Ok((parameters, saves, FIRST + which as u8))
}

/// Time between two checks of whether an erase is over, clocks of the processor: 10 ms at 168 MHz.
const LOOK_EVERY: u32 = 1_680_000;

/// The two sectors of the flash, to be read and written.
pub struct Sectors {
    registers: pac::FLASH,
    alarm: SYST,
}

/// Reason why the option bytes were not set.
#[derive(Debug)]
pub enum Unset {
    /// The option bytes were left unchanged.
    Untouchable(Untouchable),
    /// The flash has reported an error, or the option bytes read back are wrong.
    Failed(FlashRefusal),
}

/// Error of an operation on the flash.
#[derive(Debug)]
pub struct FlashRefusal(NorFlashErrorKind);

impl Sectors {
    /// Makes the sectors from the flash's registers and a timer that nothing else uses.
    pub fn new(registers: pac::FLASH, mut alarm: SYST) -> Self {
        alarm.set_clock_source(SystClkSource::Core);
        alarm.set_reload(LOOK_EVERY);
        Self { registers, alarm }
    }

    /// Runs `act` with the control register unlocked, and locks the register again, also after an
    /// error.
    fn unlocked(
        &mut self,
        act: impl FnOnce(&pac::FLASH, &mut SYST) -> Result<(), FlashRefusal>,
    ) -> Result<(), FlashRefusal> {
        let Self { registers, alarm } = self;
        if registers.cr().read().lock().bit_is_set() {
            for key in KEYS {
                registers.keyr().write(|w| w.key().set(key));
            }
        }
        // Otherwise, earlier errors would count as errors of this operation.
        registers.sr().write(|w| unsafe { w.bits(ERRORS) });
        let done = act(registers, alarm);
        registers.cr().write(|w| w.lock().set_bit());
        done
    }

    /// Sets the brown-out level in the option bytes to the highest, unless that level is already
    /// set. The option bytes are in a sector of their own, which is erased and written: the program
    /// stands still meanwhile. The new level takes effect after the next reset.
    ///
    /// # Errors
    /// Returns the reason why the option bytes were left unchanged, or are wrong.
    pub fn set_brown_out(&mut self) -> Result<(), Unset> {
        let Self { registers, alarm } = self;
        let before = registers.optcr().read().bits();
        let Some(wanted) = option_bytes::with_highest_level(before).map_err(Unset::Untouchable)?
        else {
            return Ok(());
        };
        Self::wait(registers, alarm).map_err(Unset::Failed)?;
        // Otherwise, earlier errors would count as errors of this operation.
        registers.sr().write(|w| unsafe { w.bits(ERRORS) });
        for key in OPTION_KEYS {
            // SAFETY: a key is what the register is for.
            registers.optkeyr().write(|w| unsafe { w.bits(key) });
        }
        // SAFETY: the word that was there, but for the level.
        registers.optcr().write(|w| unsafe { w.bits(wanted) });
        registers.optcr().modify(|_, w| w.optstrt().set_bit());
        let done = Self::wait(registers, alarm);
        registers.optcr().modify(|_, w| w.optlock().set_bit());
        done.map_err(Unset::Failed)?;
        if option_bytes::is_done(before, registers.optcr().read().bits()) {
            Ok(())
        } else {
            Err(Unset::Failed(FlashRefusal(NorFlashErrorKind::Other)))
        }
    }

    /// Sleeps until the flash is ready, and wakes for a check now and then. The register crate does
    /// not define the flash's own interrupt.
    fn wait(registers: &pac::FLASH, alarm: &mut SYST) -> Result<(), FlashRefusal> {
        alarm.clear_current();
        alarm.enable_interrupt();
        alarm.enable_counter();
        while registers.sr().read().bsy().bit_is_set() {
            cortex_m::asm::wfi();
        }
        alarm.disable_counter();
        alarm.disable_interrupt();
        Self::outcome(registers)
    }

    fn outcome(registers: &pac::FLASH) -> Result<(), FlashRefusal> {
        match registers.sr().read().bits() & ERRORS {
            0 => Ok(()),
            _ => Err(FlashRefusal(NorFlashErrorKind::Other)),
        }
    }

    /// Empties the data cache, whose copy of an erased sector is out of date.
    fn forget(registers: &pac::FLASH) {
        registers.acr().modify(|_, w| w.dcen().clear_bit());
        registers.acr().modify(|_, w| w.dcrst().set_bit());
        registers.acr().modify(|_, w| w.dcrst().clear_bit().dcen().set_bit());
    }
}

impl NorFlashError for FlashRefusal {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl ErrorType for Sectors {
    type Error = FlashRefusal;
}

impl ReadNorFlash for Sectors {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashRefusal> {
        check_read(self, offset, bytes.len()).map_err(FlashRefusal)?;
        for (byte, at) in bytes.iter_mut().zip(BEGIN + offset as usize..) {
            // SAFETY: within the two sectors, which are always mapped. They change behind the
            // compiler's back.
            *byte = unsafe { ptr::read_volatile(at as *const u8) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl NorFlash for Sectors {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashRefusal> {
        check_erase(self, from, to).map_err(FlashRefusal)?;
        for number in
            (from as usize / SECTOR..to as usize / SECTOR).map(|index| FIRST + index as u8)
        {
            self.unlocked(|registers, alarm| {
                // Bits that are not set here have their reset values; the reset value of the lock
                // is locked.
                registers.cr().write(|w| unsafe {
                    w.lock().clear_bit().ser().set_bit().psize().psize32().snb().bits(number)
                });
                registers.cr().modify(|_, w| w.strt().set_bit());
                Self::wait(registers, alarm)
            })?;
        }
        Self::forget(&self.registers);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashRefusal> {
        check_write(self, offset, bytes.len()).map_err(FlashRefusal)?;
        self.unlocked(|registers, _| {
            registers.cr().write(|w| w.lock().clear_bit().pg().set_bit().psize().psize32());
            for (word, at) in bytes.as_chunks().0.iter().zip((BEGIN + offset as usize..).step_by(4))
            {
                // SAFETY: an aligned word within the two sectors, which hold nothing that the
                // program refers to.
                unsafe { ptr::write_volatile(at as *mut u32, u32::from_le_bytes(*word)) };
                // A write takes 16 us, for which the processor stands still anyway.
                while registers.sr().read().bsy().bit_is_set() {}
                Self::outcome(registers)?;
            }
            Ok(())
        })
    }
}
