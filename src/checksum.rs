//! CRC-32 (ISO-HDLC) of records and frames.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// Without a table: a kilobyte of flash for tasks that have time.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Of pieces that follow each other.
#[inline(never)]
pub(crate) fn checksum(pieces: &[&[u8]]) -> u32 {
    let mut digest = CRC.digest();
    for piece in pieces {
        digest.update(piece);
    }
    digest.finalize()
}
