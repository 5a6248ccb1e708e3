//! The owner of a link: when a hello begins a session, and what a client without a session may do.
//!
//! While the motor is driven for a link, its session has an owner, and no other hello begins one.
//! Another client reads, stops, or takes over: that stops the motor and ends the session.

use heapless::String;

use super::super::PROTOCOL;
use super::super::reply::{Identity, Reply, RequestRefusal};
use super::super::request::{NO_SESSION, Request};
use super::super::telemetry::Subscription;
use super::{Machine, Session};
use crate::parameters::ROOM;
use crate::servo::Servo;

impl<const RING: usize> Session<RING> {
    /// Begins a session. Its number depends on the hello, the time and the last number, so that
    /// bytes that are received again later belong to no session.
    pub(super) fn greet(
        &mut self,
        protocol: u16,
        session: u32,
        machine: &mut impl Machine,
    ) -> Reply {
        self.greeted = (protocol == PROTOCOL).then_some(session);
        self.session = following(self.session, session, machine.servo(|servo| servo.clock()));
        self.subscription = Subscription::default();
        self.incoming = [0; ROOM];
        self.identity()
    }

    pub(super) fn identity(&self) -> Reply {
        let version = String::try_from(crate::VERSION).unwrap_or_default();
        Reply::Hello(Identity { protocol: PROTOCOL, kind: self.kind, version })
    }

    /// Stops the joint, and ends the session.
    pub(super) fn end(&mut self, machine: &mut impl Machine) -> Reply {
        // A repeated request is one stop.
        machine.servo(|servo| {
            if !servo.is_stopping() {
                servo.come_to_rest();
            }
        });
        self.greeted = None;
        self.subscription = Subscription::NONE;
        Reply::Done
    }

    /// Answers a request that is not of the session. Of the requests that change anything, only a
    /// stop and a takeover are executed. None of them is a sign of life.
    #[inline(never)]
    pub(super) fn of_no_session(
        &mut self,
        session: u32,
        request: Option<Request>,
        machine: &mut impl Machine,
    ) -> Reply {
        let is_driven = machine.servo(|servo| servo.is_driven_for_a_link());
        match request {
            None => Reply::Refused(RequestRefusal::Unknown),
            Some(Request::Stop) => {
                machine.servo(Servo::come_to_rest);
                Reply::Done
            }
            Some(Request::TakeOver) => self.end(machine),
            Some(Request::Open { hello }) if self.greeted == Some(hello) => {
                Reply::Session(self.session)
            }
            // A client whose session has ended has to notice.
            Some(request) if session == NO_SESSION && request.only_reads() => {
                self.act(request, machine).unwrap_or_else(Reply::Refused)
            }
            Some(_) if is_driven && session == NO_SESSION => {
                Reply::Refused(RequestRefusal::NotOwner)
            }
            Some(_) => Reply::Refused(RequestRefusal::SayHello),
        }
    }
}

/// Returns the number of the session after `last` that a hello begins at a tick. Its bits are mixed
/// by a multiplication with an odd constant (2^32 over the golden ratio) and a shift. The number is
/// odd, so that it differs from `NO_SESSION`.
const fn following(last: u32, hello: u32, clock: u32) -> u32 {
    let mixed = (last ^ hello.rotate_left(13) ^ clock.rotate_left(7)).wrapping_mul(0x9E37_79B9);
    let number = (mixed ^ (mixed >> 15)) | 1;
    if number == last { number ^ 2 } else { number }
}
