//! The store of the parameters: two slots of NOR flash, written in turn.
//!
//! Each slot is a sector of its own with one record of [`crate::parameters`] at its start: magic,
//! version, sequence number, checksum. The valid record with the higher sequence number is in
//! effect. A save erases, writes and reads back the *other* slot; the slot in effect is never
//! touched. So if the power fails, at a write or in the middle of an erase, either the old set or
//! the new one is found intact. The new set is in effect as soon as its last word is written, since
//! its checksum covers all of it.
//!
//! Why not a log of changes: a set is written a few times in the life of a machine, and an erase of
//! a sector takes as long whether it holds one record or hundreds.
//!
//! A board whose program runs from the flash stands still while a sector is erased, for seconds. So
//! parameters are saved only while the output is off, with a longer timeout of the watchdog.
//! Sectors and times depend on the board.
//!
//! Does badly: a word whose write was cut short may read differently each time. When its record
//! fails the checksum, the other slot is in effect, but no test by reading can detect such a word.

use embedded_storage::nor_flash::NorFlash;

use crate::parameters::{DecodeError, Parameters, ROOM};

/// The largest write unit of a flash that the store can write, bytes.
const LARGEST_UNIT: usize = 64;

/// A store of parameters in two sectors of a flash.
#[derive(Clone, Debug)]
pub struct Store<F> {
    flash: F,
    slots: [u32; 2],
}

/// The reason why parameters could not be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError {
    /// The flash refused to erase, write or read.
    Flash,
    /// The record that was read back differs from the written one.
    Verify,
    /// The record does not fit the room of a slot.
    TooLong,
}

impl<F: NorFlash> Store<F> {
    /// Returns a store in the sectors that begin at `slots`, bytes from the start of the flash.
    pub const fn new(flash: F, slots: [u32; 2]) -> Self {
        Self { flash, slots }
    }

    /// Returns the saved parameters in effect.
    ///
    /// # Errors
    /// Returns the reason if neither slot has valid parameters. A flash that cannot be read has
    /// none.
    pub fn load(&mut self) -> Result<Parameters, DecodeError> {
        self.newest().map(|(parameters, ..)| parameters)
    }

    /// Returns whether a slot holds something that is no valid record: a save that was cut short,
    /// or damage. If it was the newest record, the parameters in effect are older ones.
    #[inline(never)]
    pub fn is_damaged(&mut self) -> bool {
        let slots = self.slots;
        slots.into_iter().any(|slot| !matches!(self.decode(slot), Ok(_) | Err(DecodeError::Blank)))
    }

    /// Returns the sequence number of the newest record. It is the number of saves, if no probe has
    /// written records meanwhile. A sector withstands ten thousand erases, and each save erases one
    /// of two sectors.
    pub fn saves(&mut self) -> u32 {
        self.newest().map_or(0, |(_, sequence, _)| sequence)
    }

    /// Saves validated parameters for the next boot. A save erases one sector at most.
    ///
    /// A save lasts for seconds and stops the program, so the output has to be off.
    ///
    /// # Errors
    /// Returns the reason why the flash failed. The previous parameters stay in effect.
    pub fn save(&mut self, parameters: &Parameters) -> Result<(), SaveError> {
        let is_damaged = self.is_damaged();
        let (sequence, which) = match self.newest() {
            Ok((found, sequence, which)) => {
                if found == *parameters && !is_damaged {
                    return Ok(());
                }
                (sequence.wrapping_add(1), 1 - which)
            }
            Err(_) => (1, 0),
        };
        let [first, second] = self.slots;
        let slot = if which == 0 { first } else { second };
        self.write(slot, sequence, parameters)?;
        match self.decode(slot) {
            Ok((found, number)) if found == *parameters && number == sequence => Ok(()),
            _ => Err(SaveError::Verify),
        }
    }

    /// Erases a damaged slot, which would be reported again at the next power-on. This is not part
    /// of [`save`](Self::save), so that a watchdog waits for one erase at a time.
    ///
    /// # Errors
    /// Returns an error if the flash fails.
    pub fn erase_damaged(&mut self) -> Result<(), SaveError> {
        let Ok((_, _, which)) = self.newest() else { return Ok(()) };
        let [first, second] = self.slots;
        let other = if which == 0 { second } else { first };
        if matches!(self.decode(other), Ok(_) | Err(DecodeError::Blank)) {
            return Ok(());
        }
        let end = other.saturating_add(F::ERASE_SIZE as u32);
        self.flash.erase(other, end).map_err(|_| SaveError::Flash)
    }

    /// Returns the flash, for other users of it.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    #[inline(never)]
    fn write(
        &mut self,
        slot: u32,
        sequence: u32,
        parameters: &Parameters,
    ) -> Result<(), SaveError> {
        // The room is erased flash beyond the record, so that a unit can be written to its end.
        let mut room = [0xFF; ROOM];
        let length = parameters.encode(sequence, &mut room).ok_or(SaveError::TooLong)?.len();
        if F::WRITE_SIZE > LARGEST_UNIT {
            return Err(SaveError::Flash);
        }
        let whole = length.next_multiple_of(F::WRITE_SIZE.max(1));
        let bytes = room.get(..whole).ok_or(SaveError::TooLong)?;
        let end = slot.saturating_add(F::ERASE_SIZE as u32);
        self.flash.erase(slot, end).map_err(|_| SaveError::Flash)?;
        self.flash.write(slot, bytes).map_err(|_| SaveError::Flash)
    }

    #[inline(never)]
    fn newest(&mut self) -> Result<(Parameters, u32, usize), DecodeError> {
        let [first, second] = self.slots;
        let first = self.decode(first);
        let second = self.decode(second);
        Parameters::newer(first, second)
    }

    #[inline(never)]
    fn decode(&mut self, slot: u32) -> Result<(Parameters, u32), DecodeError> {
        let mut room = [0; ROOM];
        self.flash.read(slot, &mut room).map_err(|_| DecodeError::NotParameters)?;
        Parameters::decode(&room)
    }
}
