//! A client of the command link.
//!
//! ```
//! use host_sim::device::client::Client;
//! use host_sim::device::simulated::SimulatedDevice;
//! use host_sim::device::wire::SimulatedWire;
//! use host_sim::experiment::{Document, Experiment};
//!
//! # fn main() -> Result<(), host_sim::Error> {
//! let document = Document::open("step-response")?;
//! let plan = Experiment::plan(&document, &["srnf".into()], &[])?.runs.remove(0);
//! let mut client = Client::connect(SimulatedWire::new(SimulatedDevice::new(&plan)?))?;
//! client.arm()?;
//! client.step_to(5.0)?;
//! client.pass(std::time::Duration::from_secs(2))?;
//! let status = client.status()?;
//! assert!((f64::from(status.position) * f64::from(status.resolution) - 5.0).abs() < 0.01);
//! client.stop()?;
//! # Ok(())
//! # }
//! ```

use std::collections::VecDeque;
use std::time::Duration;

use stiction::link::{
    Announced, CHUNK, Deframer, Identity, Kind, Message, Numbered, PROTOCOL, Refused, Reply, Request, Sample,
    StateCode, Status, Told, encode,
};
use stiction::parameters::{ROOM, record};
use stiction::servo::Levels;
use stiction::value::Key;
use stiction::{Motion, Parameters};

use super::wire::{SIMULATED, Wire};
use super::words;
use crate::error::Error;

/// A device answers within milliseconds, but for a save (docs/link.md), for which three times its longest is waited.
const PATIENCE: Duration = Duration::from_millis(200);
const PATIENCE_TO_SAVE: Duration = Duration::from_secs(6);

/// How often a request is said before the device counts as silent.
const TRIES: u32 = 3;

/// How often a client that waits says that it is there: five times within the default link timeout.
const SIGN_OF_LIFE: Duration = Duration::from_millis(100);

/// A session with a device.
#[derive(Debug)]
pub struct Client<W> {
    wire: W,
    deframer: Deframer,
    number: u16,
    identity: Option<Identity>,
    samples: VecDeque<Sample>,
    /// Number of the next sample.
    expected: Option<u32>,
    /// Another subscription was asked for, and its answer has not come yet.
    subscribing: bool,
    lost: u64,
    /// Of what came since the last request: that a device is silent and that it talks otherwise are two things.
    heard: Heard,
}

#[derive(Debug, Default)]
struct Heard {
    /// The first bytes.
    begin: Vec<u8>,
    /// A message that was whole.
    whole: bool,
}

/// So many bytes of what is not understood are shown.
const SHOWN: usize = 24;

impl<W: Wire> Client<W> {
    /// Says hello.
    ///
    /// # Errors
    /// If nobody answers, or one that speaks another version of the protocol.
    pub fn connect(wire: W) -> Result<Self, Error> {
        let mut client = Self {
            wire,
            deframer: Deframer::default(),
            number: 0,
            identity: None,
            samples: VecDeque::new(),
            expected: None,
            subscribing: false,
            lost: 0,
            heard: Heard::default(),
        };
        // What was left of an earlier session ends here.
        client.wire.send(&[0])?;
        let session = std::time::SystemTime::now()
            .duration_since(std::time::UNIX_EPOCH)
            .map_or(0, |since| since.subsec_nanos() ^ since.as_secs() as u32 ^ std::process::id());
        match client.ask(Request::Hello { protocol: PROTOCOL, session })? {
            Reply::Hello(identity) if identity.protocol == PROTOCOL => {
                client.identity = Some(identity);
                Ok(client)
            }
            Reply::Hello(Identity { protocol, version, .. }) => {
                let name = client.wire.name();
                Err(Error::Device(format!(
                    "{name} runs firmware {version} with version {protocol} of the link, and this program speaks \
                     version {PROTOCOL}; flash the firmware that belongs to it (`cargo xtask flash`, docs/link.md)"
                )))
            }
            _ => Err(client.unexpected()),
        }
    }

    /// The device, as it has introduced itself.
    pub const fn identity(&self) -> Option<&Identity> {
        self.identity.as_ref()
    }

    /// What everything that is shown of the device has to begin with; nothing for a board.
    pub fn warning(&self) -> Option<&'static str> {
        let simulated = || self.identity.as_ref().is_some_and(|identity| identity.kind == Kind::Simulated);
        // One at the other end of a port says so itself.
        self.wire.warning().or_else(|| simulated().then_some(SIMULATED))
    }

    /// The wire.
    pub const fn wire(&mut self) -> &mut W {
        &mut self.wire
    }

    /// Ends the session: the wire.
    pub fn end(self) -> W {
        self.wire
    }

    /// How things stand.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn status(&mut self) -> Result<Status, Error> {
        match self.ask(Request::Status)? {
            Reply::Status(status) => Ok(status),
            _ => Err(self.unexpected()),
        }
    }

    /// The faults that the device remembers, the oldest first.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn faults(&mut self) -> Result<Vec<Told>, Error> {
        let mut faults = Vec::new();
        for index in 0..stiction::fault::HISTORY as u8 {
            match self.talk(Request::Fault { index })? {
                Reply::Fault(told) => faults.push(told),
                Reply::Refused(Refused::NoSuch) => break,
                Reply::Refused(refused) => return Err(self.refused("faults", &refused)),
                _ => return Err(self.unexpected()),
            }
        }
        Ok(faults)
    }

    /// Clears the latched fault.
    ///
    /// # Errors
    /// If it cannot be cleared.
    pub fn clear(&mut self) -> Result<(), Error> {
        self.done("faults --clear", Request::Clear)
    }

    /// Closes the loop where the joint is. From now on the device wants to hear from the client.
    ///
    /// # Errors
    /// Says why it was refused.
    pub fn arm(&mut self) -> Result<(), Error> {
        self.done("arm", Request::Arm)
    }

    /// Output off.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.done("stop", Request::Stop)
    }

    /// The joint stops where it is, with the loop closed.
    ///
    /// # Errors
    /// Says why it was refused.
    pub fn hold(&mut self) -> Result<(), Error> {
        self.done("move", Request::Move(Motion::Hold))
    }

    /// A step to a position (deg) in the zero that arming has set.
    ///
    /// # Errors
    /// Says why it was refused.
    pub fn step_to(&mut self, deg: f64) -> Result<(), Error> {
        let motion = self.step(deg)?;
        self.move_along(motion)
    }

    /// What a step to a position (deg) is in counts, for [`move_along`](Self::move_along).
    ///
    /// # Errors
    /// If there is no such position.
    pub fn step(&mut self, deg: f64) -> Result<Motion, Error> {
        let resolution = f64::from(self.status()?.resolution);
        let counts = deg / resolution;
        // 2^30 counts, as for steps of a machine's file.
        if !counts.is_finite() || counts.abs() > f64::from(1 << 30) {
            return Err(Error::Input(format!("move {deg}: allowed is a position within 2^30 counts")));
        }
        Ok(Motion::Step(crate::experiment::position(counts)))
    }

    /// A motion in the zero that arming has set.
    ///
    /// # Errors
    /// Says why it was refused.
    pub fn move_along(&mut self, motion: Motion) -> Result<(), Error> {
        self.done("move", Request::Move(motion))
    }

    /// Arms, and begins a ramp of the effort that rises by `rate` (V/s) and is held for `hold` (s); it ends by itself, and
    /// [`levels`](Self::levels) says what it has found. The device wants to hear from the client meanwhile.
    ///
    /// # Errors
    /// Says why it was refused.
    pub fn identify(&mut self, rate: f32, hold: f32) -> Result<(), Error> {
        self.done("identify", Request::Identify { rate, hold })
    }

    /// What the last ramp has found, once it is over.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn levels(&mut self) -> Result<Option<Levels>, Error> {
        match self.ask(Request::ReadLevels)? {
            Reply::Levels(levels) => Ok(levels),
            _ => Err(self.unexpected()),
        }
    }

    /// Other values for some of the parameters, validated by the device as a whole.
    ///
    /// # Errors
    /// Says why it was refused; nothing is taken then.
    pub fn change(&mut self, values: &[(Key, u32)]) -> Result<(), Error> {
        let (mut room, mut length) = ([0; CHUNK], 0);
        // Which laws there are comes before their gains, as in a record.
        let mut values = values.to_vec();
        values.sort_unstable_by_key(|(key, _)| *key);
        for (key, bits) in values {
            let put = record::put(&mut room, &mut length, key, bits);
            put.ok_or_else(|| Error::Input("params: too many values for one change".into()))?;
        }
        let entries = room.iter().copied().take(length).collect();
        self.done("params", Request::Change { entries })
    }

    /// The signals that the device announces, in the order of their places.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn signals(&mut self) -> Result<Vec<Announced>, Error> {
        let mut all = Vec::new();
        for index in 0..=u8::MAX {
            match self.talk(Request::Signal { index })? {
                Reply::Signal(signal) => all.push(signal),
                Reply::Refused(Refused::NoSuch) => break,
                Reply::Refused(refused) => return Err(self.refused("log", &refused)),
                _ => return Err(self.unexpected()),
            }
        }
        Ok(all)
    }

    /// The parameters in use.
    ///
    /// # Errors
    /// If there are none.
    pub fn parameters(&mut self) -> Result<Parameters, Error> {
        let mut record: Vec<u8> = Vec::new();
        loop {
            let offset = record.len() as u16;
            let Reply::Parameters { length, offset: at, bytes } =
                self.ask(Request::ReadParameters { offset })?
            else {
                return Err(self.unexpected());
            };
            if at != offset || bytes.is_empty() {
                return Err(self.unexpected());
            }
            record.extend_from_slice(&bytes);
            if record.len() >= usize::from(length) {
                break;
            }
        }
        let decoded = Parameters::decode(&record);
        decoded.map(|(parameters, _)| parameters).map_err(|_| self.unexpected())
    }

    /// Other parameters, validated by the device as a whole before any is taken; see [`save`](Self::save).
    ///
    /// # Errors
    /// Says why they were refused; the old ones are in use then.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let mut room = [0; ROOM];
        let record = parameters.encode(0, &mut room).unwrap_or_default();
        for (i, piece) in record.chunks(CHUNK).enumerate() {
            let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
            self.done("params push", Request::WriteParameters { offset, bytes })?;
        }
        self.done("params push", Request::TakeParameters { length: record.len() as u16 })
    }

    /// Keeps the parameters in use across a reset. Takes seconds on a board.
    ///
    /// # Errors
    /// While armed, or if the flash fails.
    pub fn save(&mut self) -> Result<(), Error> {
        self.done("params save", Request::Save)
    }

    /// Asks for signals (a sum of 1 << place) of every so many ticks; 0 ends it.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn subscribe(&mut self, signals: u64, every: u16) -> Result<(), Error> {
        self.subscribing = true;
        self.done("log", Request::Subscribe { signals, every })
    }

    /// The next sample, if one comes within so long.
    ///
    /// # Errors
    /// If the wire is gone.
    pub fn sample(&mut self, at_most: Duration) -> Result<Option<Sample>, Error> {
        if self.samples.is_empty() {
            let bytes = self.wire.receive(at_most)?;
            self.take(&bytes);
        }
        Ok(self.samples.pop_front())
    }

    /// The next sample of those that have come already.
    pub fn kept(&mut self) -> Option<Sample> {
        self.samples.pop_front()
    }

    /// Samples that did not arrive, as far as later ones have shown.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Lets time pass without falling silent; samples are kept.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn pass(&mut self, time: Duration) -> Result<Status, Error> {
        self.pass_while(time, |_| true)
    }

    /// The same, but no longer than the device is armed.
    ///
    /// # Errors
    /// If the device does not answer.
    pub fn pass_armed(&mut self, time: Duration) -> Result<Status, Error> {
        self.pass_while(time, |status| status.state == StateCode::Armed)
    }

    fn pass_while(&mut self, time: Duration, go_on: impl Fn(&Status) -> bool) -> Result<Status, Error> {
        let mut status = self.status()?;
        let ticks = |status: &Status| f64::from(status.clock) * f64::from(status.sample_time);
        let (begin, started) = (ticks(&status), self.wire.now());
        loop {
            let on_the_wire = self.wire.now() - started;
            // The device's time, not the wire's: a simulated one has its own. One without parameters has none, and one
            // whose clock does not run is not waited for for ever.
            let passed = if status.sample_time > 0.0 && on_the_wire < 2 * time + PATIENCE {
                ticks(&status) - begin
            } else {
                on_the_wire.as_secs_f64()
            };
            let left = time.as_secs_f64() - passed;
            if left <= 0.0 || !go_on(&status) {
                return Ok(status);
            }
            let bytes = self.wire.receive(SIGN_OF_LIFE.min(Duration::from_secs_f64(left.max(0.001))))?;
            self.take(&bytes);
            status = self.status()?;
        }
    }

    fn done(&mut self, what: &str, request: Request) -> Result<(), Error> {
        match self.talk(request)? {
            Reply::Done => Ok(()),
            Reply::Refused(refused) => Err(self.refused(what, &refused)),
            _ => Err(self.unexpected()),
        }
    }

    fn ask(&mut self, request: Request) -> Result<Reply, Error> {
        match self.talk(request)? {
            Reply::Refused(refused) => Err(self.refused("device", &refused)),
            reply => Ok(reply),
        }
    }

    /// Says a request until it is answered. The device does not do it twice, since its number stays the same.
    fn talk(&mut self, request: Request) -> Result<Reply, Error> {
        self.number = self.number.wrapping_add(1);
        let patience = if request == Request::Save { PATIENCE_TO_SAVE } else { PATIENCE };
        let frame = encode(&Numbered { number: self.number, content: request });
        let frame = frame.ok_or_else(|| Error::Device("the request is too long for a frame".into()))?;
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
                "{name} does not answer: is it powered, is it this firmware, and is it the right port? (docs/link.md)"
            ),
            (false, true) => {
                format!("{name} sends, but does not answer: its answers are lost (docs/link.md)")
            }
            (false, false) => format!(
                "{name} sends what is no message of the link (\"{}\"): it has other firmware, or another baud rate \
                 (docs/link.md)",
                begin.escape_ascii()
            ),
        }))
    }

    /// Sorts what came: samples are kept, and the answer to the last request is returned.
    fn take(&mut self, bytes: &[u8]) -> Option<Reply> {
        let mut reply = None;
        let room = SHOWN - self.heard.begin.len();
        self.heard.begin.extend(bytes.iter().take(room));
        for &byte in bytes {
            let Some(message) = self.deframer.push(byte) else { continue };
            self.heard.whole = true;
            match postcard::from_bytes(message) {
                Ok(Message::Reply(Numbered { number, content })) if number == self.number => {
                    // What came before belongs to the last subscription, which has counted otherwise.
                    if std::mem::take(&mut self.subscribing) {
                        self.expected = None;
                        self.samples.clear();
                    }
                    reply = Some(content);
                }
                Ok(Message::Sample(sample)) => {
                    let expected = self.expected.unwrap_or(sample.number);
                    self.lost += u64::from(sample.number.wrapping_sub(expected));
                    self.expected = Some(sample.number.wrapping_add(1));
                    self.samples.push_back(sample);
                }
                // An answer that came late, or something that is not of this protocol.
                Ok(Message::Reply(_)) | Err(_) => {}
            }
        }
        reply
    }

    fn refused(&self, what: &str, refused: &Refused) -> Error {
        let (name, why, excuse) = (self.wire.name(), words::refused(refused), self.wire.excuse(refused));
        let more = if why.contains("docs/") { "" } else { " (docs/link.md)" };
        Error::Refused(format!("{what}: {name} refuses: {why}{excuse}{more}"))
    }

    fn unexpected(&self) -> Error {
        Error::Device(format!(
            "{} gives an answer that does not fit the question (docs/link.md)",
            self.wire.name()
        ))
    }
}
