//! The record of parameters, for the flash and for the link.
//!
//! ```text
//! byte  0  magic "STIC"
//!       4  format version   u32, little endian, as everything here
//!       8  sequence         u32, the higher one of two valid records is the newer
//!      12  length of body   u32
//!      16  CRC-32 (ISO-HDLC) of bytes 4 to 15 and of the body
//!      20  body             entries of 6 bytes: the value's number (u16) and its 32 bits
//! ```
//!
//! Why this form: a value that a later version adds is one more entry, so the format stays. If a
//! record lacks the value, the value is its default, or is derived from the rest. A firmware to
//! which an entry is unknown refuses the record and names the entry ([`DecodeError::Unknown`]),
//! since it cannot apply the value.
//!
//! Guarantees: decoding is total. Any sequence of bytes yields either parameters with all values
//! validated, or an error that names the cause. Does badly: an entry takes 6 bytes where 5 would
//! do; a record has room for 338 of them.

use super::Parameters;
use crate::control::current_sensor::CurrentSensor;
use crate::control::profile::ProfileLimits;
use crate::motion::jog::JogBounds;
use crate::safety::monitor::Limits;
use crate::units::error::InvalidValue;
use crate::units::value::{Absent, Key, Table, Values, key};

/// The format version of the body. Versions 1 to 3 were never released and are refused.
pub const FORMAT_VERSION: u32 = 4;

/// Bytes in which every record fits, including its header: some hundred values are in use, and 338
/// fit.
pub const ROOM: usize = 2048;

/// Value numbers of `stall_v` and of `breakaway_v`.
const STALL_EFFORT: Key = key(Limits::ABOUT, "stall_effort");
const BREAKAWAY_EFFORT: Key = key(Limits::ABOUT, "breakaway_effort");

const MAGIC: [u8; 4] = *b"STIC";
pub(super) const HEADER: usize = 20;

/// Bytes of an entry: a value's number and its bits.
const ENTRY: usize = 6;

/// The reason why there are no valid parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DecodeError {
    /// The flash is erased: nothing has been written.
    Blank,
    /// The bytes are something other than a record, or a part of the record is missing.
    NotParameters,
    /// The record has this format version, which is unknown.
    Version(u32),
    /// The checksum is wrong: a bit has changed, or the record was not written to its end.
    Checksum,
    /// The checksum is right, but the body is not one of the record's format.
    Malformed,
    /// The record has a value that is unknown to this version.
    Unknown(Key),
    /// The record lacks a required value.
    Missing(Key),
    /// A value of the record is invalid.
    Value(InvalidValue),
}

impl Parameters {
    /// Writes a record, and returns the part of `buffer` that the record fills; none if the buffer
    /// is too small, which [`ROOM`] never is.
    #[inline(never)]
    pub fn encode<'a>(&self, sequence: u32, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        let length = write(self, buffer.get_mut(HEADER..)?)?;
        let record = buffer.get_mut(..HEADER + length)?;
        let (header, body) = record.split_at_mut_checked(HEADER)?;
        let fields = [FORMAT_VERSION, sequence, u32::try_from(length).ok()?];
        for (bytes, field) in header.chunks_exact_mut(4).skip(1).zip(fields) {
            bytes.copy_from_slice(&field.to_le_bytes());
        }
        let sum = checksum(header, body);
        header.first_chunk_mut::<4>()?.copy_from_slice(&MAGIC);
        header.last_chunk_mut::<4>()?.copy_from_slice(&sum.to_le_bytes());
        Some(record)
    }

    /// Reads a record at the start of `bytes`, and returns its parameters and its sequence number.
    ///
    /// # Errors
    /// Returns the reason why the record is invalid.
    pub fn decode(bytes: &[u8]) -> Result<(Self, u32), DecodeError> {
        let (header, rest) = bytes.split_at_checked(HEADER).ok_or(DecodeError::NotParameters)?;
        if header.iter().all(|&byte| byte == 0xFF) {
            return Err(DecodeError::Blank);
        }
        if !header.starts_with(&MAGIC) {
            return Err(DecodeError::NotParameters);
        }
        let [version, sequence, length, sum] = [4, 8, 12, 16].map(|at| word(header, at));
        if version != FORMAT_VERSION {
            return Err(DecodeError::Version(version));
        }
        let body = rest.get(..length as usize).ok_or(DecodeError::NotParameters)?;
        if checksum(header, body) != sum {
            return Err(DecodeError::Checksum);
        }
        let mut parameters = Self::EXAMPLE;
        parameters.read(body)?;
        parameters.check().map_err(DecodeError::Value)?;
        Ok((parameters, sequence))
    }

    /// Sets all values from a whole body. A value that the body lacks becomes its default, or is
    /// derived.
    #[inline(never)]
    fn read(&mut self, body: &[u8]) -> Result<(), DecodeError> {
        take(self, body)?;
        // If only the stall threshold is given, the breakaway effort is half of it.
        let breakaway = if has(body, BREAKAWAY_EFFORT) {
            self.limits.breakaway_effort
        } else if has(body, STALL_EFFORT) {
            0.5 * self.limits.stall_effort
        } else {
            0.0
        };
        self.limits = Limits::derived(&self.controller, &self.device, breakaway);
        self.jog = JogBounds::derived(&self.controller, &self.device, breakaway);
        self.current = CurrentSensor::derived(self.current.full_scale, [0.0, 0.0]);
        // The body is applied again after each derivation: it may set some of the derived limits,
        // and some of the values that follow from them.
        take(self, body)?;
        self.profile = ProfileLimits::derived(&self.controller, self.limits.overspeed, 0.0);
        take(self, body)?;
        read_back(self, body)?;
        self.each(&mut |key, absent| match absent {
            Absent::Needed if !has(body, key) => Err(DecodeError::Missing(key)),
            _ => Ok(()),
        })
    }

    /// Sets some values from their entries, and leaves the others as they are in `before`. A law
    /// that only moves to another place keeps its gains, and a law without an entry keeps its
    /// place. A new law needs all of its gains. Nothing is validated yet.
    ///
    /// # Errors
    /// Returns the reason why an entry is wrong; some values may have changed then.
    #[inline(never)]
    pub fn change(&mut self, entries: &[u8], before: &Self) -> Result<(), DecodeError> {
        take(self, entries)?;
        // Setting a new law in a place resets it to the gains of the example, and removes the laws
        // behind it.
        let _ = before.each(&mut |key, _| -> Result<(), ()> {
            if let Some(bits) =
                before.get(key).filter(|_| self.get(key).is_some() && !has(entries, key))
            {
                // This fails only where there is no place before it any more.
                let _ = self.set(key, bits);
            }
            Ok(())
        });
        read_back(self, entries)?;
        self.each(&mut |key, absent| match absent {
            Absent::Needed if before.get(key).is_none() && !has(entries, key) => {
                Err(DecodeError::Missing(key))
            }
            _ => Ok(()),
        })
    }

    /// Returns the newest valid record of two sectors, its sequence number, and the index of its
    /// sector.
    ///
    /// If a record was cut off while it was written, the one before it is returned. If there is
    /// none, the error is that of the first sector that is not blank.
    ///
    /// # Errors
    /// Returns the reason if neither record is valid.
    pub fn newest(sectors: [&[u8]; 2]) -> Result<(Self, u32, usize), DecodeError> {
        let [first, second] = sectors.map(Self::decode);
        Self::newer(first, second)
    }

    /// Returns whether a sector holds something that is no valid record. That may have been the
    /// newest record, so that the one in use is older.
    #[inline(never)]
    pub fn is_damaged(sector: &[u8]) -> bool {
        !matches!(Self::decode(sector), Ok(_) | Err(DecodeError::Blank))
    }

    /// Returns the newer one of two records that were decoded, with its sequence number and its
    /// index.
    pub(crate) fn newer(
        first: Result<(Self, u32), DecodeError>,
        second: Result<(Self, u32), DecodeError>,
    ) -> Result<(Self, u32, usize), DecodeError> {
        match (first, second) {
            (Ok((_, older)), Ok((second, newer))) if newer.wrapping_sub(older) as i32 > 0 => {
                Ok((second, newer, 1))
            }
            (Ok((first, sequence)), _) => Ok((first, sequence, 0)),
            (Err(_), Ok((second, sequence))) => Ok((second, sequence, 1)),
            (Err(DecodeError::Blank), Err(error)) | (Err(error), Err(_)) => Err(error),
        }
    }
}

/// Writes the entries of some values, and returns the number of bytes written; none if there is no
/// room.
pub fn write(values: &impl Values, buffer: &mut [u8]) -> Option<usize> {
    let mut length = 0;
    let written = values.each(&mut |key, _| {
        let bits = values.get(key).unwrap_or_default();
        put(buffer, &mut length, key, bits).ok_or(())
    });
    written.is_ok().then_some(length)
}

/// Writes one entry at `length`, which grows by the entry's bytes; returns none if there is no
/// room.
pub fn put(buffer: &mut [u8], length: &mut usize, key: Key, bits: u32) -> Option<()> {
    let entry = buffer.get_mut(*length..)?.first_chunk_mut::<ENTRY>()?;
    let ([a, b], [c, d, e, f]) = (key.0.to_le_bytes(), bits.to_le_bytes());
    *entry = [a, b, c, d, e, f];
    *length += ENTRY;
    Some(())
}

/// Rejects entries of which one has undone another: two different entries of one value, or an entry
/// before that of the law or the corner that it belongs to.
fn read_back(values: &impl Values, body: &[u8]) -> Result<(), DecodeError> {
    let (entries, _) = body.as_chunks::<ENTRY>();
    let is_kept = |&[a, b, c, d, e, f]: &[u8; ENTRY]| {
        values.get(Key(u16::from_le_bytes([a, b]))) == Some(u32::from_le_bytes([c, d, e, f]))
    };
    if entries.iter().all(is_kept) { Ok(()) } else { Err(DecodeError::Malformed) }
}

fn take(values: &mut impl Values, body: &[u8]) -> Result<(), DecodeError> {
    let (entries, []) = body.as_chunks::<ENTRY>() else { return Err(DecodeError::Malformed) };
    for &[a, b, c, d, e, f] in entries {
        let key = Key(u16::from_le_bytes([a, b]));
        match values.set(key, u32::from_le_bytes([c, d, e, f])) {
            Ok(true) => {}
            Ok(false) => return Err(DecodeError::Unknown(key)),
            Err(_) => return Err(DecodeError::Malformed),
        }
    }
    Ok(())
}

fn has(body: &[u8], key: Key) -> bool {
    let (entries, _) = body.as_chunks::<ENTRY>();
    entries.iter().any(|entry| entry.starts_with(&key.0.to_le_bytes()))
}

pub(super) fn checksum(header: &[u8], body: &[u8]) -> u32 {
    crate::parameters::checksum::checksum(&[header.get(4..16).unwrap_or_default(), body])
}

fn word(header: &[u8], at: usize) -> u32 {
    let bytes = header.get(at..).and_then(|rest| rest.first_chunk::<4>());
    bytes.map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
