//! The session of a link: which requests a client may send, and how the device answers them.
//!
//! A session begins with a hello, and the device chooses its number. A request that is not of the
//! session may only read, stop and take over: bytes of an earlier session change nothing. While the
//! motor is driven for a link, the session has an owner, and no other hello begins one. A client
//! that takes over stops the motor and ends the session. Each request is answered once, with its
//! own number. A repeated request is not executed again: its answer is sent again. A request that
//! was overtaken by a later one is refused. Stop is obeyed at all times. Only the answer to
//! [`Request::ReadIdentification`] needs long to compute; another request before it cancels it.
//!
//! Answers and samples wait in a ring of bytes until the wire takes them. Samples leave room for
//! answers. A frame that finds no room is dropped and counted, and the numbers of the samples show
//! the gap. The program that creates a session chooses the length of the ring: a host uses
//! [`WAITING`], a board what its RAM allows.

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

/// Default length of the ring for bytes that wait for the wire, bytes.
pub const WAITING: usize = 2048;

/// Number of repetitions of a request that count as signs of life: a client sends it three times,
/// with two answers lost, before it gives up.
const REPEATS: u8 = 2;

/// The machine on which a session acts. A board locks its servo for as short as possible; a host
/// accesses it directly.
pub trait Machine {
    /// Runs a function on the servo, and returns its result.
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R;

    /// Returns the figures of the machine's timers and converters.
    fn hardware(&self) -> Hardware;

    /// Saves parameters, which then survive a reset. The output is off.
    ///
    /// Returns the number of saves so far.
    ///
    /// # Errors
    /// Returns an error if the flash fails, if the watchdog does not accept the timeout for the
    /// save, or if the supply is too low.
    fn save(&mut self, parameters: &Parameters) -> Result<u32, RequestRefusal>;

    /// Prepares timers, watchdog and brake resistor for new parameters before these are in use:
    /// their sample time, PWM and dead time. The output is off, and stays so.
    ///
    /// # Errors
    /// Returns an error if the watchdog cannot follow. Nothing has changed then.
    fn reconfigure(&mut self, parameters: &Parameters) -> Result<(), RequestRefusal>;

    /// Turns the microcontroller's brown-out reset on permanently, from the next reset on. The
    /// output is off.
    ///
    /// # Errors
    /// Returns an error if there is no brown-out reset, if its option bytes must not be changed, or
    /// if the flash fails.
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
    /// Whether the parameters in use were changed and not saved since.
    unsaved: bool,
    /// Number of repetitions of the last request that counted as signs of life.
    repeats: u8,
    /// Whether a slot of the saved parameters is damaged.
    is_damaged: bool,
    /// Number of saves of parameters so far, and the budget for more.
    saves: u32,
    save_budget: SaveBudget,
    /// Whether the microcontroller's brown-out reset is on.
    has_brown_out: bool,
    /// Whether the microcontroller runs from a crystal that it could not measure.
    crystal_not_measured: bool,
    wire: WireErrors,
    /// The number in the hello that began the session; none before a hello.
    greeted: Option<u32>,
    /// Number of the session; after its end, the number of the last one.
    session: u32,
    /// The number of the last request that was answered, and the answer.
    last: Option<(u16, Frame)>,
    /// Number of a pending request for the result of an identification, and the search for its
    /// answer.
    search: Option<(u16, Search)>,
    /// The record that the client is transferring, as far as it has been received.
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

    /// Sets the parameters in use to the saved ones.
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

    /// Sets the receive errors of the link's wire, counted since the microcontroller's start. The
    /// session reports them in its status.
    pub const fn report_wire(&mut self, errors: WireErrors) {
        self.wire = errors;
    }

    /// Sets whether a slot of the saved parameters is damaged; reported until the next save.
    pub const fn report_damage(&mut self, is_damaged: bool) {
        self.is_damaged = is_damaged;
    }

    /// Sets the number of saves of parameters so far.
    pub const fn report_saves(&mut self, saves: u32) {
        self.saves = saves;
    }

    /// Decodes bytes from the wire, and executes the requests in them.
    #[inline(never)]
    pub fn receive(&mut self, bytes: &[u8], machine: &mut impl Machine) {
        for &byte in bytes {
            let Some(message) = self.deframer.push(byte) else { continue };
            let Some(request) = Self::request(message) else { continue };
            self.take(request, machine);
        }
    }

    /// Computes one piece of a long answer, and returns whether pieces remain. Between two pieces
    /// the other tasks run.
    #[inline(never)]
    pub fn work(&mut self, machine: &mut impl Machine) -> bool {
        let Some((number, search)) = &mut self.search else { return false };
        let Some(reply) = go_on(search, machine) else { return true };
        let number = *number;
        self.search = None;
        self.answer(number, reply, true);
        false
    }

    /// Decodes a request. It is a separate function, so that its stack is free again when the
    /// request is executed.
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

    /// Copies waiting bytes to `bytes`, for the wire, and returns their number.
    pub fn transmit(&mut self, bytes: &mut [u8]) -> usize {
        self.outbox.take(bytes)
    }

    /// Returns the number of the session, which the device reports to the client that began it.
    pub const fn number(&self) -> u32 {
        self.session
    }

    /// Returns the parameters in use, if there are any.
    pub const fn parameters(&self) -> Option<&Parameters> {
        self.parameters.as_ref()
    }

    /// Executes a request, or sends the answer to a repeated one again.
    ///
    /// The steps are functions that are not inlined, so that their frames follow each other on the
    /// stack and do not add up: a board has little stack.
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
                // A repeated stop is one stop: a second one would end the first at once. The number
                // may also be that of another request, and then it is a new stop.
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
                // A client that repeats a request is alive; a wire that repeats it forever is no
                // client.
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
        // Another request cancels the search.
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
                // The request is new, in order, and of this session: there is a client, and it is
                // alive.
                self.repeats = 0;
                machine.servo(Servo::heard);
                self.act(request, machine).unwrap_or_else(Reply::Refused)
            }
        };
        self.answer(number, content, true);
    }

    /// Sends the answer to a request. If the request is the latest one, the answer is kept, in case
    /// that request is repeated.
    #[inline(never)]
    fn answer(&mut self, number: u16, content: Reply, is_last: bool) {
        let answer = encode(&Message::Reply(NumberedMessage { number, content }));
        self.outbox.put(answer.as_ref(), 0);
        if is_last {
            self.last = answer.map(|answer| (number, answer));
        }
    }
}

/// Runs one piece of the search in the findings of an identification, and returns the answer at its
/// end. The servo is locked only for a copy of the findings: a piece lasts longer than a tick can
/// wait.
#[inline(never)]
fn go_on(search: &mut Search, machine: &mut impl Machine) -> Option<Reply> {
    let Some(found) = machine.servo(|servo| servo.identified().copied()) else {
        return Some(Reply::Identification(None));
    };
    let is_over = search.go_on(&found.model, found.range);
    is_over.then(|| Reply::Identification(Some(found.summary_of(search))))
}
