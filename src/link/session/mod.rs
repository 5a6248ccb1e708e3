//! The session of a link: who may say what, and what is answered.
//!
//! A session begins with a hello, and the device chooses its number. A request that is not of the
//! session may only read, stop and take over: bytes of an earlier session change nothing. While the
//! motor is driven for a link, the session has an owner, and no other hello begins one. A client
//! that takes over stops the motor and ends the session. Each request is answered once, with its
//! own number. A request that comes twice is not done twice: its answer is sent again. A request
//! that was overtaken by a later one is refused. Stop is obeyed at all times. One answer takes
//! long, that to [`Request::ReadIdentification`]; who asks for something else before it comes, gets
//! none.
//!
//! Answers and samples wait in a ring of bytes until the wire takes them. Samples leave room for
//! answers. What finds no room is dropped and counted, and the numbers of the samples show the gap.
//! The owner of a session chooses how long the ring is: a host takes [`WAITING`], a board what its
//! RAM allows.

mod owner;
mod requests;

use super::frame::{Deframer, Frame, encode};
use super::outbox::{FOR_ANSWERS, Outbox};
use super::reply::{DeviceKind, Message, Reply, RequestRefusal, WireErrors};
use super::request::{IncomingRequest, NO_SESSION, NumberedMessage, Request, decode_request};
use super::save_budget::SaveBudget;
use super::telemetry::Subscription;
use crate::control::hardware::Hardware;
use crate::identification::Search;
use crate::parameters::{Parameters, ROOM};
use crate::servo::{Output, Servo};

/// Length of the ring of bytes that wait for the wire, unless the owner of a session says
/// otherwise.
pub const WAITING: usize = 2048;

/// How often the same request is a sign of life: a client says it three times, with two answers
/// lost, before it gives up.
const REPEATS: u8 = 2;

/// A machine: what a session acts on. A board locks its servo for as short as it can; a host has it
/// at hand.
pub trait Machine {
    /// Lets something act on the servo.
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R;

    /// Returns the figures of the machine's timers and converters.
    fn hardware(&self) -> Hardware;

    /// Keeps parameters across a reset. The output is off.
    ///
    /// Returns how often parameters have been saved.
    ///
    /// # Errors
    /// Says whether the flash failed, or the watchdog that has to wait for it.
    fn save(&mut self, parameters: &Parameters) -> Result<u32, RequestRefusal>;

    /// Prepares timers and watchdog for other parameters that are about to be in use: their sample
    /// time, PWM and dead time. The output is off, and stays so.
    ///
    /// # Errors
    /// Says that the watchdog cannot follow. All is as it was before then.
    fn reconfigure(&mut self, parameters: &Parameters) -> Result<(), RequestRefusal>;

    /// Turns the part's brown-out reset on, for good, from the next reset on. The output is off.
    ///
    /// # Errors
    /// Says that there is none, that it may not be touched, or that the flash failed.
    fn set_brown_out(&mut self) -> Result<(), RequestRefusal> {
        Err(RequestRefusal::NoOptionBytes)
    }
}

/// A session: the device's end of a link.
#[derive(Debug)]
pub struct Session<const RING: usize = WAITING> {
    kind: DeviceKind,
    deframer: Deframer,
    /// The parameters in use, if there are any.
    parameters: Option<Parameters>,
    /// Whether those are not the saved ones.
    unsaved: bool,
    /// How often the last request has come again.
    repeats: u8,
    /// Whether a slot of the saved parameters is damaged.
    is_damaged: bool,
    /// How often parameters have been saved, and how often they still may be.
    saves: u32,
    save_budget: SaveBudget,
    /// Whether the part's brown-out reset is on.
    has_brown_out: bool,
    /// Whether the part's crystal is in use and could not be measured.
    crystal_not_measured: bool,
    wire: WireErrors,
    /// The number in the hello that began the session; none before a hello.
    greeted: Option<u32>,
    /// The number of the session, and of the last one before its end.
    session: u32,
    /// The number of the last request that was answered, and the answer.
    last: Option<(u16, Frame)>,
    /// The number of a request for what an identification has found, and the search for its answer.
    search: Option<(u16, Search)>,
    /// The record that the client is transferring, as far as its bytes have come.
    incoming: [u8; ROOM],
    subscription: Subscription,
    outbox: Outbox<RING>,
}

impl<const RING: usize> Session<RING> {
    /// Makes a session before its first byte. `parameters` are those in use.
    pub const fn new(kind: DeviceKind, parameters: Option<Parameters>) -> Self {
        Self {
            kind,
            deframer: Deframer::new(),
            parameters,
            unsaved: false,
            repeats: 0,
            is_damaged: false,
            saves: 0,
            save_budget: SaveBudget::FULL,
            has_brown_out: true,
            crystal_not_measured: false,
            wire: WireErrors { noise: 0, lost: 0 },
            greeted: None,
            session: NO_SESSION,
            last: None,
            search: None,
            incoming: [0; ROOM],
            subscription: Subscription::NONE,
            outbox: Outbox::new(),
        }
    }

    /// Takes the saved parameters as those in use.
    pub fn use_saved(&mut self, parameters: &Parameters) {
        self.parameters = Some(parameters.clone());
        self.unsaved = false;
    }

    /// Sets whether the microcontroller's brown-out reset is on. Default: on.
    pub const fn report_brown_out(&mut self, is_on: bool) {
        self.has_brown_out = is_on;
    }

    /// Sets whether the microcontroller runs from a crystal that it could not measure.
    pub const fn report_crystal(&mut self, is_not_measured: bool) {
        self.crystal_not_measured = is_not_measured;
    }

    /// Sets the errors of the wire since the start.
    pub const fn report_wire(&mut self, errors: WireErrors) {
        self.wire = errors;
    }

    /// Sets whether a slot of the saved parameters is damaged; reported until the next save.
    pub const fn report_damage(&mut self, is_damaged: bool) {
        self.is_damaged = is_damaged;
    }

    /// Sets how often parameters have been saved.
    pub const fn report_saves(&mut self, saves: u32) {
        self.saves = saves;
    }

    /// Takes bytes from the wire, and does what they say.
    #[inline(never)]
    pub fn receive(&mut self, bytes: &[u8], machine: &mut impl Machine) {
        for &byte in bytes {
            let Some(message) = self.deframer.push(byte) else { continue };
            let Some(request) = Self::request(message) else { continue };
            self.take(request, machine);
        }
    }

    /// Goes on with an answer that takes long, and returns whether there is more of it to do.
    /// Between two pieces the tasks beside the link have their turn.
    #[inline(never)]
    pub fn work(&mut self, machine: &mut impl Machine) -> bool {
        let Some((number, search)) = &mut self.search else { return false };
        let Some(reply) = go_on(search, machine) else { return true };
        let number = *number;
        self.search = None;
        self.answer(number, reply, true);
        false
    }

    /// Reads a request. It is a function of its own, so that the stack that it needs is free again
    /// for what the request asks for.
    #[inline(never)]
    fn request(message: &[u8]) -> Option<IncomingRequest> {
        decode_request(message)
    }

    /// Queues a sample of a tick if one is due.
    #[inline(never)]
    pub fn queue_sample(&mut self, output: &Output) {
        let Some(sample) = self.subscription.sample(output) else { return };
        let frame = encode(&Message::Sample(sample));
        self.outbox.put(frame.as_ref(), FOR_ANSWERS);
    }

    /// Hands bytes to the wire, and returns how many.
    pub fn transmit(&mut self, bytes: &mut [u8]) -> usize {
        self.outbox.take(bytes)
    }

    /// Returns the number of the session, as the client that began it gets it.
    pub const fn number(&self) -> u32 {
        self.session
    }

    /// Returns the parameters in use, if there are any.
    pub const fn parameters(&self) -> Option<&Parameters> {
        self.parameters.as_ref()
    }

    /// Does a request, or answers again one that comes twice.
    ///
    /// What follows is cut into functions that are not inlined, so that their frames follow each
    /// other on the stack and do not add up: a board has little of it.
    #[inline(never)]
    fn take(&mut self, request: IncomingRequest, machine: &mut impl Machine) {
        let IncomingRequest { session, number, content: request } = request;
        let is_hello = matches!(request, Some(Request::Hello { .. }));
        if !is_hello && (self.greeted.is_none() || session != self.session) {
            let content = self.of_no_session(session, request, machine);
            return self.answer(number, content, false);
        }
        let is_new = matches!(&request, Some(Request::Hello { session, .. })
            if self.greeted != Some(*session));
        if is_new && machine.servo(|servo| servo.is_driven_for_a_link()) {
            return self.answer(number, self.identity(), false);
        }
        let overtaken = |last: u16| (number.wrapping_sub(last) as i16) < 0;
        let last = self.last.as_ref().map(|(last, _)| *last);
        let searched = self.search.map(|(searched, _)| searched);
        let is_overtaken = searched.or(last).is_some_and(overtaken);
        match (&request, last) {
            (Some(Request::Stop), last) => {
                // One that comes twice is one stop: a second one would end the first at once. The
                // number may also be that of another request, and then it is a stop.
                let is_repeated = last == Some(number);
                machine.servo(|servo| {
                    if !(is_repeated && servo.is_stopping()) {
                        servo.come_to_rest();
                    }
                });
                if !is_overtaken {
                    self.search = None;
                }
                // A request that was sent before the stop and comes after it shall not arm.
                return self.answer(number, Reply::Done, !is_overtaken);
            }
            _ if is_new => {}
            (_, Some(last)) if last == number => {
                // A client that repeats itself lives; a wire that does so for ever is none.
                if self.repeats < REPEATS {
                    self.repeats += 1;
                    machine.servo(Servo::heard);
                }
                return self.outbox.put(self.last.as_ref().map(|(_, answer)| answer), 0);
            }
            _ if is_overtaken => {
                return self.answer(number, Reply::Refused(RequestRefusal::OutOfOrder), false);
            }
            // The answer is on its way.
            _ if searched == Some(number) => return,
            _ => {}
        }
        // Another request cancels it.
        self.search = None;
        let content = match request {
            None => Reply::Refused(RequestRefusal::Unknown),
            Some(Request::Hello { protocol, session }) => self.greet(protocol, session, machine),
            Some(Request::ReadIdentification) => {
                self.repeats = 0;
                machine.servo(Servo::heard);
                self.search = Some((number, Search::default()));
                return;
            }
            Some(request) => {
                // It is new, in order, and of this session: there is a client, and it lives.
                self.repeats = 0;
                machine.servo(Servo::heard);
                self.act(request, machine).unwrap_or_else(Reply::Refused)
            }
        };
        self.answer(number, content, true);
    }

    /// Answers a request. If it is the last request there was, the answer is kept, for a request
    /// that comes twice.
    #[inline(never)]
    fn answer(&mut self, number: u16, content: Reply, is_last: bool) {
        let answer = encode(&Message::Reply(NumberedMessage { number, content }));
        self.outbox.put(answer.as_ref(), 0);
        if is_last {
            self.last = answer.map(|answer| (number, answer));
        }
    }
}

/// Goes on with the search in what an identification has found, and returns the answer at its end.
/// The servo is locked for a copy alone: a piece takes longer than a tick may wait.
#[inline(never)]
fn go_on(search: &mut Search, machine: &mut impl Machine) -> Option<Reply> {
    let Some(found) = machine.servo(|servo| servo.identified().copied()) else {
        return Some(Reply::Identification(None));
    };
    let is_over = search.go_on(&found.model, found.range);
    is_over.then(|| Reply::Identification(Some(found.summary_of(search))))
}
