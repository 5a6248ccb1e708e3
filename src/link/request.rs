//! The requests of a client.

use heapless::Vec;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::CHUNK;
use super::frame::{Frame, encode};
use crate::identification;
use crate::motion::Motion;
use crate::motion::home::HomeRequest;
use crate::motion::jog::JogRequest;

/// A request or a reply with its number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NumberedMessage<T> {
    /// Number of the request, which counts up and wraps. A reply has that of its request.
    pub number: u16,
    /// The request or the reply.
    pub content: T,
}

/// The first byte of a request: the direction of the message. No reply and no sample begins with
/// it, so a wire that echoes what the device says asks it for nothing, and is no sign of life.
///
/// A hello has no such byte, so that a device of any version of the protocol knows it. Nor does
/// every stop need one: it is obeyed in either form.
pub const REQUEST: u8 = 0xFF;

/// The number of no session, in which a client reads and takes over.
pub const NO_SESSION: u32 = 0;

/// A request as it comes over the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct IncomingRequest {
    /// The session that the client has it in mind for.
    pub session: u32,
    /// The number of the request.
    pub number: u16,
    /// The request; none if it is not known.
    pub content: Option<Request>,
}

/// Encodes a request of a session as a frame; returns none if it is too long.
pub fn encode_request(session: u32, number: u16, content: Request) -> Option<Frame> {
    match content {
        Request::Hello { .. } => encode(&NumberedMessage { number, content }),
        _ => encode(&(REQUEST, session, NumberedMessage { number, content })),
    }
}

/// Reads a message as a request. A message that is no request at all gives none.
// Made in the crate that asks for it, which in an image keeps its code small.
#[inline]
pub fn decode_request(message: &[u8]) -> Option<IncomingRequest> {
    match message {
        [REQUEST, rest @ ..] => {
            let (session, rest) = postcard::take_from_bytes::<u32>(rest).ok()?;
            match numbered(rest) {
                // A hello is never marked: the byte is the first one of its number.
                None | Some((_, Some(Request::Hello { .. }))) => plain(message),
                Some((number, content)) => Some(IncomingRequest { session, number, content }),
            }
        }
        _ => plain(message),
    }
}

/// Reads what a client of any version may say without the direction. No request has number zero,
/// so that the echo of a short reply is none.
#[inline]
fn plain(message: &[u8]) -> Option<IncomingRequest> {
    let (number, content) = numbered(message)?;
    let is_one = matches!(content, Some(Request::Hello { .. } | Request::Stop));
    (number != 0 && is_one).then_some(IncomingRequest { session: NO_SESSION, number, content })
}

/// Reads a number, which comes first so that what is not understood can be answered, and a request
/// that takes up all of the other bytes.
#[inline(never)]
fn numbered<T: DeserializeOwned>(message: &[u8]) -> Option<(u16, Option<T>)> {
    let (number, content) = postcard::take_from_bytes::<u16>(message).ok()?;
    let request = match postcard::take_from_bytes(content) {
        Ok((request, [])) => Some(request),
        _ => None,
    };
    Some((number, request))
}

/// Request of a client to a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? The hello begins a session, unless another one has an owner: numbers start
    /// anew, and whatever was subscribed ends.
    Hello {
        /// The client's version of the protocol, [`PROTOCOL`](super::PROTOCOL).
        protocol: u16,
        /// Any number that the client has not used of late. The same one again is the same hello,
        /// come twice.
        session: u32,
    },
    /// Turn the output off. The device obeys at all times, even one who has not said hello.
    Stop,
    /// What state are you in? The request is also a sign of life.
    Status,
    /// What was the fault of this place in the log?
    Fault {
        /// Place of the fault; the oldest is 0.
        index: u8,
    },
    /// Clear the latched fault, which has been seen to.
    Clear,
    /// Close the loop where the joint is.
    Arm,
    /// Move, while armed: to a position or through corners in the zero that arming has set, or stay
    /// where the joint is. A motion is never relative: the same move twice is the same as once.
    Move(Motion),
    /// What are the parameters that are in use? They are read as a record, from a byte on.
    ReadParameters {
        /// Place of the first byte in the record.
        offset: u16,
    },
    /// Here is a piece of a record. Nothing is taken yet.
    WriteParameters {
        /// Place of the first byte in the record.
        offset: u16,
        /// The record's bytes from that place on.
        bytes: Vec<u8, CHUNK>,
    },
    /// All of the record has been written: validate it as a whole, and take it.
    TakeParameters {
        /// Length of the record, bytes.
        length: u16,
    },
    /// Keep the parameters that are in use across a reset.
    Save,
    /// Take other values for some of the parameters, validated as a whole. A law that was not there
    /// before needs all of its gains.
    Change {
        /// The values as entries of a [`record`](crate::parameters::record).
        entries: Vec<u8, CHUNK>,
    },
    /// What is the signal of this place? The first one is 0, and after the last one there is no
    /// such.
    Signal {
        /// Place of the signal.
        index: u8,
    },
    /// Send these signals of every `every`-th tick; 0 ends it.
    Subscribe {
        /// The signals to send: a sum of 1 << place.
        signals: u64,
        /// Ticks from one sample to the next.
        every: u16,
    },
    /// Find the friction: arm, and run a ramp of the effort instead of the loop. The ramp ends by
    /// itself.
    Identify {
        /// Rate of the effort, V/s.
        rate: f32,
        /// Time between the rise and the fall of the effort, s.
        hold: f32,
    },
    /// What has the last ramp found?
    ReadLevels,
    /// Find the encoder's direction: arm, and push the joint a little each way, open loop. The
    /// device keeps its own bounds of effort, travel, speed and time; the client may ask for less.
    /// The jog ends by itself.
    Jog(JogRequest),
    /// What has the last jog found?
    ReadJog,
    /// Turn the part's brown-out reset on, at its highest level. The part keeps that for good, and
    /// goes by it after its next reset. The output is off.
    SetBrownOut,
    /// Identify the joint: arm, and run a sequence of motions within bounds that the device keeps,
    /// instead of the loop. The client may ask for other bounds. The sequence ends by itself.
    IdentifyJoint(identification::IdentificationRequest),
    /// What has the last identification found?
    ReadIdentification,
    /// What is the map of the friction that the last identification has made?
    ReadMap,
    /// The joint stands at this position: the range of positions holds from here. The output is
    /// off, and the joint is at rest.
    SetReference {
        /// Position of the joint, counts.
        position: i32,
    },
    /// What is the number of the session that my hello has begun?
    Open {
        /// The number in the hello.
        hello: u32,
    },
    /// Stop, and end the session that there is: the next hello begins another one.
    TakeOver,
    /// Find the joint's position: arm, and go one way, slowly and with a bounded effort, until a
    /// hard stop blocks the joint. It stands at the position of the request then. The homing ends
    /// by itself.
    Home(HomeRequest),
    /// What has the last homing found?
    ReadHome,
}

impl Request {
    /// Returns whether the request only reads, at once: any client may.
    pub const fn only_reads(&self) -> bool {
        matches!(
            self,
            Self::Status
                | Self::Fault { .. }
                | Self::ReadParameters { .. }
                | Self::Signal { .. }
                | Self::ReadLevels
                | Self::ReadJog
                | Self::ReadHome
                | Self::ReadMap
        )
    }
}
