//! Text of a log as UTF-8. UTF-16 with a byte order mark is decoded. A text that does not start as
//! UTF-8 is decoded as Windows-1252, in which spreadsheets write `[°]`. Any other text is passed
//! on.

use std::io::{self, Read};

use encoding_rs::{Decoder, Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Number of bytes decoded at a time.
const CHUNK: usize = 1 << 14;

/// Error for a text whose every other byte is 0 and that has no byte order mark.
pub const NO_MARK: &str = "every other byte of the file is zero, as in UTF-16 without a byte order \
                           mark; save it as UTF-8, or as UTF-16 with the mark";

/// Returns whether a text seems to be UTF-16 without a byte order mark.
pub fn has_no_mark(begin: &[u8]) -> bool {
    let looked = &begin[..begin.len().min(64) & !1];
    let zeros = |from: usize| looked.iter().skip(from).step_by(2).all(|byte| *byte == 0);
    looked.len() >= 4 && (zeros(0) || zeros(1))
}

/// Returns the text of a file as UTF-8.
///
/// # Errors
/// Returns an error if its first bytes cannot be read.
pub fn decoded<R: Read>(mut text: R) -> io::Result<Utf8<R>> {
    // Enough for the first line, which names the columns.
    let mut begin = Vec::new();
    (&mut text).take(CHUNK as u64).read_to_end(&mut begin)?;
    let encoding = Encoding::for_bom(&begin).map(|(encoding, _)| encoding);
    let of_mark = encoding.filter(|one| *one == UTF_16LE || *one == UTF_16BE);
    let old = (!is_utf_8(&begin)).then_some(WINDOWS_1252);
    let mut decoder = of_mark.or(old).map(Encoding::new_decoder_with_bom_removal);
    let ready = match &mut decoder {
        Some(decoder) => decode(decoder, &begin, false),
        None => begin,
    };
    Ok(Utf8 { text, decoder, ready, given: 0, has_ended: false })
}

/// Returns whether a text begins as UTF-8; a character that is cut off at its end is accepted.
fn is_utf_8(begin: &[u8]) -> bool {
    std::str::from_utf8(begin).err().is_none_or(|error| error.error_len().is_none())
}

fn decode(decoder: &mut Decoder, bytes: &[u8], is_last: bool) -> Vec<u8> {
    let length = decoder.max_utf8_buffer_length(bytes.len()).unwrap_or(4 * CHUNK);
    let mut decoded = vec![0; length];
    let (_, _, written, _) = decoder.decode_to_utf8(bytes, &mut decoded, is_last);
    decoded.truncate(written);
    decoded
}

/// Reader of a text as UTF-8.
pub struct Utf8<R> {
    text: R,
    decoder: Option<Decoder>,
    /// Decoded bytes, and the number already read.
    ready: Vec<u8>,
    given: usize,
    has_ended: bool,
}

impl<R: Read> Read for Utf8<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            let left = &self.ready[self.given..];
            if !left.is_empty() || into.is_empty() {
                let count = left.len().min(into.len());
                into[..count].copy_from_slice(&left[..count]);
                self.given += count;
                return Ok(count);
            }
            let Some(decoder) = &mut self.decoder else { return self.text.read(into) };
            if self.has_ended {
                return Ok(0);
            }
            let mut bytes = [0; CHUNK];
            let count = self.text.read(&mut bytes)?;
            self.has_ended = count == 0;
            self.ready = decode(decoder, &bytes[..count], self.has_ended);
            self.given = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text is longer than a chunk, and is read in both byte orders.
    #[test]
    fn utf_16_with_its_mark_is_decoded_and_utf_8_is_passed_on() {
        let text = "time [s];Winkel [\u{b0}]\n".to_owned() + &"0,5;1,25\n".repeat(4000);
        let units = || std::iter::once(0xFEFF).chain(text.encode_utf16());
        let read = |bytes: &[u8]| {
            let mut all = String::new();
            decoded(bytes).and_then(|mut utf8| utf8.read_to_string(&mut all)).map(|_| all)
        };
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        for bytes in [&little[..], &big[..], text.as_bytes()] {
            assert_eq!(read(bytes).ok().as_deref(), Some(&*text));
        }
        assert_eq!(read(b"").ok().as_deref(), Some(""));
        assert_eq!(read(b"1").ok().as_deref(), Some("1"));
        // A degree sign of one byte; and UTF-8 whose first chunk ends within a character.
        assert_eq!(read(b"Winkel [\xb0];1\n").ok().as_deref(), Some("Winkel [\u{b0}];1\n"));
        let cut = "a".repeat(CHUNK - 1) + "\u{b0}";
        assert_eq!(read(cut.as_bytes()).ok(), Some(cut));
        // Without the mark, the zeros are detected.
        assert!(has_no_mark(&little[2..]) && has_no_mark(&big[2..]));
        assert!(!has_no_mark(text.as_bytes()) && !has_no_mark(b"") && !has_no_mark(b"1,2"));
    }
}
