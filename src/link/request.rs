//! What a client says.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::CHUNK;
use crate::motion::Motion;

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
        /// [`PROTOCOL`](super::PROTOCOL) of the client.
        protocol: u16,
        /// Any number that the client has not used of late: the same one again is the same hello,
        /// come twice.
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
    /// Move, while armed: to a position or through corners in the zero that arming has set, or stay
    /// where the joint is. Never relative: the same move twice is the same as once.
    Move(Motion),
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
    /// Other values for some of the parameters, validated as a whole: entries as in
    /// [`record`](crate::parameters::record). A law that was not there before needs all of its
    /// gains.
    Change {
        /// The entries.
        entries: Vec<u8, CHUNK>,
    },
    /// What is the signal of this place? The first one is 0, and after the last one there is no
    /// such.
    Signal {
        /// Which.
        index: u8,
    },
    /// Send these signals of every so many ticks; `every` 0 ends it.
    Subscribe {
        /// A sum of 1 << place.
        signals: u64,
        /// Ticks from one sample to the next.
        every: u16,
    },
    /// Find the friction: arm, and run a ramp of the effort instead of the loop. Ends by itself.
    Identify {
        /// V/s.
        rate: f32,
        /// Time between the rise and the fall, s.
        hold: f32,
    },
    /// What has the last ramp found?
    ReadLevels,
}
