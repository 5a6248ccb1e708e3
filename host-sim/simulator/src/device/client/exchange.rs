//! Exchange of one request and its answer; samples that arrive meanwhile are kept.

use std::time::Duration;

use stiction::link::{Message, NumberedMessage, Reply, Request, RequestRefusal, encode_request};

use super::Client;
use crate::device::wire::Wire;
use crate::device::words;
use files::error::Error;

/// Timeout for an answer. A device answers within milliseconds, except to a save.
pub(super) const PATIENCE: Duration = Duration::from_millis(200);

/// Timeout for an answer after an erase of the flash: three times the longest erase
/// (docs/reference/link.md).
const PATIENCE_TO_SAVE: Duration = Duration::from_secs(6);

/// Number of times that a request is sent before the device counts as silent.
const TRIES: u32 = 3;

/// Number of unknown bytes that an error shows.
const SHOWN: usize = 24;

/// Bytes received since the last request. A silent device needs other advice than one that sends
/// unknown bytes.
#[derive(Debug, Default)]
pub(super) struct Heard {
    /// The first bytes, at most [`SHOWN`].
    begin: Vec<u8>,
    /// Whether a whole message was among them.
    whole: bool,
}

impl<W: Wire> Client<W> {
    /// Makes a request whose answer has no content; a refusal is an error.
    pub(super) fn done(&mut self, what: &str, request: Request) -> Result<(), Error> {
        match self.talk(request)? {
            Reply::Done => Ok(()),
            Reply::Refused(refused) => Err(self.refused(what, &refused)),
            _ => Err(self.unexpected()),
        }
    }

    /// Makes a request and returns its answer; a refusal is an error.
    pub(super) fn ask(&mut self, request: Request) -> Result<Reply, Error> {
        match self.talk(request)? {
            Reply::Refused(refused) => Err(self.refused("device", &refused)),
            reply => Ok(reply),
        }
    }

    /// Sends a request until it is answered. Its number stays the same, so that the device executes
    /// it once.
    pub(super) fn talk(&mut self, request: Request) -> Result<Reply, Error> {
        self.begin_late(&request)?;
        self.number = self.number.wrapping_add(1);
        let patience = match request {
            Request::Save | Request::SetBrownOut => PATIENCE_TO_SAVE,
            _ => PATIENCE,
        };
        let frame = encode_request(self.session, self.number, request);
        let frame =
            frame.ok_or_else(|| Error::Device("the request is too long for a frame".into()))?;
        self.heard = Heard::default();
        for _ in 0..TRIES {
            self.wire.send(&frame)?;
            let mut left = patience;
            while !left.is_zero() {
                let slice = left.min(Duration::from_millis(20));
                let started = self.wire.now();
                let bytes = self.wire.receive(slice)?;
                let took = self.wire.now() - started;
                left = left.saturating_sub(took.max(Duration::from_micros(100)));
                if bytes.is_empty() {
                    left = left.saturating_sub(slice.saturating_sub(took));
                }
                if let Some(reply) = self.take(&bytes) {
                    return Ok(reply);
                }
            }
        }
        let name = self.wire.name();
        let Heard { begin, whole } = &self.heard;
        Err(Error::Device(match (begin.is_empty(), whole) {
            (true, _) => format!(
                "{name} does not answer: check its power, its firmware and the port (docs/reference/link.md)"
            ),
            (false, true) => {
                format!(
                    "{name} sends, but does not answer: reduce the subscription, and check the \
                     wires for noise (docs/reference/link.md)"
                )
            }
            (false, false) => format!(
                "{name} sends bytes that are no message of the link (\"{}\"): it has other \
                 firmware, or another baud rate (docs/reference/link.md)",
                begin.escape_ascii()
            ),
        }))
    }

    /// Decodes received bytes: stores samples, and returns the answer to the last request.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Option<Reply> {
        let mut reply = None;
        let room = SHOWN - self.heard.begin.len();
        self.heard.begin.extend(bytes.iter().take(room));
        for &byte in bytes {
            let Some(message) = self.deframer.push(byte) else { continue };
            self.heard.whole = true;
            match postcard::from_bytes(message) {
                Ok(Message::Reply(NumberedMessage { number, content }))
                    if number == self.number =>
                {
                    self.subscription.answered();
                    reply = Some(content);
                }
                Ok(Message::Sample(sample)) => self.subscription.push(sample),
                // A late answer, or bytes of another protocol.
                Ok(Message::Reply(_)) | Err(_) => {}
            }
        }
        reply
    }

    /// Returns the error with the reason of a refusal.
    pub(super) fn refused(&self, what: &str, refused: &RequestRefusal) -> Error {
        let (name, why, excuse) =
            (self.wire.name(), words::refused(refused), self.wire.excuse(refused));
        let more = if why.contains("docs/") { "" } else { " (docs/reference/link.md)" };
        Error::Refused(format!("{what}: {name} refuses: {why}{excuse}{more}"))
    }

    /// Returns the error for an answer that does not fit its request.
    pub(super) fn unexpected(&self) -> Error {
        Error::Device(format!(
            "{} sends an answer that does not fit the request (docs/reference/link.md)",
            self.wire.name()
        ))
    }
}
