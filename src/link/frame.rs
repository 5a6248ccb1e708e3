//! The frames of the link, which delimit the messages and detect damaged ones.
//!
//! ```text
//! COBS( message | CRC-32 (ISO-HDLC, little endian) ) 0
//! ```
//!
//! COBS (Cheshire and Baker 1999) leaves no zero byte in a frame, so that a zero always is its end:
//! whatever was lost before, a new frame begins after the next zero. Guarantees: total, bounded, no
//! panic. Garbage costs at most the frames that it touches. Of the frames that were changed on the
//! way, one in 2^32 passes as valid. A frame that is too long is discarded up to its end. Does
//! badly: bytes before the first zero spoil the first frame, so a client begins with a zero.

use cobs::{DecodeResult, DecoderState};
use heapless::Vec;
use serde::Serialize;

use crate::parameters::checksum::checksum;

/// The longest message, bytes.
pub const MAX_MESSAGE: usize = 240;

/// The longest frame: message, checksum, one byte of overhead in 254, and the zero.
pub const MAX_FRAME: usize = MAX_MESSAGE + CHECKSUM + 2;

const CHECKSUM: usize = 4;

/// The bytes of a frame.
pub type Frame = Vec<u8, MAX_FRAME>;

/// Encodes a message as a frame; returns none if the message is too long.
///
/// ```
/// use stiction::link::{Deframer, encode};
/// let frame = encode(&(7u8, 0u16)).unwrap();
/// let mut deframer = Deframer::default();
/// let message = |&byte: &u8| deframer.push(byte).map(<[u8]>::to_vec);
/// let messages: Vec<_> = frame.iter().filter_map(message).collect();
/// assert_eq!(messages, [[7, 0]]); // as postcard has them
/// ```
pub fn encode(message: &impl Serialize) -> Option<Frame> {
    let mut plain = [0; MAX_MESSAGE + CHECKSUM];
    let length = postcard::to_slice(message, plain.get_mut(..MAX_MESSAGE)?).ok()?.len();
    let sum = checksum(&[plain.get(..length)?]).to_le_bytes();
    plain.get_mut(length..length + CHECKSUM)?.copy_from_slice(&sum);
    let mut frame = Frame::new();
    frame.resize(MAX_FRAME, 0).ok()?;
    let stuffed = cobs::try_encode(plain.get(..length + CHECKSUM)?, &mut frame).ok()?;
    frame.truncate(stuffed);
    frame.push(0).ok()?;
    Some(frame)
}

/// A deframer, which finds the frames in a stream of bytes.
#[derive(Debug)]
pub struct Deframer {
    state: DecoderState,
    bytes: Vec<u8, { MAX_MESSAGE + CHECKSUM }>,
    /// Whether the bytes are a message that has been returned, so that the next byte begins another
    /// one.
    complete: bool,
    /// Whether the frame is broken, so that all bytes until the next zero are ignored.
    broken: bool,
    /// Number of frames that were damaged, cut off or too long.
    bad: u32,
}

impl Default for Deframer {
    fn default() -> Self {
        Self::new()
    }
}

impl Deframer {
    /// Makes a deframer before its first byte.
    pub const fn new() -> Self {
        Self {
            state: DecoderState::Idle,
            bytes: Vec::new(),
            complete: false,
            broken: false,
            bad: 0,
        }
    }

    /// Decodes a byte, and returns the message that it completes, if any.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if self.complete {
            self.begin();
        }
        if self.broken {
            if byte == 0 {
                self.begin();
            }
            return None;
        }
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataContinue(decoded)) => {
                if self.bytes.push(decoded).is_err() {
                    self.bad = self.bad.saturating_add(1);
                    self.broken = true;
                }
                None
            }
            Ok(DecodeResult::DataComplete) => self.complete(),
            // The frame ended too early, at the zero: the next byte begins a frame.
            Err(_) => {
                self.bad = self.bad.saturating_add(1);
                self.begin();
                None
            }
        }
    }

    /// Returns the number of frames that were damaged, cut off or too long.
    pub const fn bad(&self) -> u32 {
        self.bad
    }

    fn begin(&mut self) {
        self.state = DecoderState::Idle;
        self.bytes.clear();
        self.complete = false;
        self.broken = false;
    }

    fn complete(&mut self) -> Option<&[u8]> {
        self.complete = true;
        match self.bytes.split_last_chunk::<CHECKSUM>() {
            Some((message, sum)) if checksum(&[message]) == u32::from_le_bytes(*sum) => {
                Some(message)
            }
            _ => {
                self.bad = self.bad.saturating_add(1);
                None
            }
        }
    }
}
