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
use crate::motion::winding::WindingRequest;

/// A request or a reply with its number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NumberedMessage<T> {
    /// Number of the request, which counts up and wraps. A reply has that of its request.
    pub number: u16,
    /// The request or the reply.
    pub content: T,
}

/// The first byte of a request, which marks the direction of the message. No reply and no sample
/// begins with it, so an echo of the device's own messages is neither a request nor a sign of life.
///
/// A hello has no such byte, so that a device of any version of the protocol recognises it. A stop
/// is obeyed with and without this byte.
pub const REQUEST: u8 = 0xFF;

/// Session number of a client without a session, which can read, stop and take over.
pub const NO_SESSION: u32 = 0;

/// A request as received over the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct IncomingRequest {
    /// Number of the session for which the client has sent the request.
    pub session: u32,
    /// The number of the request.
    pub number: u16,
    /// The request; none if it is unknown.
    pub content: Option<Request>,
}

/// Encodes a request of a session as a frame; returns none if it is too long.
pub fn encode_request(session: u32, number: u16, content: Request) -> Option<Frame> {
    match content {
        Request::Hello { .. } => encode(&NumberedMessage { number, content }),
        _ => encode(&(REQUEST, session, NumberedMessage { number, content })),
    }
}

/// Decodes a message as a request; returns none if the message is no request at all.
// Compiled in the calling crate, which keeps the code of an image small.
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

/// Decodes a hello or a stop, which a client of any version can send without the byte of the
/// direction. No request has number zero, so that the echo of a short reply is no request.
#[inline]
fn plain(message: &[u8]) -> Option<IncomingRequest> {
    let (number, content) = numbered(message)?;
    let is_one = matches!(content, Some(Request::Hello { .. } | Request::Stop));
    (number != 0 && is_one).then_some(IncomingRequest { session: NO_SESSION, number, content })
}

/// Decodes a number and a request, which fills all of the other bytes. The number comes first, so
/// that an unknown request can be answered.
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
    /// Read the identity of the device, and begin a session unless another one has an owner. In a
    /// new session, the numbers start anew, and nothing is subscribed.
    Hello {
        /// The client's version of the protocol, [`PROTOCOL`](super::PROTOCOL).
        protocol: u16,
        /// Any number that the client has not used recently. A hello with the same number is a
        /// repetition.
        session: u32,
    },
    /// Stop the joint and turn the output off. The device obeys at all times, even without a hello.
    Stop,
    /// Read the status of the device. The request is also a sign of life.
    Status,
    /// Read the fault at this place in the log.
    Fault {
        /// Place of the fault; the oldest is 0.
        index: u8,
    },
    /// Clear the latched fault, after its cause has been removed.
    Clear,
    /// Arm: close the loop at the present position of the joint.
    Arm,
    /// Move, while armed: to a position or through corners, counted from the zero that arming has
    /// set, or hold the joint. A motion is never relative: the same move twice has the effect of
    /// one.
    Move(Motion),
    /// Read the parameters in use, as a record, from a byte on.
    ReadParameters {
        /// Place of the first byte in the record.
        offset: u16,
    },
    /// Transfer a piece of a record. The parameters in use do not change yet.
    WriteParameters {
        /// Place of the first byte in the record.
        offset: u16,
        /// The record's bytes from that place on.
        bytes: Vec<u8, CHUNK>,
    },
    /// Validate the whole record, after all of it has been written, and use its parameters.
    TakeParameters {
        /// Length of the record, bytes.
        length: u16,
    },
    /// Save the parameters in use, which then survive a reset.
    Save,
    /// Change the values of some of the parameters, which are validated as a whole. A law that is
    /// new in the sum needs all of its gains.
    Change {
        /// The values as entries of a [`record`](crate::parameters::record).
        entries: Vec<u8, CHUNK>,
    },
    /// Read the description of the signal at this place. The first place is 0; after the last
    /// signal, the request is refused.
    Signal {
        /// Place of the signal.
        index: u8,
    },
    /// Send these signals of every `every`-th tick; 0 ends the subscription.
    Subscribe {
        /// The signals to send: a sum of 1 << place.
        signals: u64,
        /// Ticks from one sample to the next.
        every: u16,
    },
    /// Find the friction: arm, and run a ramp of the effort instead of the loop. The ramp ends
    /// automatically.
    Identify {
        /// Rate of the effort, V/s.
        rate: f32,
        /// Time between the rise and the fall of the effort, s.
        hold: f32,
    },
    /// Read the friction levels that the last ramp has found.
    ReadLevels,
    /// Find the encoder's direction: arm, and push the joint a little each way, open loop. The
    /// device keeps its own bounds of effort, travel, speed and time; the client may request lower
    /// ones. The jog ends automatically.
    Jog(JogRequest),
    /// Read the findings of the last jog.
    ReadJog,
    /// Turn the microcontroller's brown-out reset on, at its highest level. The setting is
    /// permanent, and applies after the next reset. The output has to be off.
    SetBrownOut,
    /// Identify the joint: arm, and run a sequence of motions within bounds that the device keeps,
    /// instead of the loop. The client may request other bounds. The sequence ends automatically.
    IdentifyJoint(identification::IdentificationRequest),
    /// Read the result of the last identification.
    ReadIdentification,
    /// Read the map of the friction that the last identification has made.
    ReadMap,
    /// Set the position in which the joint is now. The range of positions refers to it from then
    /// on. The output has to be off, and the joint at rest.
    SetReference {
        /// Position of the joint, counts.
        position: i32,
    },
    /// Read the number of the session that the client's hello has begun.
    Open {
        /// The number in the hello.
        hello: u32,
    },
    /// Stop the joint, and end the present session: the next hello begins another one.
    TakeOver,
    /// Find the joint's position: arm, and go one way, slowly and with a bounded effort, until a
    /// hard stop blocks the joint. The position there is that of the request. The homing ends
    /// automatically.
    Home(HomeRequest),
    /// Read the findings of the last homing.
    ReadHome,
    /// Measure the winding: arm, and pulse the motor at rest with a voltage. The effort must be a
    /// current (`loop.effort`), since the board then works in each period of the PWM. The
    /// measurement ends automatically.
    MeasureWinding(WindingRequest),
    /// Read the findings of the last measurement of the winding.
    ReadWinding,
}

impl Request {
    /// Returns whether the request only reads and is answered at once: any client may send it.
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
                | Self::ReadWinding
                | Self::ReadMap
        )
    }
}
