//! Simulated NOR flash whose power can be cut during a write or an erase.
//!
//! Like that of the STM32F405: a write of a word of four bytes can only clear bits; an erase of a
//! sector of 128 KiB sets them. A cut can leave the word or the sector untouched, finished, or with
//! some of its bits changed. Limits: words that read differently each time are not simulated.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Size of a sector, bytes.
pub const SECTOR: u32 = 128 * 1024;

const WORD: usize = 4;

/// State of the word or sector that a power cut interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutRemains {
    /// Unchanged.
    Untouched,
    /// Completely changed; only the report of success is missing.
    Finished,
    /// Some of the bits have changed; this number is the seed of their choice.
    Some(u64),
}

/// Time of a power cut, and its effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerCut {
    /// Number of word writes and sector erases before the cut.
    pub after: u32,
    /// State of the interrupted word or sector.
    pub remains: CutRemains,
}

/// A flash in memory.
#[derive(Clone, Debug)]
pub struct SimulatedFlash {
    bytes: Vec<u8>,
    cut: Option<PowerCut>,
    dead: bool,
    operations: u32,
}

impl SimulatedFlash {
    /// Creates an erased flash.
    pub fn new(sectors: u32) -> Self {
        Self {
            bytes: vec![0xFF; (sectors * SECTOR) as usize],
            cut: None,
            dead: false,
            operations: 0,
        }
    }

    /// Schedules a power cut.
    pub fn cut(&mut self, cut: PowerCut) {
        (self.cut, self.operations) = (Some(cut), 0);
    }

    /// Restores the power.
    pub fn revive(&mut self) {
        (self.cut, self.dead, self.operations) = (None, false, 0);
    }

    /// Returns the number of word writes and sector erases since power-on.
    pub const fn operations(&self) -> u32 {
        self.operations
    }

    /// Changes bytes to `wanted`, until a power cut. Returns whether the power has lasted.
    fn change(&mut self, from: usize, wanted: impl Fn(u8, usize) -> u8, length: usize) -> bool {
        if self.dead {
            return false;
        }
        let remains = match self.cut {
            Some(cut) if self.operations >= cut.after => {
                self.dead = true;
                cut.remains
            }
            _ => CutRemains::Finished,
        };
        self.operations += 1;
        let mut random = if let CutRemains::Some(seed) = remains { seed | 1 } else { 0 };
        for (i, byte) in self.bytes.iter_mut().skip(from).take(length).enumerate() {
            let wanted = wanted(*byte, i);
            let mask = match remains {
                CutRemains::Untouched => 0,
                CutRemains::Finished => 0xFF,
                CutRemains::Some(_) => {
                    // xorshift64 (Marsaglia 2003).
                    random ^= random << 13;
                    random ^= random >> 7;
                    random ^= random << 17;
                    random as u8
                }
            };
            *byte ^= (*byte ^ wanted) & mask;
        }
        !self.dead
    }
}

impl ErrorType for SimulatedFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SimulatedFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        if self.dead {
            return Err(NorFlashErrorKind::Other);
        }
        let from = self.bytes.iter().skip(offset as usize);
        bytes.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for SimulatedFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        for sector in (from..to).step_by(SECTOR as usize) {
            if !self.change(sector as usize, |_, _| 0xFF, SECTOR as usize) {
                return Err(NorFlashErrorKind::Other);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        for (i, word) in bytes.chunks(WORD).enumerate() {
            let from = offset as usize + i * WORD;
            // A write can only clear bits.
            let fall = |is: u8, i: usize| is & word.get(i).copied().unwrap_or(0xFF);
            if !self.change(from, fall, WORD) {
                return Err(NorFlashErrorKind::Other);
            }
        }
        Ok(())
    }
}
