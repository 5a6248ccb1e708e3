//! The command link: from bytes to actions of a servo, and back.
//!
//! ```text
//! bytes -> frame -> request -> session -> servo, parameters, store
//!                                 |
//! bytes <- frame <- reply  <------+---- telemetry <- ticks
//! ```
//!
//! A client sends [`Request`]s in postcard, each with a number, behind the byte [`REQUEST`]. The
//! device answers each with one [`Reply`] of the same number, and sends [`Sample`]s to a client
//! that has subscribed. [`Request::Hello`] and [`Identity`] keep their form and their place in
//! every version of the protocol: two different versions always detect each other. Every request
//! can be repeated: it states the result, not a change.
//!
//! The link does not depend on the microcontroller or on a wire: a board moves bytes to and from
//! its USART, a program on a host does the same in memory. Everything is bounded, and nothing that
//! comes over the wire can panic.

mod frame;
mod outbox;
mod reply;
mod request;
mod sample;
mod save_budget;
mod session;
mod telemetry;

pub use frame::{Deframer, Frame, MAX_FRAME, MAX_MESSAGE, encode};
pub use reply::{
    DeviceKind, FaultReport, Identity, Message, Reply, RequestRefusal, SignalDescription,
    StateCode, Status, WireErrors,
};
pub use request::{
    IncomingRequest, NO_SESSION, NumberedMessage, REQUEST, Request, decode_request, encode_request,
};
pub use sample::{MAX_SIGNALS, Sample};
pub use session::{Machine, Session, WAITING};

/// The version of the protocol, which is raised with every change of a message.
pub const PROTOCOL: u16 = 13;

/// The largest number of bytes of a record in one message.
pub const CHUNK: usize = 128;
