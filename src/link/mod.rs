//! The command link: from bytes to what a servo does, and back.
//!
//! ```text
//! bytes -> frame -> message -> session -> servo, parameters, store
//!                                 |
//! bytes <- frame <- message <-----+---- telemetry <- ticks
//! ```
//!
//! Free of the chip and of any wire: a board moves bytes to and from its USART, a program on a host does the same in
//! memory. Everything is bounded, and nothing that comes over the wire can panic.

mod frame;
mod message;
mod session;
mod telemetry;

pub use frame::{Deframer, Frame, MAX_FRAME, MAX_MESSAGE, encode};
pub use message::{
    CHUNK, Identity, Kind, Law, Message, Move, Numbered, PROTOCOL, Refused, Reply, Request, Sample, State,
    Status, Term, Told,
};
pub use session::{Machine, Session};
