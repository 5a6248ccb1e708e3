//! What a device answers.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use super::CHUNK;
use super::request::Numbered;
use super::sample::Sample;
use crate::error::{Allowed, Error};
use crate::parameters::DecodeError;
use crate::servo::{self, Levels};
use crate::signal::{self, Form};
use crate::store::SaveError;
use crate::value::Key;

/// From the device.
// As above.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// An answer.
    Reply(Numbered<Reply>),
    /// Terms of a tick.
    Sample(Sample),
}

/// An answer.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// To a hello.
    Hello(Identity),
    /// Not done, and why.
    Refused(Refused),
    /// Done.
    Done,
    /// To [`Request::Status`](super::Request::Status).
    Status(Status),
    /// To [`Request::Fault`](super::Request::Fault).
    Fault(Told),
    /// To [`Request::ReadParameters`](super::Request::ReadParameters).
    Parameters {
        /// Length of the record.
        length: u16,
        /// From there on.
        offset: u16,
        /// So much of it.
        bytes: Vec<u8, CHUNK>,
    },
    /// To [`Request::Signal`](super::Request::Signal).
    Signal(Announced),
    /// To [`Request::ReadLevels`](super::Request::ReadLevels); none: it is not over, or was ended
    /// before, or there was no ramp.
    Levels(Option<Levels>),
}

/// A signal, as a device announces it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Announced {
    /// Its name, with the unit.
    pub name: String<48>,
    /// The unit alone; empty if there is none.
    pub unit: String<16>,
    /// How its values are read.
    pub form: Form,
}

/// Who answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// [`PROTOCOL`](super::PROTOCOL) of the device.
    pub protocol: u16,
    /// What it is.
    pub kind: Kind,
    /// Version of its core.
    pub version: String<16>,
}

/// What a device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// A microcontroller. It cannot tell that it is emulated; those who emulate it can.
    Board,
    /// The core in a program on a host: no motor moves or stops.
    Simulated,
}

/// The state of a servo, as a client knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StateCode {
    /// Before the first tick.
    Boot,
    /// Output off.
    Stopped,
    /// The loop is closed.
    Armed,
    /// Output off until the fault of this code is cleared.
    Faulted(u8),
}

/// How things stand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The state.
    pub state: StateCode,
    /// The latched fault; code zero if there is none.
    pub fault: Told,
    /// Faults since power-on.
    pub faults: u32,
    /// Ticks since power-on.
    pub clock: u32,
    /// Time between ticks, s; zero without parameters.
    pub sample_time: f32,
    /// Position since power-on, counts.
    pub position: i32,
    /// Angle of a count, deg; zero without parameters.
    pub resolution: f32,
    /// The joint is at rest.
    pub at_rest: bool,
    /// The compensator holds effort at standstill, which the motor turns into heat.
    pub wound_up: bool,
    /// An effort that would heat the motor as much as it is, V.
    pub thermal_effort: f32,
    /// The parameters in use are not the saved ones.
    pub unsaved: bool,
    /// Frames that were not whole.
    pub bad_frames: u32,
    /// Answers and samples that found no room on their way out.
    pub dropped: u32,
}

/// A fault, as a client is told of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// [`crate::Fault`] as a number.
    pub code: u8,
    /// Ticks from power-on.
    pub tick: u32,
    /// What tripped it, in the unit of the fault.
    pub value: f32,
}

/// Why a request was not done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Refused {
    /// The frame is whole, but no request of this protocol.
    Unknown,
    /// Hello comes first.
    SayHello,
    /// A later request has been answered already.
    OutOfOrder,
    /// Before the first tick.
    Booting,
    /// The fault of this code is latched.
    Faulted(u8),
    /// The fault of this code ends with valid parameters or a reset.
    NotClearable(u8),
    /// Only while the output is off.
    Armed,
    /// Only while armed.
    NotArmed,
    /// The joint has to be at rest.
    Moving,
    /// Arming would end in the fault of this code at once.
    WouldTrip(u8),
    /// The motion leads out of the range of positions.
    OutOfRange,
    /// There are no parameters.
    NoParameters,
    /// There is no such fault, or no such byte of a record.
    NoSuch,
    /// The record is not whole, or not one of parameters.
    NotWhole,
    /// The record has another version.
    Version(u32),
    /// A value is not allowed.
    Value {
        /// Which value.
        key: Key,
        /// What was found.
        found: f32,
        /// What is allowed.
        allowed: Allowed,
    },
    /// The record has a value that this firmware does not know.
    UnknownValue(Key),
    /// The record lacks a value that has to be there.
    MissingValue(Key),
    /// The flash failed; the parameters in use are not saved.
    Flash,
    /// The watchdog did not take over another timeout in time.
    Watchdog,
}

impl From<servo::Refusal> for Refused {
    fn from(refusal: servo::Refusal) -> Self {
        match refusal {
            servo::Refusal::Booting => Self::Booting,
            servo::Refusal::Faulted(fault) => Self::Faulted(fault as u8),
            servo::Refusal::NotClearable(fault) => Self::NotClearable(fault as u8),
            servo::Refusal::Armed => Self::Armed,
            servo::Refusal::NotArmed => Self::NotArmed,
            servo::Refusal::Moving => Self::Moving,
            servo::Refusal::WouldTrip(fault) => Self::WouldTrip(fault as u8),
            servo::Refusal::OutOfRange => Self::OutOfRange,
            // Nothing that comes over a link asks for it.
            servo::Refusal::Replaced => Self::NoSuch,
        }
    }
}

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Self::Value { key: error.key, found: error.found, allowed: error.allowed }
    }
}

impl From<DecodeError> for Refused {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Version(version) => Self::Version(version),
            DecodeError::Unknown(key) => Self::UnknownValue(key),
            DecodeError::Missing(key) => Self::MissingValue(key),
            DecodeError::Value(error) => error.into(),
            DecodeError::Blank
            | DecodeError::NotParameters
            | DecodeError::Checksum
            | DecodeError::Malformed => Self::NotWhole,
        }
    }
}

impl From<SaveError> for Refused {
    fn from(_: SaveError) -> Self {
        Self::Flash
    }
}

impl From<servo::State> for StateCode {
    fn from(state: servo::State) -> Self {
        match state {
            servo::State::Boot => Self::Boot,
            servo::State::Stopped => Self::Stopped,
            servo::State::Armed => Self::Armed,
            servo::State::Faulted(fault) => Self::Faulted(fault as u8),
        }
    }
}

impl From<crate::fault::Latched> for Told {
    fn from(latched: crate::fault::Latched) -> Self {
        Self { code: latched.fault as u8, tick: latched.tick, value: latched.value }
    }
}

impl From<signal::Signal> for Announced {
    /// Names and units are short; one that were not would be empty.
    fn from(signal: signal::Signal) -> Self {
        let name = String::try_from(signal.name).unwrap_or_default();
        let unit = String::try_from(signal.unit).unwrap_or_default();
        Self { name, unit, form: signal.form }
    }
}
