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

use heapless::String;

use super::frame::{Deframer, Frame, encode};
use super::outbox::{FOR_ANSWERS, Outbox};
use super::reply::{
    DeviceKind, Identity, Message, Reply, RequestRefusal, StateCode, Status, WireErrors,
};
use super::request::{IncomingRequest, NO_SESSION, NumberedMessage, Request, decode_request};
use super::save_budget::SaveBudget;
use super::telemetry::Subscription;
use super::{CHUNK, PROTOCOL};
use crate::control::drive::DriveConfig;
use crate::control::hardware::Hardware;
use crate::control::laws::Gains;
use crate::control::signal::{self, LawSignal, SIGNALS};
use crate::identification::{self, Search};
use crate::motion::jog::JogRequest;
use crate::motion::{Course, Motion};
use crate::parameters::{Parameters, ROOM};
use crate::servo::{self, ControlLoop, Output, Servo};

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
    pub const fn tell_brown_out(&mut self, is_on: bool) {
        self.has_brown_out = is_on;
    }

    /// Sets whether the microcontroller runs from a crystal that it could not measure.
    pub const fn tell_crystal(&mut self, is_not_measured: bool) {
        self.crystal_not_measured = is_not_measured;
    }

    /// Sets the errors of the wire since the start.
    pub const fn tell_wire(&mut self, errors: WireErrors) {
        self.wire = errors;
    }

    /// Sets whether a slot of the saved parameters is damaged; reported until the next save.
    pub const fn tell_damage(&mut self, is_damaged: bool) {
        self.is_damaged = is_damaged;
    }

    /// Sets how often parameters have been saved.
    pub const fn tell_saves(&mut self, saves: u32) {
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

    /// Begins a session. Its number follows from the hello, the time and the last number: bytes
    /// that come again later are of none.
    fn greet(&mut self, protocol: u16, session: u32, machine: &mut impl Machine) -> Reply {
        self.greeted = (protocol == PROTOCOL).then_some(session);
        self.session = following(self.session, session, machine.servo(|servo| servo.clock()));
        self.subscription = Subscription::default();
        self.incoming = [0; ROOM];
        self.identity()
    }

    fn identity(&self) -> Reply {
        let version = String::try_from(crate::VERSION).unwrap_or_default();
        Reply::Hello(Identity { protocol: PROTOCOL, kind: self.kind, version })
    }

    /// Stops, and ends the session.
    fn end(&mut self, machine: &mut impl Machine) -> Reply {
        // One that comes twice is one stop.
        machine.servo(|servo| {
            if !servo.is_stopping() {
                servo.come_to_rest();
            }
        });
        self.greeted = None;
        self.subscription = Subscription::NONE;
        Reply::Done
    }

    /// Answers a request that is not of the session. Of those that change anything, a stop is
    /// obeyed, and so is a client that takes over. It is no sign of life.
    #[inline(never)]
    fn of_no_session(
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

    #[inline(never)]
    fn act(
        &mut self,
        request: Request,
        machine: &mut impl Machine,
    ) -> Result<Reply, RequestRefusal> {
        match request {
            // These were dealt with before.
            Request::Hello { .. } | Request::Stop | Request::ReadIdentification => {}
            Request::Open { .. } => return Ok(Reply::Session(self.session)),
            Request::TakeOver => return Ok(self.end(machine)),
            Request::Status => return Ok(Reply::Status(self.status(machine))),
            Request::Fault { index } => {
                let nth = |servo: &mut Servo| servo.log().iter().nth(index.into()).copied();
                return machine
                    .servo(nth)
                    .map(|fault| Reply::Fault(fault.into()))
                    .ok_or(RequestRefusal::NoSuch);
            }
            Request::Clear => machine.servo(Servo::clear)?,
            Request::Arm => machine.servo(|servo| servo.arm_for_link(None))?,
            Request::Move(motion) => self.go(&motion, machine)?,
            Request::ReadParameters { offset } => return self.read(offset),
            Request::WriteParameters { offset, bytes } => {
                let offset = usize::from(offset);
                let piece = self
                    .incoming
                    .get_mut(offset..offset + bytes.len())
                    .ok_or(RequestRefusal::NoSuch)?;
                piece.copy_from_slice(&bytes);
            }
            Request::TakeParameters { length } => self.take_parameters(length, machine)?,
            Request::Save => self.save(machine)?,
            Request::Change { entries } => self.change(&entries, machine)?,
            Request::Signal { index } => {
                let signal = signal::describe(index.into(), self.law_signals())
                    .ok_or(RequestRefusal::NoSuch)?;
                return Ok(Reply::Signal(signal.into()));
            }
            Request::Subscribe { signals, every } => {
                let known = SIGNALS.len() + self.law_signals().len();
                self.subscription =
                    Subscription::new(signals, every, known).ok_or(RequestRefusal::NoSuch)?;
            }
            Request::Identify { rate, hold } => {
                let ramp = self
                    .parameters
                    .as_ref()
                    .ok_or(RequestRefusal::NoParameters)?
                    .ramp(rate, hold)?;
                machine.servo(|servo| servo.arm_for_link(Some(ramp)))?;
            }
            Request::ReadLevels => return Ok(Reply::Levels(machine.servo(|servo| servo.levels()))),
            Request::Jog(asked) => self.jog(&asked, machine)?,
            Request::SetBrownOut => {
                machine.servo(keep_off)?;
                machine.set_brown_out()?;
            }
            Request::IdentifyJoint(asked) => self.identify(&asked, machine)?,
            Request::ReadMap => {
                let map = |servo: &mut Servo| servo.identified().map(|found| found.map);
                return Ok(Reply::Map(machine.servo(map)));
            }
            Request::SetReference { position } => {
                machine.servo(|servo| servo.set_reference(position))?;
            }
            Request::ReadJog => return Ok(Reply::Jog(machine.servo(|servo| servo.jogged()))),
        }
        Ok(Reply::Done)
    }

    #[inline(never)]
    fn take_parameters(
        &mut self,
        length: u16,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        // An armed servo refuses at once: to decode and to prepare takes milliseconds, for which an
        // armed loop's log would have to wait.
        machine.servo(|servo| refuse_if_armed(servo))?;
        let record = self.incoming.get(..length.into()).ok_or(RequestRefusal::NoSuch)?;
        let (parameters, _) = Parameters::decode(record)?;
        self.install(parameters, machine)
    }

    #[inline(never)]
    fn change(&mut self, entries: &[u8], machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        machine.servo(|servo| refuse_if_armed(servo))?;
        let before = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        let mut parameters = before.clone();
        parameters.change(entries, before)?;
        self.install(parameters, machine)
    }

    /// Installs all of the parameters or none: what is validated here is what is installed.
    #[inline(never)]
    fn install(
        &mut self,
        parameters: Parameters,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        self.prepare_and_install(&parameters, machine)?;
        self.unsaved |= self.parameters.as_ref() != Some(&parameters);
        let announced = self.law_signals();
        self.parameters = Some(parameters);
        if self.law_signals() != announced {
            // A place may be another signal's now. A client that wants it asks what it is, and
            // subscribes anew.
            self.subscription = Subscription::NONE;
        }
        Ok(())
    }

    /// Prepares the control loop before the servo is locked, and installs it. What can still be
    /// refused is refused before anything is changed.
    #[inline(never)]
    fn prepare_and_install(
        &self,
        parameters: &Parameters,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        let mut control_loop = None;
        ControlLoop::prepare(&mut control_loop, parameters, &machine.hardware())?;
        machine.servo(keep_off)?;
        if self.parameters.as_ref().is_none_or(|before| timing(before) != timing(parameters)) {
            machine.reconfigure(parameters)?;
        }
        Ok(machine.servo(|servo| servo.install(&mut control_loop))?)
    }

    #[inline(never)]
    fn save(&mut self, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let parameters = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        machine.servo(keep_off)?;
        // What is saved already costs no erase.
        if self.unsaved || self.is_damaged {
            let clock = machine.servo(|servo| servo.clock());
            self.save_budget.take(clock, parameters.controller.sample_time)?;
        }
        self.saves = machine.save(parameters)?;
        (self.unsaved, self.is_damaged) = (false, false);
        Ok(())
    }

    #[inline(never)]
    fn go(&self, motion: &Motion, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let Parameters { controller, profile, .. } =
            self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        if let Motion::Hold = motion {
            return Ok(machine.servo(Servo::hold)?);
        }
        match motion.course(controller, profile)? {
            Course::Follow(reference) => Ok(machine.servo(|servo| servo.follow(reference))?),
            Course::Profile(profile) => Ok(machine.servo(|servo| servo.go_to(profile))?),
            // A ramp begins with arming, by `Identify`.
            Course::Ramp(_) | Course::Jog(_) | Course::Identification(_) => {
                Err(RequestRefusal::NoSuch)
            }
        }
    }

    #[inline(never)]
    fn jog(&self, asked: &JogRequest, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let jog = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?.jog(asked)?;
        Ok(machine.servo(|servo| servo.jog(jog))?)
    }

    #[inline(never)]
    fn identify(
        &self,
        asked: &identification::IdentificationRequest,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        let settings =
            self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?.identify(asked)?;
        Ok(machine.servo(|servo| servo.identify(&settings))?)
    }

    #[inline(never)]
    fn read(&self, offset: u16) -> Result<Reply, RequestRefusal> {
        let parameters = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        let mut room = [0; ROOM];
        // Cannot fail: every record fits.
        let record = parameters.encode(0, &mut room).ok_or(RequestRefusal::NotWhole)?;
        let rest = record.get(offset.into()..).ok_or(RequestRefusal::NoSuch)?;
        let bytes = rest.iter().copied().take(CHUNK).collect();
        Ok(Reply::Parameters { length: record.len() as u16, offset, bytes })
    }

    /// Returns the signals that the law in use publishes of itself.
    fn law_signals(&self) -> &'static [LawSignal] {
        let laws = self.parameters.iter().flat_map(|parameters| &parameters.controller.compensator);
        laws.map(Gains::signals).find(|signals| !signals.is_empty()).unwrap_or_default()
    }

    #[inline(never)]
    fn status(&self, machine: &mut impl Machine) -> Status {
        let controller = self.parameters.as_ref().map(|parameters| &parameters.controller);
        let (bad_frames, dropped) = (self.deframer.bad(), self.outbox.dropped());
        let (unsaved, is_damaged, saves) = (self.unsaved, self.is_damaged, self.saves);
        let Self { has_brown_out, crystal_not_measured, wire, .. } = *self;
        machine.servo(|servo| Status {
            state: StateCode::from(servo.state()),
            fault: servo.latched().map(Into::into).unwrap_or_default(),
            faults: servo.log().count(),
            clock: servo.clock(),
            sample_time: controller.map_or(0.0, |controller| controller.sample_time),
            position: servo.position(),
            resolution: controller.map_or(0.0, |controller| controller.encoder.resolution),
            at_rest: servo.is_at_rest(),
            wound_up: servo.is_wound_up(),
            thermal_effort: servo.thermal_effort(),
            unsaved,
            is_damaged,
            saves,
            bad_frames,
            dropped,
            has_brown_out,
            wire,
            crystal_not_measured,
            gave_up: servo.has_given_up(),
            is_encoder_in_doubt: servo.is_encoder_in_doubt(),
            oscillates: servo.is_oscillating(),
            is_referenced: servo.is_referenced(),
        })
    }
}

/// Returns the number of the session after `last` that a hello begins at a tick. Its bits are mixed
/// by a multiplication with an odd constant (2^32 over the golden ratio) and a shift. It is odd, so
/// that it is none of no session.
const fn following(last: u32, hello: u32, clock: u32) -> u32 {
    let mixed = (last ^ hello.rotate_left(13) ^ clock.rotate_left(7)).wrapping_mul(0x9E37_79B9);
    let number = (mixed ^ (mixed >> 15)) | 1;
    if number == last { number ^ 2 } else { number }
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

fn refuse_if_armed(servo: &Servo) -> Result<(), servo::Refusal> {
    match servo.state() {
        servo::State::Armed => Err(servo::Refusal::Armed),
        _ => Ok(()),
    }
}

/// Turns autostart off, for what takes longer than a tick with the output off: the servo must not
/// arm itself meanwhile. An armed servo refuses.
fn keep_off(servo: &mut Servo) -> Result<(), servo::Refusal> {
    refuse_if_armed(servo)?;
    servo.stop();
    Ok(())
}

/// Returns what bridge, timers and watchdog are set up with: sample time, PWM, dead time, blanking.
const fn timing(parameters: &Parameters) -> (f32, &DriveConfig, f32, f32) {
    let Parameters { controller, device, .. } = parameters;
    (controller.sample_time, &controller.drive, device.dead_time, device.fault_blanking)
}
