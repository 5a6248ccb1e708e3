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

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::link::{Kind, StateCode, Status};
use stiction::signal::name;

use super::control::{Control, TAKEN};
use super::form;
use super::news::{Frame, Newsroom};
use super::request::Ask;
use crate::device::client::Client;
use crate::device::signals::Signals;
use crate::device::wire::Wire;
use crate::device::words;
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

/// Time between two frames.
const FRAME: Duration = Duration::from_millis(30);

/// Time within which an order is seen.
const SLICE: Duration = Duration::from_millis(10);

/// Time between two tries to reach a device that is gone.
const AGAIN: Duration = Duration::from_secs(1);

/// What a wire of 921 600 baud carries, bytes a second, with a quarter left for answers.
const CARRIED: f64 = 0.75 * 92_160.0;

/// Bytes of a sample without its values: numbers, mask, length, checksum and stuffing.
const AROUND: usize = 30;

/// The signals that every page gets, beside those of the law.
const SHOWN: [&str; 11] = [
    name("counts"),
    name("reference_counts"),
    name("reference_fraction"),
    name("error"),
    name("velocity"),
    name("v_pd"),
    name("v_c"),
    name("v"),
    name("v_applied"),
    name("code"),
    name("status"),
];

/// What the thread and the connections share.
#[derive(Debug, Default)]
pub struct Shared {
    /// Who commands.
    pub control: Control,
    /// What all pages are told.
    pub news: Newsroom,
    /// How many words the page that commands has given.
    pub words: AtomicU64,
    /// Somebody wants the output off: this passes every order that waits.
    pub stop: AtomicBool,
    /// The number of the last `hello`.
    generation: AtomicU32,
}

/// An order of a page, and where its answer goes.
#[derive(Debug)]
pub struct Order {
    /// The page that gives it.
    pub page: u64,
    /// When it was given.
    pub given: Instant,
    /// The page's number for it.
    pub id: u32,
    /// What is asked for.
    pub what: Ask,
    /// Takes the answer.
    pub answer: tokio::sync::mpsc::Sender<String>,
}

impl Order {
    /// Answers. A page that is gone, or does not read, needs none.
    pub fn answered(&self, done: &Result<Value, Error>) {
        let _ = self.answer.try_send(answer(self.id, done));
    }
}

/// The answer to a request, for the page.
pub fn answer(id: u32, done: &Result<Value, Error>) -> String {
    let said = match done {
        Ok(said) => json!({ "event": "answer", "id": id, "ok": true, "said": said }),
        Err(error) => {
            json!({ "event": "answer", "id": id, "ok": false, "said": error.to_string() })
        }
    };
    said.to_string()
}

/// A motion that ends by itself and has found something then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Running {
    /// A jog.
    Jog,
    /// A ramp of so many V/s.
    Ramp(f32),
}

/// What the studio is told of its device, which the device does not know.
#[derive(Clone, Debug)]
pub struct About {
    /// Whose joint a pulled file has.
    pub machine: String,
    /// Whether every tick is sent, however many bytes that takes: the wire is none.
    pub every_tick: bool,
}

/// A session with the device.
pub struct Worker<'a, W> {
    pub(super) client: Client<W>,
    pub(super) shared: &'a Shared,
    pub(super) about: &'a About,
    pub(super) running: Option<Running>,
    /// Parameters that were in use before changes of this session, the latest last.
    pub(super) before: Vec<Parameters>,
    /// Those that a reset would bring back, as far as they are known.
    pub(super) saved: Option<Parameters>,
    signals: Signals,
    frame: Frame,
    flushed: Instant,
    /// Whether the output is on, as far as was last heard.
    pub(super) driven: bool,
    /// Whether a page of this studio has turned it on.
    pub(super) armed_here: bool,
    asked: Instant,
    words: u64,
    heard: Instant,
    /// s; zero if it is off.
    link_timeout: f32,
}

/// Talks to the device until nobody has an order any more. `ready` hears whether it was there.
pub fn run<W: Wire>(
    open: impl Fn() -> Result<W, Error>,
    about: &About,
    shared: &Shared,
    orders: &Receiver<Order>,
    ready: &SyncSender<Result<(), Error>>,
) {
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
    let _ = ready.send(Ok(()));
    loop {
        let Err(error) = worker.work(orders) else { return };
        // What was driven from here is stopped before anything else, once it can be reached.
        let was_armed = worker.armed_here;
        let driven = if worker.driven { ". THE MOTOR MAY STILL BE DRIVEN" } else { "" };
        shared.news.tell("gone", json!({ "said": format!("{error}{driven}") }));
        // The wire is closed before it is opened again.
        drop(worker);
        worker = loop {
            match orders.recv_timeout(AGAIN) {
                Ok(order) => {
                    order.answered(&Err(Error::Device("the device does not answer".into())));
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Ok(worker) = begin(was_armed) {
                break worker;
            }
        };
        shared.news.forget("gone");
        shared.news.tell("back", json!({}));
    }
}

impl<'a, W: Wire> Worker<'a, W> {
    fn new(mut client: Client<W>, shared: &'a Shared, about: &'a About) -> Result<Self, Error> {
        client.wire().real_time();
        let now = Instant::now();
        let mut worker = Self {
            client,
            shared,
            about,
            running: None,
            before: Vec::new(),
            saved: None,
            signals: Signals::default(),
            frame: Frame::default(),
            flushed: now,
            driven: false,
            armed_here: false,
            asked: now,
            words: shared.words.load(Ordering::Relaxed),
            heard: now,
            link_timeout: 0.0,
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
        let mut faults = None;
        loop {
            self.stop_if_asked(orders)?;
            match orders.try_recv() {
                Ok(order) => {
                    let done = match self.shared.control.is_held_by(order.page) {
                        _ if order.what == Ask::Stop => self.obey(&order.what),
                        true if order.given.elapsed() < LATE => self.obey(&order.what),
                        true => Err(Error::Refused("the device was busy; say it again".into())),
                        false => Err(Error::Refused(TAKEN.into())),
                    };
                    order.answered(&done);
                    self.asked = Instant::now();
                    if let Err(error @ (Error::Device(_) | Error::Emulator(_))) = done {
                        return Err(error);
                    }
                    // What it has changed is told at once.
                    self.ask_status()?;
                }
                Err(TryRecvError::Disconnected) => return Ok(()),
                Err(TryRecvError::Empty) => {}
            }
            self.listen();
            if self.link_timeout == 0.0 && self.armed_here && self.heard.elapsed() > QUIET {
                self.client.stop()?;
                self.ask_status()?;
            }
            if self.may_ask() {
                let status = self.ask_status()?;
                if faults.replace(status.faults).is_some_and(|before| before != status.faults) {
                    self.tell_faults(&status)?;
                }
            }
            let (sample, before) = (self.client.sample(SLICE)?, self.driven);
            for sample in sample.into_iter().chain(std::iter::from_fn(|| self.client.kept())) {
                self.driven = self.signals.is_armed(&sample);
                self.frame.push(&sample, &self.shared.news);
            }
            // Something else than a page has turned it on. Nobody may take it for off.
            if self.driven && !before {
                self.ask_status()?;
            }
            if self.flushed.elapsed() >= FRAME {
                self.flushed = Instant::now();
                self.frame.flush(&self.shared.news);
            }
        }
    }

    /// Turns the output off if somebody wants that. No order that waits is obeyed any more.
    fn stop_if_asked(&mut self, orders: &Receiver<Order>) -> Result<(), Error> {
        if !self.shared.stop.swap(false, Ordering::SeqCst) {
            return Ok(());
        }
        let waiting: Vec<Order> = orders.try_iter().collect();
        let stopped = self.client.stop();
        self.running = None;
        for order in waiting {
            let overtaken = || Error::Refused("a stop came first; say it again".into());
            let failed = |error: &Error| Error::Device(error.to_string());
            order.answered(&match (&order.what, &stopped) {
                (_, Err(error)) => Err(failed(error)),
                (Ask::Stop, Ok(())) => Ok("stopped: the motor is off".into()),
                _ => Err(overtaken()),
            });
        }
        stopped?;
        self.ask_status().map(|_| ())
    }

    /// Looks whether the page that commands has given a word.
    fn listen(&mut self) {
        let words = self.shared.words.load(Ordering::Relaxed);
        if words != self.words {
            (self.words, self.heard) = (words, Instant::now());
        }
    }

    /// Whether the status may be asked for. A device that is driven and that nobody keeps alive is
    /// asked once its link timeout is long over, in case its samples do not come.
    fn may_ask(&self) -> bool {
        let has_word = !self.shared.control.is_free() && self.heard.elapsed() < FRESH;
        let is_over = Duration::from_secs_f32(1.0 + 2.0 * self.link_timeout.clamp(0.0, 60.0));
        let since = self.asked.elapsed();
        since >= ASKED && (!self.driven || has_word) || since > is_over
    }

    fn ask_status(&mut self) -> Result<Status, Error> {
        self.asked = Instant::now();
        let status = self.client.status()?;
        self.driven = status.state == StateCode::Armed;
        self.armed_here &= self.driven;
        if !self.driven
            && let Some(running) = self.running.take()
        {
            let text = self.found(running)?;
            self.shared.news.tell("found", json!({ "said": text }));
            self.shared.news.forget("found");
        }
        self.tell_status(&status);
        Ok(status)
    }

    fn tell_status(&self, status: &Status) {
        let fault =
            (status.fault.code != 0).then(|| words::fault(&status.fault, status.sample_time));
        self.shared.news.tell(
            "status",
            json!({
                "state": words::state(status.state),
                "driven": status.state == StateCode::Armed,
                "clock": status.clock,
                "at_rest": status.at_rest,
                "since_power_on_counts": status.position,
                "unsaved": status.unsaved,
                "wound_up": status.wound_up,
                "gave_up": status.gave_up,
                "heat_v": status.thermal_effort,
                "faults": status.faults,
                "fault": fault,
                "text": words::status(status),
                "lost": self.client.lost(),
                "link_timeout_s": self.link_timeout,
            }),
        );
    }

    fn tell_faults(&mut self, status: &Status) -> Result<(), Error> {
        let faults = self.client.faults()?;
        let faults = faults.iter().map(|told| words::fault(told, status.sample_time));
        let faults: Vec<Value> = faults.collect();
        self.shared.news.tell("faults", json!({ "faults": faults }));
        Ok(())
    }

    /// Asks the device what it is, what it can send and what it runs, and tells all of that.
    pub(super) fn introduce(&mut self) -> Result<(), Error> {
        let status = self.client.status()?;
        let announced = self.client.signals()?;
        let signals = Signals::new(announced.clone());
        let law: Vec<String> = signals.of_law().map(str::to_owned).collect();
        let mask = signals.mask(SHOWN.into_iter().chain(law.iter().map(String::as_str)));
        let columns = mask.count_ones() as usize;
        let every = if self.about.every_tick {
            1
        } else {
            let took_s = (AROUND + 4 * columns) as f64 / CARRIED;
            (took_s / f64::from(status.sample_time).max(1e-6)).ceil().clamp(1.0, 1000.0) as u16
        };
        let parameters = self.client.parameters().ok();
        self.link_timeout = parameters.as_ref().map_or(0.0, |all| all.limits.link_timeout);
        self.frame.flush(&self.shared.news);
        self.client.subscribe(mask, every)?;
        self.signals = signals;
        self.frame.generation = self.shared.generation.fetch_add(1, Ordering::Relaxed) + 1;
        self.frame.places =
            (0..u64::BITS as usize).filter(|place| mask >> place & 1 == 1).collect();
        let shown = self.frame.places.iter().filter_map(|place| announced.get(*place));
        let columns: Vec<Value> = shown
            .map(|signal| {
                json!({
                    "name": signal.name.as_str(),
                    "unit": signal.unit.as_str(),
                    "form": format!("{:?}", signal.form).to_lowercase(),
                })
            })
            .collect();
        let warning = self.client.warning();
        let identity = self.client.identity();
        let kind = match identity.map(|identity| identity.kind) {
            Some(Kind::Simulated) => "simulated",
            _ if warning.is_some() => "emulated",
            _ => "board",
        };
        let version = identity.map_or(String::new(), |identity| identity.version.as_str().into());
        self.shared.news.tell(
            "hello",
            json!({
                "generation": self.frame.generation,
                "device": self.client.wire().name(),
                "firmware": version,
                "program": env!("CARGO_PKG_VERSION"),
                "kind": kind,
                "warning": warning,
                "sample_time_s": crate::written::single(status.sample_time),
                "resolution_deg": crate::written::single(status.resolution),
                "every": every,
                "signals": columns,
                "law": law,
            }),
        );
        if let Some(parameters) = parameters {
            let rows = form::rows(&parameters, self.saved.as_ref())?;
            // A file that cannot be written is not there to be pulled either.
            let file = form::file(&parameters, &self.about.machine, warning).ok();
            self.shared.news.tell(
                "parameters",
                json!({ "rows": rows, "file": file, "undo": self.before.len() }),
            );
        }
        Ok(())
    }
}
