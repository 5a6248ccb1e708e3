//! The checksum of records and frames: CRC-32 (ISO-HDLC).

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// CRC-32 without a table, which would cost a kilobyte of flash: the tasks that compute it have
/// time.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Returns the CRC-32 of pieces that follow each other.
#[inline(never)]
pub(crate) fn checksum(pieces: &[&[u8]]) -> u32 {
    let mut digest = CRC.digest();
    for piece in pieces {
        digest.update(piece);
    }
    digest.finalize()
}
