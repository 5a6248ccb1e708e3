//! A client of the command link.
//!
//! ```
//! use simulator::device::client::Client;
//! use simulator::device::simulated::SimulatedDevice;
//! use simulator::device::wire::SimulatedWire;
//! use simulator::experiment::{Document, Experiment};
//!
//! # fn main() -> Result<(), files::Error> {
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
//!
//! | file | content |
//! |---|---|
//! | `exchange.rs` | repeats a request until it is answered, and decodes received bytes |
//! | `motion.rs` | arms, moves, stops, and runs a ramp |
//! | `parameters.rs` | reads, writes, changes and saves parameters |
//! | `state.rs` | reads state and faults, and waits |
//! | `telemetry.rs` | subscribes to signals, and keeps and counts their samples |

mod exchange;
mod motion;
mod parameters;
mod state;
mod telemetry;

use std::hash::{BuildHasher as _, RandomState};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use self::motion::{Map, position_of};
use stiction::link::{
    Deframer, DeviceKind, Identity, NO_SESSION, PROTOCOL, Reply, Request, RequestRefusal,
};

use self::exchange::Heard;
use self::telemetry::Subscription;
use super::wire::{SIMULATED, Wire};
use files::error::Error;

/// A session with a device.
#[derive(Debug)]
pub struct Client<W> {
    wire: W,
    deframer: Deframer,
    /// Number of the session, chosen by the device; `NO_SESSION` if another client drives the
    /// motor.
    session: u32,
    /// Number of the last request.
    number: u16,
    identity: Option<Identity>,
    subscription: Subscription,
    heard: Heard,
    /// Flag that Ctrl-C sets.
    interrupt: Option<Arc<AtomicBool>>,
}

impl<W: Wire> Client<W> {
    /// Opens a session with a hello.
    ///
    /// # Errors
    /// Returns an error if no device answers, or if it has another version of the protocol.
    pub fn connect(wire: W) -> Result<Self, Error> {
        let mut client = Self {
            wire,
            deframer: Deframer::default(),
            session: NO_SESSION,
            number: 0,
            identity: None,
            subscription: Subscription::default(),
            heard: Heard::default(),
            interrupt: None,
        };
        // A zero ends a frame that an earlier session may have left unfinished.
        client.wire.send(&[0])?;
        client.begin_session()?;
        if client.wire.stands_at_zero() {
            client.set_reference(0.0)?;
        }
        Ok(client)
    }

    /// Sends a hello, and opens a session. While another client drives the motor, the device opens
    /// none, and this client can only read, stop and take over.
    ///
    /// # Errors
    /// Returns an error if the device does not answer, or has another version of the link.
    pub fn begin_session(&mut self) -> Result<(), Error> {
        self.session = NO_SESSION;
        // Random; the standard library has no other random source on every system.
        let hello = RandomState::new().hash_one(()) as u32;
        let identity = match self.ask(Request::Hello { protocol: PROTOCOL, session: hello })? {
            Reply::Hello(identity) => identity,
            _ => return Err(self.unexpected()),
        };
        let Identity { protocol, version, .. } = &identity;
        if *protocol != PROTOCOL {
            let name = self.wire.name();
            return Err(Error::Device(format!(
                "{name} runs firmware {version} with version {protocol} of the link, but this \
                 program has version {PROTOCOL}; flash the firmware of this program (`cargo xtask \
                 flash`, docs/reference/link.md)"
            )));
        }
        self.identity = Some(identity);
        match self.talk(Request::Open { hello })? {
            Reply::Session(session) => self.session = session,
            Reply::Refused(RequestRefusal::NotOwner) => {}
            Reply::Refused(refused) => return Err(self.refused("hello", &refused)),
            _ => return Err(self.unexpected()),
        }
        Ok(())
    }

    /// Opens a session if a request needs one and there is none, because another client drove the
    /// motor.
    fn begin_late(&mut self, request: &Request) -> Result<(), Error> {
        let needs_none = matches!(
            request,
            Request::Hello { .. } | Request::Open { .. } | Request::Stop | Request::TakeOver
        );
        if self.session != NO_SESSION || needs_none || request.only_reads() {
            return Ok(());
        }
        self.begin_session()
    }

    /// Returns whether this client has no session, because another client drove the motor at the
    /// hello: this client can only read, stop and take over.
    pub const fn is_guest(&self) -> bool {
        self.session == NO_SESSION
    }

    /// Stops the motor, ends the session of any other client, and opens a new one.
    ///
    /// # Errors
    /// Returns an error if the device does not answer, or if its output stays on.
    pub fn take_over(&mut self) -> Result<(), Error> {
        self.done("take-over", Request::TakeOver)?;
        self.wait_until_off()?;
        self.begin_session()
    }

    /// Returns the identity that the device has sent.
    pub const fn identity(&self) -> Option<&Identity> {
        self.identity.as_ref()
    }

    /// Returns the warning that precedes every output about the device. A board needs none.
    pub fn warning(&self) -> Option<&'static str> {
        let simulated = || {
            self.identity.as_ref().is_some_and(|identity| identity.kind == DeviceKind::Simulated)
        };
        // Only its hello identifies a simulated device behind a port.
        self.wire.warning().or_else(|| simulated().then_some(SIMULATED))
    }

    /// Ends each wait ([`pass`](Self::pass), [`pass_armed`](Self::pass_armed)) with
    /// [`Error::CtrlC`] once the flag is set. Requests still work, so that the device can be
    /// stopped.
    pub fn end_on(&mut self, interrupt: Arc<AtomicBool>) {
        self.interrupt = Some(interrupt);
    }

    /// Returns the load's angle minus that of the encoder's side, deg, at a tick of the device's
    /// clock; `None` if the device measures its encoder only.
    pub fn load_ahead_deg(&self, clock: u32) -> Option<f64> {
        self.wire.load_ahead_deg(clock)
    }

    /// Returns the wire to the device.
    pub const fn wire(&mut self) -> &mut W {
        &mut self.wire
    }

    /// Ends the session and returns the wire.
    pub fn end(self) -> W {
        self.wire
    }
}
