//! Property of parameter records: any bytes decode to valid parameters or to an error.

use crc::{CRC_32_ISO_HDLC, Crc};
use stiction::Parameters;
use stiction::parameters::{DecodeError, FORMAT_VERSION, ROOM};

use files::hardware::STM32F405;

const HEADER: usize = 20;

/// Decodes the bytes as they are, and as a body with a valid header. Returns whether either is a
/// record.
pub fn holds(bytes: &[u8]) -> bool {
    let as_it_is = decoded(bytes);
    let Some((_, body)) = bytes.split_at_checked(HEADER) else { return as_it_is };
    // Every existing version, and the two next to them.
    let version = u32::from(bytes.get(4).copied().unwrap_or_default()) % (FORMAT_VERSION + 2);
    decoded(&with_header(version, body)) || as_it_is
}

/// Returns a record of this body, with a valid header.
fn with_header(version: u32, body: &[u8]) -> Vec<u8> {
    let mut record = b"STIC".to_vec();
    record.extend(version.to_le_bytes());
    record.extend(1u32.to_le_bytes());
    record.extend((body.len() as u32).to_le_bytes());
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(record.get(4..).unwrap_or_default());
    digest.update(body);
    record.extend(digest.finalize().to_le_bytes());
    record.extend(body);
    record
}

fn decoded(bytes: &[u8]) -> bool {
    let Ok((parameters, _)) = Parameters::decode(bytes) else { return false };
    assert_eq!(parameters.check(), Ok(()), "decoded parameters are valid");
    // A record is independent of its board: `prepare` checks the times and the frequency of timers.
    let prepared = parameters.prepare(&STM32F405).map(|_| ()).map_err(DecodeError::Value);
    assert_eq!(prepared, parameters.fits(&STM32F405), "all else that a board needs is valid");
    let mut room = [0; ROOM];
    let record = parameters.encode(7, &mut room).map(<[u8]>::to_vec).unwrap_or_default();
    assert_eq!(
        Parameters::decode(&record).as_ref(),
        Ok(&(parameters.clone(), 7)),
        "and is the same again"
    );
    // Otherwise a header of another layout would be refused, and the bodies would not be tested.
    let by_hand = with_header(FORMAT_VERSION, record.get(HEADER..).unwrap_or_default());
    assert_eq!(Parameters::decode(&by_hand), Ok((parameters, 1)), "and so with a header made here");
    true
}
