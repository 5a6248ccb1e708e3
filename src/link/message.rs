//! What is said over the link, in postcard.
//!
//! A client sends [`Request`]s, each with a number; the device answers each with one [`Reply`] of the same number.
//! Beside that it sends [`Sample`]s to those who have subscribed. [`Request::Hello`] and [`Identity`] keep their form
//! and their place in every version of the protocol: two that do not speak the same can always tell.
//!
//! Every request can be repeated: it says what shall be, not what shall change.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::compensator::{Gains, MAX_TERMS};
use crate::error::{Allowed, Error};
use crate::parameters::{DecodeError, Motion};
use crate::pd::PdGains;
use crate::servo;

/// Raised with every change of a message.
pub const PROTOCOL: u16 = 1;

/// Bytes of a record in one message.
pub const CHUNK: usize = 128;

/// From the client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numbered<T> {
    /// Counts up, and wraps.
    pub number: u16,
    /// What is said.
    pub content: T,
}

/// What a device is asked or told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? Begins a session: numbers start anew, and whatever was subscribed ends.
    Hello {
        /// [`PROTOCOL`] of the client.
        protocol: u16,
        /// Any number that the client has not used of late: the same one again is the same hello, come twice.
        session: u32,
    },
    /// Output off. Obeyed at all times, even from one who has not said hello.
    Stop,
    /// What state are you in? Also a sign of life.
    Status,
    /// One of the faults that are remembered, the oldest is 0.
    Fault {
        /// Which.
        index: u8,
    },
    /// The latched fault is seen to.
    Clear,
    /// Close the loop where the joint is.
    Arm,
    /// Move, while armed.
    Move(Move),
    /// The parameters that are in use, as a record, from a byte on.
    ReadParameters {
        /// First byte.
        offset: u16,
    },
    /// A piece of a record; nothing is taken yet.
    WriteParameters {
        /// First byte.
        offset: u16,
        /// The bytes.
        bytes: Vec<u8, CHUNK>,
    },
    /// All of the record has been written: validate it as a whole, and take it.
    TakeParameters {
        /// Length of the record.
        length: u16,
    },
    /// Keep the parameters that are in use across a reset.
    Save,
    /// Which law, with which gains?
    ReadLaw,
    /// Another law, or other gains, validated as a whole.
    WriteLaw(Law),
    /// Send these terms of every so many ticks; `every` 0 ends it.
    Subscribe {
        /// A sum of [`Term::bit`]s.
        terms: u16,
        /// Ticks from one sample to the next.
        every: u16,
    },
}

/// A motion in the zero that arming has set.
// The difference in size is a trajectory's corners: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Move {
    /// Stop where the joint is, and stay there with the loop closed.
    Hold,
    /// To a position, or through corners. Never relative: the same move twice is the same as once.
    To(Motion),
}

/// The law of the loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Law {
    /// The PD loop.
    pub pd: PdGains,
    /// The laws that are added to it.
    pub compensator: Vec<Gains, MAX_TERMS>,
}

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
    /// To [`Request::Status`].
    Status(Status),
    /// To [`Request::Fault`].
    Fault(Told),
    /// To [`Request::ReadParameters`].
    Parameters {
        /// Length of the record.
        length: u16,
        /// From there on.
        offset: u16,
        /// So much of it.
        bytes: Vec<u8, CHUNK>,
    },
    /// To [`Request::ReadLaw`].
    Law(Law),
}

/// Who answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// [`PROTOCOL`] of the device.
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
pub enum State {
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
    pub state: State,
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
        /// The key in a machine's file.
        key: String<32>,
        /// What was found.
        found: f32,
        /// What is allowed.
        allowed: Allowed,
    },
    /// The flash failed; the parameters in use are not saved.
    Flash,
}

/// Terms of one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Counts every sample that was due: a gap says how many were lost.
    pub number: u32,
    /// Ticks since power-on.
    pub clock: u32,
    /// Which terms.
    pub terms: u16,
    /// Their values in the order of [`Term::ALL`], four bytes each, little endian.
    pub values: Vec<u8, 64>,
}

/// A term of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Term {
    /// Whole counts of theta_d; `i32`.
    SetpointCounts = 0,
    /// The fraction of a count; `f32`, as all that follow unless they say otherwise.
    SetpointFraction = 1,
    /// theta_d', deg/s.
    SetpointVelocity = 2,
    /// theta_a, counts; `i32`.
    Counts = 3,
    /// theta_e, deg.
    Error = 4,
    /// theta_a', deg/s.
    Velocity = 5,
    /// v_PD, V.
    Pd = 6,
    /// v_c, V.
    Compensator = 7,
    /// v, V.
    Output = 8,
    /// The drive's code, as it was applied; `i32`.
    Code = 9,
    /// Compare value; `i32`, negative if the direction is reverse.
    Duty = 10,
    /// `u32`: bits 0 to 7 the state (0 boot, 1 stopped, 2 armed, 3 faulted), 8 to 15 the fault's code, 16 saturated, 17 wound
    /// up, 18 bridge on.
    Flags = 11,
}

impl Term {
    /// All of them, in the order of their values in a sample.
    pub const ALL: [Self; 12] = [
        Self::SetpointCounts,
        Self::SetpointFraction,
        Self::SetpointVelocity,
        Self::Counts,
        Self::Error,
        Self::Velocity,
        Self::Pd,
        Self::Compensator,
        Self::Output,
        Self::Code,
        Self::Duty,
        Self::Flags,
    ];

    /// Its bit in a subscription.
    pub const fn bit(self) -> u16 {
        1 << self as u8
    }
}

impl Sample {
    /// The value of a term, if the sample has it.
    ///
    /// ```
    /// use stiction::link::{Sample, Term};
    /// let terms = Term::Counts.bit() | Term::Code.bit();
    /// let values = [1, 0, 0, 0, 254, 255, 255, 255].into_iter().collect();
    /// let sample = Sample { number: 0, clock: 0, terms, values };
    /// let term = |term| sample.value(term).map(i32::from_le_bytes);
    /// assert_eq!([Term::Counts, Term::Error, Term::Code].map(term), [Some(1), None, Some(-2)]);
    /// ```
    pub fn value(&self, term: Term) -> Option<[u8; 4]> {
        if self.terms & term.bit() == 0 {
            return None;
        }
        let before = (self.terms & (term.bit() - 1)).count_ones() as usize;
        self.values.get(4 * before..)?.first_chunk().copied()
    }
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
        let key = String::try_from(error.key).unwrap_or_default();
        Self::Value { key, found: error.found, allowed: error.allowed }
    }
}

impl From<DecodeError> for Refused {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Version(version) => Self::Version(version),
            DecodeError::Value(error) => error.into(),
            DecodeError::Blank
            | DecodeError::NotParameters
            | DecodeError::Checksum
            | DecodeError::Malformed => Self::NotWhole,
        }
    }
}

impl From<servo::State> for State {
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
