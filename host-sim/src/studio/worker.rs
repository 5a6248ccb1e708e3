//! The thread of the device.
//!
//! While the output is off, it requests the status ten times a second. While the output is on, it
//! sends a request only after a keep-alive of the page that commands, since each valid request is a
//! keep-alive of the device, and only that page may send one. Samples arrive without requests. If
//! something other than a page has turned the output on, the status is requested once, and then at
//! intervals of more than two link timeouts, by which time a silent link has turned the output off.
//!
//! If the device's link timeout is off, the device does not react to a silent link. If it was armed
//! here, the thread then stops it after [`QUIET`] without a keep-alive; a device that was armed
//! elsewhere is not stopped.
//!
//! A request is executed if its page still commands and if it is not older than [`LATE`]: a motor
//! must not move for a button that was pressed before a save that took seconds.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use serde_json::json;
use stiction::Parameters;
use stiction::control::signal::name;
use stiction::link::{Sample, StateCode, Status};
use stiction::motion::home::HomeTarget;

use super::control::TAKEN;
use super::desk::{DeviceThreadGuard, QueuedRequest, StudioState};
use super::news::SampleFrame;
use super::orders::MotionReport;
use super::pending_gear::{MEASURING, PendingGear, STOPPED};
use super::selftest::SelftestPhase;
use files::error::Error;
use simulator::device::client::Client;
use simulator::device::signals::Signals;
use simulator::device::travel::Travel;
use simulator::device::wire::Wire;
use studies::device_gear::PrecedingSequence;

/// Time between two requests for the status: a fifth of the default link timeout.
const ASKED: Duration = Duration::from_millis(100);

/// Age at which a page's keep-alive is no longer valid. A page sends a keep-alive for each message
/// about the device, at most twenty a second.
const FRESH: Duration = Duration::from_millis(150);

/// Silence of the page after which the thread stops a device without a link timeout.
const QUIET: Duration = Duration::from_millis(500);

/// Age at which a request is refused.
const LATE: Duration = Duration::from_secs(1);

/// Answer to a request while a self-test moves the joint.
const TESTING: &str =
    "a self-test moves the joint, and other requests are refused meanwhile; stop ends it";

/// Answer to a request that a stop has overtaken.
const OVERTAKEN: &str = "a stop came first, and this request was dropped; send it again";

/// Reason of a prediction that a stop has ended.
pub(super) const CANCELLED_BY_STOP: &str =
    "the prediction of the self-test was cancelled by a stop";

/// Time between two frames of samples.
const FRAME: Duration = Duration::from_millis(30);

/// Longest wait for a sample; a request that arrives meanwhile waits as well.
const SLICE: Duration = Duration::from_millis(10);

/// Time between two attempts to reach a device that is gone.
const AGAIN: Duration = Duration::from_secs(1);

/// Time within which a stop is answered while the device is gone.
const LOOKS: Duration = Duration::from_millis(100);

const SILENT: &str =
    "the device does not answer. If the motor moves, cut its supply. The studio tries to reconnect";

/// A motion that ends automatically and has a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunningMotion {
    /// A jog.
    Jog,
    /// A homing.
    Homing(HomeTarget),
    /// The sequence that identifies a joint, and the number of the page that started it.
    Identification(PrecedingSequence, u64),
    /// A ramp of this rate, V/s.
    Ramp(f32),
}

/// Facts about the studio's device that the device itself cannot report.
#[derive(Clone, Debug)]
pub struct DeviceContext {
    /// Machine's file that provides the joint of a pulled file.
    pub machine: String,
    /// Whether `machine` is the file of this device, not a replacement.
    pub is_its_file: bool,
    /// Whether the device sends a sample of every tick, since no wire limits the rate.
    pub every_tick: bool,
}

/// A session with the device.
pub struct Worker<'a, W> {
    pub(super) client: Client<W>,
    pub(super) shared: &'a StudioState,
    pub(super) about: &'a DeviceContext,
    pub(super) running: Option<RunningMotion>,
    /// The self-test and its phase.
    pub(super) test: Option<SelftestPhase>,
    /// Moves for the gear that are not over.
    pub(super) gear: Option<PendingGear>,
    /// Parameters before each change of this session, the latest last.
    pub(super) before: Vec<Parameters>,
    /// Parameters that a reset restores, if known.
    pub(super) saved: Option<Parameters>,
    pub(super) signals: Signals,
    pub(super) frame: SampleFrame,
    /// Subscribed signals as a mask, and the ticks from one sample to the next.
    pub(super) subscribed: (u64, u16),
    /// The same, as the pages need it.
    pub(super) of_pages: (u64, u16),
    flushed: Duration,
    /// Whether the output was on in the last message.
    pub(super) driven: bool,
    /// Whether a page of this studio has turned the output on.
    pub(super) armed_here: bool,
    /// Number of faults in the last status.
    faults: Option<u32>,
    asked: Duration,
    /// Time of the last keep-alive of the page that commands.
    word: Option<Duration>,
    /// Time at which this thread saw that keep-alive.
    heard: Duration,
    /// Link timeout of the device, s; zero if it is off.
    pub(super) link_timeout: f32,
    /// Range of the targets of typed moves; none without parameters.
    pub(super) travel: Option<Travel>,
    /// Last sample; its set point is published with the start of a move.
    pub(super) last: Option<Sample>,
}

/// Serves the device until all senders of requests are gone. `ready` receives the result of the
/// first connection.
pub fn run<W: Wire>(
    open: impl Fn() -> Result<W, Error>,
    about: &DeviceContext,
    shared: &StudioState,
    orders: &Receiver<QueuedRequest>,
    ready: &SyncSender<Result<(), Error>>,
) {
    let _talking = DeviceThreadGuard(shared);
    let begin = |stop: bool| {
        let mut client = Client::connect(open()?)?;
        if stop {
            client.stop()?;
        }
        Worker::new(client, shared, about)
    };
    let mut worker = match begin(false) {
        Ok(worker) => worker,
        Err(error) => return drop(ready.send(Err(error))),
    };
    worker.publish_no_test(None);
    let _ = ready.send(Ok(()));
    loop {
        let Err(error) = worker.work(orders) else { return };
        // Once the device can be reached, it is stopped first if it was armed here. If it has
        // refused a request, it was reset or another client has taken it over: its motor was off,
        // and a client other than this studio may drive it now.
        let was_armed = worker.armed_here && !matches!(error, Error::Refused(_));
        let driven = if worker.driven {
            ". THE MOTOR MAY STILL BE DRIVEN: cut the motor's supply"
        } else {
            ""
        };
        // For a new page the last status is no longer valid, nor is the last motion, since the
        // device may have been reset meanwhile.
        shared.news.forget("status");
        shared.news.forget("motion");
        // The joint is known although the device is gone.
        worker.publish_gear(Err(format!("its moves were ended: {error}")));
        shared.news.publish("gone", json!({ "said": format!("{error}{driven}") }));
        if worker.test.is_some() {
            let why = "selftest: the device did not answer; predict the self-test again";
            worker.publish_no_test(Some(why.into()));
        }
        // The wire is closed before it is opened again.
        drop(worker);
        worker = loop {
            // Requests meanwhile delay neither the next attempt nor the answer to a stop.
            let next = Instant::now() + AGAIN;
            loop {
                shared.refuse_stops(SILENT);
                let left = next.saturating_duration_since(Instant::now());
                match orders.recv_timeout(left.min(LOOKS)) {
                    Ok(order) => order.answered(&Err(Error::Device(SILENT.into()))),
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if left.is_zero() {
                    break;
                }
            }
            if let Ok(worker) = begin(was_armed) {
                break worker;
            }
        };
        shared.news.forget("gone");
        shared.news.publish("back", json!({}));
        // Not kept: a page that connects later has not seen `gone`.
        shared.news.forget("back");
    }
}

impl<'a, W: Wire> Worker<'a, W> {
    pub(super) fn new(
        mut client: Client<W>,
        shared: &'a StudioState,
        about: &'a DeviceContext,
    ) -> Result<Self, Error> {
        client.wire().real_time();
        let now = shared.now();
        let mut worker = Self {
            client,
            shared,
            about,
            running: None,
            test: None,
            gear: None,
            before: Vec::new(),
            saved: None,
            signals: Signals::default(),
            frame: SampleFrame::default(),
            subscribed: (0, 0),
            of_pages: (0, 0),
            flushed: now,
            driven: false,
            armed_here: false,
            faults: None,
            asked: now,
            word: shared.last_keep_alive(),
            heard: now,
            link_timeout: 0.0,
            travel: None,
            last: None,
        };
        let status = worker.client.status()?;
        if !status.unsaved {
            worker.saved = worker.client.parameters().ok();
        }
        worker.publish_device()?;
        worker.publish_faults(&status)?;
        worker.publish_status(&status);
        Ok(worker)
    }

    /// Works until no sender of requests is left, or the device does not answer.
    fn work(&mut self, orders: &Receiver<QueuedRequest>) -> Result<(), Error> {
        while self.pass(orders)? {}
        Ok(())
    }

    /// Executes a waiting request, if any, and waits a moment for messages of the device. Returns
    /// whether a sender of requests is left.
    pub(super) fn pass(&mut self, orders: &Receiver<QueuedRequest>) -> Result<bool, Error> {
        self.stop_if_asked(orders)?;
        match orders.try_recv() {
            // No status is requested here: only the self-test's own page may keep it going.
            Ok(order) if self.is_testing() || self.gear.is_some() => {
                let why = if self.is_testing() { TESTING } else { MEASURING };
                order.answered(&Err(Error::Refused(why.into())));
            }
            Ok(order) => {
                let done = self.is_expected(&order).and_then(|()| self.execute(&order));
                order.answered(&done);
                self.asked = self.shared.now();
                if let Err(error @ (Error::Device(_) | Error::Emulator(_))) = done {
                    return Err(error);
                }
                // Publishes its effects at once.
                self.ask_status()?;
            }
            Err(TryRecvError::Disconnected) => return Ok(false),
            Err(TryRecvError::Empty) => {}
        }
        self.listen();
        self.take_prediction();
        let is_left = self.since(self.heard) > QUIET || !self.has_its_page();
        if self.link_timeout == 0.0 && self.armed_here && is_left {
            self.client.stop()?;
            self.ask_status()?;
        }
        if self.may_ask() {
            let status = self.ask_status()?;
            if self.client.is_guest() && !self.driven {
                // The other client has ended.
                self.client.begin_session()?;
                self.publish_device()?;
            }
            self.go_on_testing(&status)?;
            self.go_on_with_gear(&status)?;
            let may_go_on = !self.driven || self.has_keep_alive();
            if may_go_on && self.faults.replace(status.faults).is_some_and(|b| b != status.faults) {
                self.publish_faults(&status)?;
            }
        }
        let (sample, before) = (self.client.sample(SLICE)?, self.driven);
        sample.into_iter().for_each(|sample| self.show(sample));
        self.show_kept();
        // Something other than a page has turned the output on; the pages must show that.
        if self.driven && !before {
            self.ask_status()?;
        }
        if self.since(self.flushed) >= FRAME {
            self.flushed = self.shared.now();
            self.frame.flush(&self.shared.news);
        }
        Ok(true)
    }

    /// Returns the time that has passed on the clock since a time.
    fn since(&self, time: Duration) -> Duration {
        self.shared.now().saturating_sub(time)
    }

    /// Passes a sample to the pages and to the self-test. If the studio is a guest, samples are
    /// ignored, since another client has selected their signals.
    fn show(&mut self, sample: Sample) {
        if self.client.is_guest() {
            return;
        }
        self.driven = self.signals.is_armed(&sample);
        self.frame.push(&sample, &self.shared.news);
        self.test_sees(&sample);
        if let Some(gear) = &mut self.gear {
            gear.see(&sample);
        }
        self.last = Some(sample);
    }

    /// Passes on the samples that arrived during a request.
    pub(super) fn show_kept(&mut self) {
        while let Some(sample) = self.client.kept() {
            self.show(sample);
        }
    }

    /// Turns the output off if a stop is requested. Waiting requests are refused.
    fn stop_if_asked(&mut self, orders: &Receiver<QueuedRequest>) -> Result<(), Error> {
        let Some(stops) = self.shared.take_stops() else { return Ok(()) };
        let waiting: Vec<QueuedRequest> = orders.try_iter().collect();
        let stopped = self.client.stop();
        // If this failed, the stop is sent again first once the device can be reached.
        self.armed_here |= stopped.is_err();
        self.running = None;
        self.cancel_prediction(CANCELLED_BY_STOP);
        let failed = |error: &Error| Err(Error::Device(error.to_string()));
        let overtaken = || Err(Error::Refused(OVERTAKEN.into()));
        for order in waiting {
            order.answered(&stopped.as_ref().map_or_else(failed, |()| overtaken()));
        }
        for order in stops {
            let done = || Ok("stopped: the motor is off".into());
            order.answered(&stopped.as_ref().map_or_else(failed, |()| done()));
        }
        stopped?;
        self.end_gear(Err(STOPPED.into()))?;
        self.ask_status().map(|_| ())
    }

    /// Updates the zero of the arming, from which targets count.
    fn follow_travel(&mut self, status: &Status) {
        let armed = self.last.as_ref().filter(|sample| self.signals.is_armed(sample));
        let sample = armed.map(|sample| {
            let ticks = status.clock.wrapping_sub(sample.clock) as i32;
            let counts = self.signals.number(sample, const { name("counts") }) as i32;
            (f64::from(ticks) * f64::from(status.sample_time), counts)
        });
        if let Some(travel) = &mut self.travel {
            travel.follow(status, sample);
        }
    }

    /// Checks a typed target, deg from the zero of the arming.
    pub(super) fn check_target(&self, what: &str, deg: f64) -> Result<(), Error> {
        self.travel.map_or(Ok(()), |travel| travel.check(what, deg))
    }

    /// Reads the time of the last keep-alive of the page that commands.
    fn listen(&mut self) {
        let word = self.shared.last_keep_alive();
        if word != self.word {
            (self.word, self.heard) = (word, self.shared.now());
        }
    }

    /// Refuses a request that must no longer be executed: a stop has overtaken it, its page no
    /// longer commands, or it is too old.
    pub(super) fn is_expected(&self, order: &QueuedRequest) -> Result<(), Error> {
        let why = if self.shared.is_stop_wanted() {
            OVERTAKEN
        } else if !self.shared.control.is_held_by(order.page) {
            TAKEN
        } else if self.since(order.given) >= LATE {
            "the device was busy, and this request was dropped; send it again"
        } else {
            return Ok(());
        };
        Err(Error::Refused(why.into()))
    }

    /// Returns whether the status may be requested. If the output is on and no keep-alives arrive,
    /// the device is queried only when its link timeout is long over, for the case that its samples
    /// are lost. A request of a guest is no keep-alive of another client's motor.
    fn may_ask(&self) -> bool {
        let is_over = Duration::from_secs_f32(1.0 + 2.0 * self.link_timeout.clamp(0.0, 60.0));
        let since = self.since(self.asked);
        let is_harmless = !self.driven || self.client.is_guest() || self.has_keep_alive();
        since >= ASKED && is_harmless || since > is_over
    }

    /// Returns whether the page that commands has just sent a keep-alive. While a self-test moves
    /// the joint, only the page that started the test counts. The age counts from the time of the
    /// keep-alive, not from the time at which this thread saw it.
    pub(super) fn has_keep_alive(&self) -> bool {
        let is_held = !self.shared.control.is_free() && self.has_its_page();
        is_held && self.shared.last_keep_alive().is_some_and(|word| self.since(word) < FRESH)
    }

    /// Publishes the result of a motion that has ended.
    pub(super) fn publish_found(&self, found: Result<MotionReport, Error>) -> Result<(), Error> {
        let report = match found {
            Err(error @ (Error::Device(_) | Error::Emulator(_))) => return Err(error),
            found => found.unwrap_or_else(|error| MotionReport::bad(error.to_string())),
        };
        self.publish_report(&report);
        Ok(())
    }

    /// Publishes a result in words.
    pub(super) fn publish_report(&self, MotionReport { said, grade }: &MotionReport) {
        self.shared.news.publish("found", json!({ "said": said, "grade": grade }));
        self.shared.news.forget("found");
    }

    pub(super) fn ask_status(&mut self) -> Result<Status, Error> {
        self.asked = self.shared.now();
        let status = self.client.status()?;
        // Samples from before the answer may show an output that was off then.
        self.show_kept();
        self.driven = status.state == StateCode::Armed;
        self.armed_here &= self.driven && !self.client.is_guest();
        self.follow_travel(&status);
        self.testing_since(status.clock);
        if !self.driven
            && let Some(running) = self.running.take()
        {
            // None: moves for the gear follow, and the result comes after them.
            if let Some(found) = self.found(running).transpose() {
                self.publish_found(found)?;
            }
        }
        if !self.driven {
            self.end_testing(&status);
            self.gear_is_off(&status)?;
        }
        self.publish_status(&status);
        Ok(status)
    }
}
