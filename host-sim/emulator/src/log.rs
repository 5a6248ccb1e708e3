//! The firmware's log: drained from its RTT buffer as a probe does it, and decoded at once.
//!
//! The first up-channel's descriptor follows the identifier (16 bytes) and two counts (4 bytes
//! each):
//!
//! ```text
//! offset   24    28      32    36     40
//!          name  buffer  size  write  read      the target moves `write`, the probe moves `read`
//! ```

use std::sync::Arc;

use rigless::emulator::{Error as HostError, Host};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::image::FirmwareImage;

const IDENTIFIER: &[u8] = b"SEGGER RTT";
const BUFFER: u64 = 28;
const SIZE: u64 = 32;
const WRITE: u64 = 36;
const READ: u64 = 40;
/// Largest valid size of a buffer, bytes: the RAM of the microcontroller.
const LARGEST: u64 = 192 << 10;

/// One line of the firmware's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Virtual time at which it was read, ns since power-on.
    pub read_at_ns: u64,
    /// `error`, `warn`, `info`, `debug`, `trace`, or empty.
    pub level: &'static str,
    /// Text of the line.
    pub text: String,
}

impl std::fmt::Display for LogLine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seconds = self.read_at_ns as f64 * 1e-9;
        write!(f, "{seconds:9.3} {:5} {}", self.level, self.text)
    }
}

/// Callback that gets each line as soon as it is there, with the label of its run.
pub type Listener = Arc<dyn Fn(&str, &LogLine) + Send + Sync>;

/// A log that is being read.
pub struct FirmwareLog {
    image: Arc<FirmwareImage>,
    label: String,
    listener: Option<Listener>,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
    /// All lines so far.
    pub lines: Vec<LogLine>,
    /// Frames that could not be decoded.
    pub malformed: u32,
}

impl std::fmt::Debug for FirmwareLog {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("lines", &self.lines).finish_non_exhaustive()
    }
}

impl FirmwareLog {
    /// Creates the log of an image that is about to start.
    pub fn new(image: Arc<FirmwareImage>, label: &str, listener: Option<Listener>) -> Self {
        Self {
            image,
            label: label.into(),
            listener,
            rest: Vec::new(),
            lines: Vec::new(),
            malformed: 0,
        }
    }

    /// Reads what the firmware has written since the last call, and moves the read position in the
    /// target.
    ///
    /// # Errors
    /// Returns an error if the emulator refuses to read its own memory.
    pub fn drain(&mut self, host: &mut dyn Host, now: VirtualNanos) -> Result<(), HostError> {
        let block = self.image.rtt;
        for (offset, expected) in IDENTIFIER.iter().enumerate() {
            // Before its start-up code has run, the firmware has no log.
            if host.read(block + offset as u64, Width::W8)? != u64::from(*expected) {
                return Ok(());
            }
        }
        let mut word = |offset: u64| host.read(block + offset, Width::W32);
        let (buffer, size, write, mut read) =
            (word(BUFFER)?, word(SIZE)?, word(WRITE)?, word(READ)?);
        if size == 0 || size > LARGEST || write >= size || read >= size || write == read {
            return Ok(());
        }
        while read != write {
            self.rest.push(host.read(buffer + read, Width::W8)? as u8);
            read = (read + 1) % size;
        }
        host.write(block + READ, Width::W32, read)?;
        self.decode(now);
        Ok(())
    }

    /// Decodes the complete frames: each ends in a zero byte.
    fn decode(&mut self, now: VirtualNanos) {
        let Some(end) = self.rest.iter().rposition(|byte| *byte == 0) else { return };
        let rest = self.rest.split_off(end + 1);
        let complete = std::mem::replace(&mut self.rest, rest);
        let mut decoder = self.image.formats.new_stream_decoder();
        decoder.received(&complete);
        loop {
            match decoder.decode() {
                Ok(frame) => {
                    let line = LogLine {
                        read_at_ns: now.0,
                        level: frame.level().map_or("", |level| level.as_str()),
                        text: frame.display_message().to_string(),
                    };
                    if let Some(listener) = &self.listener {
                        listener(&self.label, &line);
                    }
                    self.lines.push(line);
                }
                Err(defmt_decoder::DecodeError::UnexpectedEof) => return,
                Err(defmt_decoder::DecodeError::Malformed) => self.malformed += 1,
            }
        }
    }

    /// Returns the last lines, indented, for an error message.
    pub fn tail(&self) -> String {
        const LINES: usize = 6;
        let from = self.lines.len().saturating_sub(LINES);
        match self.lines.get(from..) {
            Some([]) | None => "it has logged nothing".into(),
            Some(lines) => {
                let lines: Vec<String> = lines.iter().map(|line| format!("\n  {line}")).collect();
                format!("its last words were:{}", lines.concat())
            }
        }
    }
}
