//! The messages of a device: replies and samples.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use super::CHUNK;
use super::request::NumberedMessage;
use super::sample::Sample;
use crate::control::signal::{self, Form};
use crate::identification::{MapPoint, SPEEDS, Summary};
use crate::motion::home::HomeFindings;
use crate::motion::jog::JogFindings;
use crate::motion::winding::WindingFindings;
use crate::parameters::DecodeError;
use crate::parameters::store::SaveError;
use crate::servo::{self, FrictionLevels};
use crate::units::error::{Allowed, InvalidValue};
use crate::units::value::Key;

/// A message from the device.
// The difference in size is that of the bytes that some carry: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// The answer to a request.
    Reply(NumberedMessage<Reply>),
    /// Subscribed signals of a tick.
    Sample(Sample),
}

/// An answer to a request.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The answer to [`Request::Hello`](super::Request::Hello).
    Hello(Identity),
    /// The request was not done, for this reason.
    Refused(RequestRefusal),
    /// The request was done.
    Done,
    /// The answer to [`Request::Status`](super::Request::Status).
    Status(Status),
    /// The answer to [`Request::Fault`](super::Request::Fault).
    Fault(FaultReport),
    /// The answer to [`Request::ReadParameters`](super::Request::ReadParameters).
    Parameters {
        /// Length of the whole record, bytes.
        length: u16,
        /// Place of the first byte in the record.
        offset: u16,
        /// The record's bytes from that place on, as many as fit.
        bytes: Vec<u8, CHUNK>,
    },
    /// The answer to [`Request::Signal`](super::Request::Signal).
    Signal(SignalDescription),
    /// The answer to [`Request::ReadLevels`](super::Request::ReadLevels). There are no levels if
    /// the ramp is not over or was ended before, or if there was no ramp.
    Levels(Option<FrictionLevels>),
    /// The answer to [`Request::ReadJog`](super::Request::ReadJog). There is nothing if the jog is
    /// not over, if a stop or a fault ended it, or if there was no jog.
    Jog(Option<JogFindings>),
    /// The answer to [`Request::ReadIdentification`](super::Request::ReadIdentification). There is
    /// nothing if the identification is not over, if a stop or a fault ended it, or if there was
    /// none.
    Identification(Option<Summary>),
    /// The answer to [`Request::ReadMap`](super::Request::ReadMap), likewise: each speed in both
    /// senses, the fastest first.
    Map(Option<[[MapPoint; 2]; SPEEDS]>),
    /// The answer to [`Request::Open`](super::Request::Open): the number of the session.
    Session(u32),
    /// The answer to [`Request::ReadHome`](super::Request::ReadHome). There is nothing if the
    /// homing is not over, if a stop or a fault ended it, or if there was none.
    Home(Option<HomeFindings>),
    /// The answer to [`Request::ReadWinding`](super::Request::ReadWinding). There is nothing if the
    /// measurement is not over, if a stop or a fault ended it, or if there was none.
    Winding(Option<WindingFindings>),
}

/// A signal, as a device announces it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SignalDescription {
    /// The signal's name, with its unit.
    pub name: String<48>,
    /// The unit alone; empty if there is none.
    pub unit: String<16>,
    /// How the signal's values are read.
    pub form: Form,
}

/// The identity of the device that answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The device's version of the protocol, [`PROTOCOL`](super::PROTOCOL).
    pub protocol: u16,
    /// The kind of device.
    pub kind: DeviceKind,
    /// The version of the device's core.
    pub version: String<16>,
}

/// The kinds of devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DeviceKind {
    /// A microcontroller. An emulated one reports this, too: it cannot detect its emulation.
    Board,
    /// The core in a program on a host: no motor moves or stops.
    Simulated,
}

/// State of a servo as it is sent over the link, with the number of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StateCode {
    /// The servo has not had its first tick.
    Boot,
    /// The output is off; the servo may be armed.
    Stopped,
    /// The output is on: the loop is closed, or runs open for a ramp or a jog.
    Armed,
    /// The output is off until the fault of this code is cleared.
    Faulted(u8),
}

/// The status of a device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The servo's state.
    pub state: StateCode,
    /// The latched fault; its code is zero if there is none.
    pub fault: FaultReport,
    /// Number of faults since power-on.
    pub faults: u32,
    /// Ticks since power-on.
    pub clock: u32,
    /// Time between ticks, s; zero without parameters.
    pub sample_time: f32,
    /// Position, counts: since power-on, or from the zero that a reference has set.
    pub position: i32,
    /// Angle of a count, deg; zero without parameters.
    pub resolution: f32,
    /// Whether the joint is at rest.
    pub at_rest: bool,
    /// Whether the compensator holds effort at standstill, which the motor turns into heat.
    pub wound_up: bool,
    /// Steady effort at standstill that would keep the motor as warm as it is now, by the thermal
    /// model, V.
    pub thermal_effort: f32,
    /// Measured temperature of the motor, deg C; none without a sensor, or while it is open.
    pub motor_temperature: Option<f32>,
    /// Whether the parameters in use were changed and not saved since.
    pub unsaved: bool,
    /// Whether one of the two saved sets of parameters is damaged. The parameters in use may then
    /// be older than the last saved ones.
    pub is_damaged: bool,
    /// Number of saves of parameters so far; each save wears the flash.
    pub saves: u32,
    /// Number of frames that were damaged, cut off or too long.
    pub bad_frames: u32,
    /// Number of answers and samples that were dropped because the outbox was full.
    pub dropped: u32,
    /// Whether the microcontroller's brown-out reset is on. If it is off, a dip of its supply
    /// cannot be distinguished from power-on.
    pub has_brown_out: bool,
    /// Errors of the wire, which are detected before a frame is decoded.
    pub wire: WireErrors,
    /// Whether the microcontroller runs from a crystal whose frequency it could not measure.
    pub crystal_not_measured: bool,
    /// Whether the law has ended its attempts to reach the set point. The output stays on.
    pub gave_up: bool,
    /// Whether the encoder is in doubt after a stall, a jump or a reversal, so that only a jog may
    /// drive the joint.
    pub is_encoder_in_doubt: bool,
    /// Whether the joint swings to and fro around a set point that rests.
    pub oscillates: bool,
    /// Whether the joint is referenced: its position is known, and so its range of positions holds.
    /// If not, a joint with a range can only jog and home.
    pub is_referenced: bool,
    /// Whether a test at arming runs: the motion waits, and other motions are refused.
    pub is_testing: bool,
    /// Whether the latched fault came during a test at arming.
    pub has_failed_test: bool,
    /// Reading of an absolute encoder on the load, counts within its turn; `None` without one, or
    /// without a valid answer.
    pub load_angle: Option<u16>,
    /// Number of passes of the encoder's index since its check has started: at power-on, with other
    /// parameters, and with each reference.
    pub index_passes: u32,
    /// Deviation of the last of these passes from a whole number of turns, counts.
    pub index_deviation: i32,
}

/// Errors of the wire that the device receives from. Each destroys a frame, which also counts as
/// one of the [`bad_frames`](Status::bad_frames). The port receives many bytes between two checks,
/// so each number is a lower bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WireErrors {
    /// Number of times with noise on the wire, or with a byte without its stop bit.
    pub noise: u32,
    /// Number of times that a byte was lost because the device was too slow to read it.
    pub lost: u32,
}

/// Report of a latched fault to a client.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FaultReport {
    /// The number of the [`crate::Fault`].
    pub code: u8,
    /// Ticks from power-on to the fault.
    pub tick: u32,
    /// Value that tripped the fault, in the fault's unit.
    pub value: f32,
}

/// The reason why a request was not done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum RequestRefusal {
    /// The frame is valid, but is no request of this protocol.
    Unknown,
    /// The client has no session: it has sent no hello, or the device was reset meanwhile, or
    /// another client has taken over.
    SayHello,
    /// A later request has been answered already.
    OutOfOrder,
    /// The servo has not had its first tick.
    Booting,
    /// The fault of this code is latched.
    Faulted(u8),
    /// The fault of this code cannot be cleared: it ends with valid parameters or a reset.
    NotClearable(u8),
    /// The servo is armed, and does this only while the output is off.
    Armed,
    /// The servo is not armed, and does this only while it is.
    NotArmed,
    /// The joint moves, and has to be at rest.
    Moving,
    /// Arming would trip the fault of this code at once.
    WouldTrip(u8),
    /// The motion leaves the range of positions.
    OutOfRange,
    /// There are no parameters.
    NoParameters,
    /// The device has no such fault, signal or motion, or the record has no such byte.
    NoSuch,
    /// The record is incomplete or damaged, or is no record of parameters.
    NotWhole,
    /// The record has this format version, which is unknown.
    Version(u32),
    /// A value is invalid.
    Value {
        /// The number of the value.
        key: Key,
        /// The value that was found, as a number.
        found: f32,
        /// The values that are allowed.
        allowed: Allowed,
    },
    /// The record has a value that is unknown to this firmware.
    UnknownValue(Key),
    /// The record lacks a required value.
    MissingValue(Key),
    /// The flash failed; the parameters in use are not saved.
    Flash,
    /// The watchdog did not accept a new timeout in time.
    Watchdog,
    /// The motion begins farther from the joint than the limit of the following error, or than the
    /// error at which the loop requests the full scale.
    FarAway,
    /// The device's own supply is too low to erase and write its flash.
    SupplyTooLow,
    /// The position is 2^30 counts away from the set point, or farther.
    TooFar,
    /// The device has no option bytes: it is no microcontroller.
    NoOptionBytes,
    /// The microcontroller's option bytes must not be changed: they are protected forever, or they
    /// belong to another microcontroller than that of the firmware.
    Untouchable,
    /// The set point is too fast to come to rest within the range of positions.
    TooFast,
    /// The encoder is in doubt after a stall, a jump or a reversal: the joint has to be moved by
    /// hand, or a jog has to show that encoder and motor agree.
    EncoderInDoubt,
    /// A stop is under way.
    Stopping,
    /// Parameters were saved too often: the next save is possible after this time, s.
    SaveLater(u16),
    /// The friction of the joint is unknown, so that no closed loop is armed; `identify` finds the
    /// friction.
    FrictionUnknown,
    /// The joint has a range of positions, and its position is unknown.
    NotReferenced,
    /// Another client drives the motor. This client may read, stop and take over.
    NotOwner,
    /// A test at arming runs. [`Status::is_testing`] shows its end.
    Testing,
}

impl From<servo::Refusal> for RequestRefusal {
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
            servo::Refusal::FarAway => Self::FarAway,
            servo::Refusal::TooFar => Self::TooFar,
            servo::Refusal::TooFast => Self::TooFast,
            servo::Refusal::EncoderInDoubt => Self::EncoderInDoubt,
            servo::Refusal::Stopping => Self::Stopping,
            servo::Refusal::FrictionUnknown => Self::FrictionUnknown,
            servo::Refusal::NotReferenced => Self::NotReferenced,
            servo::Refusal::Testing => Self::Testing,
            // No request of a link starts the motion of the parameters.
            servo::Refusal::Replaced => Self::NoSuch,
        }
    }
}

impl From<InvalidValue> for RequestRefusal {
    fn from(error: InvalidValue) -> Self {
        Self::Value { key: error.key, found: error.found, allowed: error.allowed }
    }
}

impl From<DecodeError> for RequestRefusal {
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

impl From<SaveError> for RequestRefusal {
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

impl From<crate::safety::fault::LatchedFault> for FaultReport {
    fn from(latched: crate::safety::fault::LatchedFault) -> Self {
        Self { code: latched.fault as u8, tick: latched.tick, value: latched.value }
    }
}

impl From<signal::Signal> for SignalDescription {
    /// Returns the description of a signal. A name or a unit that is too long would become empty;
    /// all are short enough.
    fn from(signal: signal::Signal) -> Self {
        let name = String::try_from(signal.name).unwrap_or_default();
        let unit = String::try_from(signal.unit).unwrap_or_default();
        Self { name, unit, form: signal.form }
    }
}
