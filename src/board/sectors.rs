//! The parameter sectors: 10 and 11 of the flash, 128 KiB each.

use stiction::Parameters;
use stiction::parameters::{DecodeError, ROOM};

const SECTOR_10: usize = 0x080C_0000;
const SECTOR_11: usize = 0x080E_0000;

/// The newest valid parameters, and the number of their sector.
pub fn read() -> Result<(Parameters, u8), DecodeError> {
    // SAFETY: flash that is always mapped, outside of the program (memory.x), and that nobody writes meanwhile.
    let sector = |address: usize| unsafe { core::slice::from_raw_parts(address as *const u8, ROOM) };
    let (parameters, which) = Parameters::newest([sector(SECTOR_10), sector(SECTOR_11)])?;
    Ok((parameters, 10 + which as u8))
}
