//! The thread that talks to the device.
//!
//! While the output is off it asks for the status ten times a second. While the output is on it
//! asks only after a word of the page that commands, since each request in order is a sign of life
//! to the device: nobody else may give it. Samples come without being asked for, and go on. What
//! something else has turned on is asked once when that is seen. After that it is asked at
//! intervals of more than two link timeouts: whatever a silent link turns off is off by then.
//!
//! If the device's link timeout is off, nothing on the device looks at the silence. The thread then
//! stops by itself after [`QUIET`] what was armed here. It leaves alone what runs without it.
//!
//! An order is obeyed if the page that gave it still commands, and if it is not [`LATE`]: nobody
//! expects a motor to move for a button that was pressed before a save that took seconds.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use serde_json::json;
use stiction::Parameters;
use stiction::control::signal::name;
use stiction::link::{Sample, StateCode, Status};

use super::control::TAKEN;
use super::desk::{Order, Shared, Talking};
use super::news::Frame;
use super::orders::Report;
use super::selftest::Test;
use crate::device::client::Client;
use crate::device::signals::Signals;
use crate::device::travel::Travel;
use crate::device::wire::Wire;
use crate::error::Error;

/// Time between two requests for the status: a fifth of the default link timeout.
const ASKED: Duration = Duration::from_millis(100);

/// Age at which a word of the page is no sign of life any more: a page that lives gives one with
/// every frame, but not more than twenty a second.
const FRESH: Duration = Duration::from_millis(150);

/// Silence of the page after which the thread stops a device whose link timeout is off.
const QUIET: Duration = Duration::from_millis(500);

/// Age at which an order is not obeyed any more.
const LATE: Duration = Duration::from_secs(1);

/// What is said to an order while a self-test moves the joint.
const TESTING: &str =
    "a self-test moves the joint, and nothing else is done meanwhile; stop ends it";

/// What is said to an order that a stop has passed.
const OVERTAKEN: &str = "a stop came first; say it again";

/// What is said of a prediction that a stop has ended.
pub(super) const CANCELLED_BY_STOP: &str =
    "the prediction of the self-test was cancelled by a stop";

/// Time between two frames.
const FRAME: Duration = Duration::from_millis(30);

/// Time within which an order is seen.
const SLICE: Duration = Duration::from_millis(10);

/// Time between two tries to reach a device that is gone.
const AGAIN: Duration = Duration::from_secs(1);

/// Time within which a stop is answered meanwhile.
const LOOKS: Duration = Duration::from_millis(100);

const SILENT: &str = "the device does not answer";

/// A motion that ends by itself and has found something then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Running {
    /// A jog.
    Jog,
    /// The sequence that identifies a joint.
    Identification,
    /// A ramp of so many V/s.
    Ramp(f32),
}

/// What the studio is told of its device, which the device does not know.
#[derive(Clone, Debug)]
pub struct About {
    /// Whose joint a pulled file has.
    pub machine: String,
    /// Whether that is the file of this device, and not one that stands in for it.
    pub is_its_file: bool,
    /// Whether every tick is sent, however many bytes that takes: the wire is none.
    pub every_tick: bool,
}

/// A session with the device.
pub struct Worker<'a, W> {
    pub(super) client: Client<W>,
    pub(super) shared: &'a Shared,
    pub(super) about: &'a About,
    pub(super) running: Option<Running>,
    /// The self-test, as far as it is.
    pub(super) test: Option<Test>,
    /// Parameters that were in use before changes of this session, the latest last.
    pub(super) before: Vec<Parameters>,
    /// Those that a reset would bring back, as far as they are known.
    pub(super) saved: Option<Parameters>,
    pub(super) signals: Signals,
    pub(super) frame: Frame,
    flushed: Instant,
    /// Whether the output is on, as far as was last heard.
    pub(super) driven: bool,
    /// Whether a page of this studio has turned it on.
    pub(super) armed_here: bool,
    /// How many faults the device remembered when it was last asked.
    faults: Option<u32>,
    asked: Instant,
    /// The last word of the page that commands that was seen, and when that was.
    word: Option<Instant>,
    heard: Instant,
    /// s; zero if it is off.
    pub(super) link_timeout: f32,
    /// Range of the targets of typed moves; none without parameters.
    pub(super) travel: Option<Travel>,
    /// The last sample: where the set point is, for who is told of a move.
    pub(super) last: Option<Sample>,
}

/// Talks to the device until nobody has an order any more. `ready` hears whether it was there.
pub fn run<W: Wire>(
    open: impl Fn() -> Result<W, Error>,
    about: &About,
    shared: &Shared,
    orders: &Receiver<Order>,
    ready: &SyncSender<Result<(), Error>>,
) {
    let _talking = Talking(shared);
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
    worker.tell_no_test(None);
    let _ = ready.send(Ok(()));
    loop {
        let Err(error) = worker.work(orders) else { return };
        // What was driven from here is stopped before anything else, once it can be reached.
        let was_armed = worker.armed_here;
        let driven = if worker.driven { ". THE MOTOR MAY STILL BE DRIVEN" } else { "" };
        // A page that comes now must not take the last status for what the device does, nor the
        // last motion for one in the time of a device that was reset meanwhile.
        shared.news.forget("status");
        shared.news.forget("motion");
        shared.news.tell("gone", json!({ "said": format!("{error}{driven}") }));
        if worker.test.is_some() {
            let why = "selftest: the device did not answer; predict it anew";
            worker.tell_no_test(Some(why.into()));
        }
        // The wire is closed before it is opened again.
        drop(worker);
        worker = loop {
            // Orders that come meanwhile delay neither the next try nor the answer to a stop.
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
        shared.news.tell("back", json!({}));
        // Nobody is told it again: it was gone, and a page that comes later never heard of that.
        shared.news.forget("back");
    }
}

impl<'a, W: Wire> Worker<'a, W> {
    pub(super) fn new(
        mut client: Client<W>,
        shared: &'a Shared,
        about: &'a About,
    ) -> Result<Self, Error> {
        client.wire().real_time();
        let now = Instant::now();
        let mut worker = Self {
            client,
            shared,
            about,
            running: None,
            test: None,
            before: Vec::new(),
            saved: None,
            signals: Signals::default(),
            frame: Frame::default(),
            flushed: now,
            driven: false,
            armed_here: false,
            faults: None,
            asked: now,
            word: shared.word(),
            heard: now,
            link_timeout: 0.0,
            travel: None,
            last: None,
        };
        let status = worker.client.status()?;
        if !status.unsaved {
            worker.saved = worker.client.parameters().ok();
        }
        worker.introduce()?;
        worker.tell_faults(&status)?;
        worker.tell_status(&status);
        Ok(worker)
    }

    /// Works until there is nobody left to work for, or the device does not answer.
    fn work(&mut self, orders: &Receiver<Order>) -> Result<(), Error> {
        while self.pass(orders)? {}
        Ok(())
    }

    /// Obeys an order, if one waits, and waits for a moment for what the device sends. Tells
    /// whether anybody is left to work for.
    pub(super) fn pass(&mut self, orders: &Receiver<Order>) -> Result<bool, Error> {
        self.stop_if_asked(orders)?;
        match orders.try_recv() {
            // Not even the status is asked for then: nobody but its own page keeps a self-test
            // going.
            Ok(order) if self.is_testing() => {
                order.answered(&Err(Error::Refused(TESTING.into())));
            }
            Ok(order) => {
                let done = self.is_expected(&order).and_then(|()| self.obey(&order));
                order.answered(&done);
                self.asked = Instant::now();
                if let Err(error @ (Error::Device(_) | Error::Emulator(_))) = done {
                    return Err(error);
                }
                // What it has changed is told at once.
                self.ask_status()?;
            }
            Err(TryRecvError::Disconnected) => return Ok(false),
            Err(TryRecvError::Empty) => {}
        }
        self.listen();
        self.take_prediction();
        let is_left = self.heard.elapsed() > QUIET || !self.has_its_page();
        if self.link_timeout == 0.0 && self.armed_here && is_left {
            self.client.stop()?;
            self.ask_status()?;
        }
        if self.may_ask() {
            let status = self.ask_status()?;
            self.go_on_testing(&status)?;
            let may_go_on = !self.driven || self.has_word();
            if may_go_on && self.faults.replace(status.faults).is_some_and(|b| b != status.faults) {
                self.tell_faults(&status)?;
            }
        }
        let (sample, before) = (self.client.sample(SLICE)?, self.driven);
        sample.into_iter().for_each(|sample| self.show(sample));
        self.show_kept();
        // Something else than a page has turned it on. Nobody may take it for off.
        if self.driven && !before {
            self.ask_status()?;
        }
        if self.flushed.elapsed() >= FRAME {
            self.flushed = Instant::now();
            self.frame.flush(&self.shared.news);
        }
        Ok(true)
    }

    /// Shows the pages a sample, and the self-test.
    fn show(&mut self, sample: Sample) {
        self.driven = self.signals.is_armed(&sample);
        self.frame.push(&sample, &self.shared.news);
        self.test_sees(&sample);
        self.last = Some(sample);
    }

    /// Shows those that have come meanwhile.
    pub(super) fn show_kept(&mut self) {
        while let Some(sample) = self.client.kept() {
            self.show(sample);
        }
    }

    /// Turns the output off if somebody wants that. No order that waits is obeyed any more.
    fn stop_if_asked(&mut self, orders: &Receiver<Order>) -> Result<(), Error> {
        let Some(stops) = self.shared.take_stops() else { return Ok(()) };
        let waiting: Vec<Order> = orders.try_iter().collect();
        let stopped = self.client.stop();
        // It is said again first of all once the device can be reached.
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
        self.ask_status().map(|_| ())
    }

    /// Updates the zero of the arming, from which targets are typed.
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

    /// Looks whether the page that commands has given a word.
    fn listen(&mut self) {
        let word = self.shared.word();
        if word != self.word {
            (self.word, self.heard) = (word, Instant::now());
        }
    }

    /// Refuses an order that nobody expects to be obeyed any more.
    pub(super) fn is_expected(&self, order: &Order) -> Result<(), Error> {
        let why = if self.shared.is_stop_wanted() {
            OVERTAKEN
        } else if !self.shared.control.is_held_by(order.page) {
            TAKEN
        } else if order.given.elapsed() >= LATE {
            "the device was busy; say it again"
        } else {
            return Ok(());
        };
        Err(Error::Refused(why.into()))
    }

    /// Whether the status may be asked for. A device that is driven and that nobody keeps alive is
    /// asked once its link timeout is long over, in case its samples do not come.
    fn may_ask(&self) -> bool {
        let is_over = Duration::from_secs_f32(1.0 + 2.0 * self.link_timeout.clamp(0.0, 60.0));
        let since = self.asked.elapsed();
        since >= ASKED && (!self.driven || self.has_word()) || since > is_over
    }

    /// Whether the page that commands has just given a word. While a self-test moves the joint,
    /// that has to be the page that has begun it. What counts is when the word was given, and not
    /// when this thread has seen it.
    pub(super) fn has_word(&self) -> bool {
        let is_held = !self.shared.control.is_free() && self.has_its_page();
        is_held && self.shared.word().is_some_and(|word| word.elapsed() < FRESH)
    }

    pub(super) fn ask_status(&mut self) -> Result<Status, Error> {
        self.asked = Instant::now();
        let status = self.client.status()?;
        // What came before the answer is older, and may tell of an output that was off then.
        self.show_kept();
        self.driven = status.state == StateCode::Armed;
        self.armed_here &= self.driven;
        self.follow_travel(&status);
        self.testing_since(status.clock);
        if !self.driven
            && let Some(running) = self.running.take()
        {
            let Report { said, grade } = match self.found(running) {
                Err(error @ (Error::Device(_) | Error::Emulator(_))) => return Err(error),
                found => found.unwrap_or_else(|error| Report::bad(error.to_string())),
            };
            self.shared.news.tell("found", json!({ "said": said, "grade": grade }));
            self.shared.news.forget("found");
        }
        if !self.driven {
            self.end_testing(&status);
        }
        self.tell_status(&status);
        Ok(status)
    }
}
