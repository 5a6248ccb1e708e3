//! The studio without a server and without threads: device, worker and predictions.
//!
//! ```text
//! page --- ask() --> PageControl, queues --- pass() ---> worker.rs, forecaster.rs
//!      <-- next() --- answers, messages <------------------------/
//! ```
//!
//! The crate `playground/` compiles the [`Playground`] to WebAssembly, inside the page. The page
//! uses it like a server, except for functions that need a server. Its device is the simulated one,
//! whose time passes while [`pass`](Playground::pass) waits for it. There is one page, and it
//! commands.
//!
//! Guarantee: the same messages as a server for the same joint and the same requests. Limit: a long
//! computation, such as a cloud of predictions, takes one pass, and the device stands still
//! meanwhile.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use serde_json::json;
use tokio::sync::{broadcast, mpsc};

use super::desk::{QueuedRequest, StudioState, answer};
use super::forecaster::{Forecaster, PredictionQueue};
use super::news::StudioMessage;
use super::request::{StudioAction, StudioRequest};
use super::worker::{DeviceContext, Worker};
use files::error::Error;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, Experiment};

/// Number of the only page.
const PAGE: u64 = 0;

/// Refusal of a tuning or of the prediction of a self-test.
const NO_THREADS: &str =
    "this page cannot do that, since it has no threads: use the program `stiction`";

/// Largest number of waiting requests, and of waiting answers.
const WAITING: usize = 64;

/// A studio with its simulated device.
pub struct Playground {
    shared: &'static StudioState,
    worker: Worker<'static, SimulatedWire>,
    orders: SyncSender<QueuedRequest>,
    waiting: Receiver<QueuedRequest>,
    forecaster: Forecaster<'static>,
    wishes: PredictionQueue,
    answer: mpsc::Sender<String>,
    answers: mpsc::Receiver<String>,
    news: broadcast::Receiver<StudioMessage>,
    outgoing: VecDeque<StudioMessage>,
}

impl Playground {
    /// Starts a studio with a simulated device around the joint of `machine`, which is the name of
    /// a built-in experiment or the path of a file. The device starts with `controller`, or with
    /// the file's own.
    ///
    /// The state of a playground stays in memory until the program ends, so a page should open only
    /// one.
    ///
    /// # Errors
    /// Reports what is wrong with the file.
    pub fn open(machine: &str, controller: Option<&str>) -> Result<Self, Error> {
        let wanted: Vec<String> = controller.iter().map(|name| (*name).to_owned()).collect();
        let first = Experiment::plan(&Document::open(machine)?, &wanted, &[])?.into_first();
        let nothing = || Error::Input(format!("{machine}: there is nothing to run"));
        let device = SimulatedDevice::new(&first.ok_or_else(nothing)?)?;
        let shared: &'static StudioState = Box::leak(Box::default());
        let about = DeviceContext { machine: machine.into(), is_its_file: true, every_tick: true };
        let about: &'static DeviceContext = Box::leak(Box::new(about));
        let (_, news) = shared.news.listen();
        let (orders, waiting) = sync_channel(WAITING);
        let (answer, answers) = mpsc::channel(WAITING);
        let commands = shared.control.ask(PAGE, shared.now());
        let role = json!({ "event": "role", "commands": commands, "why": "" });
        let worker = Worker::new(Client::connect(SimulatedWire::new(device))?, shared, about)?;
        let why = NO_THREADS;
        let tuning = json!({ "machine": null, "laws": [], "why": why, "running": null,
                             "of_found": false });
        shared.news.publish("tuning", tuning);
        let test = json!({ "phase": "none", "why": why, "said": null, "of_found": false });
        shared.news.publish("selftest", test);
        Ok(Self {
            shared,
            worker,
            orders,
            waiting,
            forecaster: Forecaster::new(Some(&about.machine)),
            wishes: PredictionQueue::default(),
            answer,
            answers,
            news,
            outgoing: VecDeque::from([StudioMessage::Event(role.to_string().into())]),
        })
    }

    /// Queues a request of the page. Later passes execute it.
    pub fn ask(&mut self, text: &str) {
        let StudioRequest { id, what } = match serde_json::from_str(text) {
            Ok(request) => request,
            Err(error) => {
                let why = Error::Input(format!("this is no request: {error}"));
                return self.say(answer(0, &Err(why)));
            }
        };
        match what {
            StudioAction::Predict(_) | StudioAction::Compare(_) => {
                self.wishes.put(PAGE, id, what, self.answer.clone());
            }
            _ if what.is_apart() || matches!(what, StudioAction::PredictSelftest { .. }) => {
                self.say(answer(id, &Err(Error::Refused(NO_THREADS.into()))));
            }
            _ => self.order(id, what),
        }
    }

    /// Sends a request to the worker. Each request is a keep-alive of the page.
    fn order(&mut self, id: u32, what: StudioAction) {
        let given = self.shared.now();
        self.shared.control.record_keep_alive(PAGE, given);
        self.shared.record_keep_alive();
        if matches!(what, StudioAction::Alive | StudioAction::Command) {
            return;
        }
        let order = QueuedRequest { page: PAGE, given, id, what, answer: self.answer.clone() };
        if order.what == StudioAction::Stop {
            return self.shared.queue_stop(order);
        }
        if self.orders.try_send(order).is_err() {
            let why = "too many requests wait for the device; send it again";
            self.say(answer(id, &Err(Error::Refused(why.into()))));
        }
    }

    /// Advances the device by a moment, executes the next request, and computes the next
    /// prediction.
    pub fn pass(&mut self) {
        // A simulated device fails only by an error in this program.
        if let Err(error) = self.worker.pass(&self.waiting) {
            self.shared.news.publish("gone", json!({ "said": error.to_string() }));
        }
        let next = self.wishes.take();
        self.forecaster.pass(&self.wishes, self.shared, next);
    }

    fn say(&mut self, said: String) {
        self.outgoing.push_back(StudioMessage::Event(said.into()));
    }
}

/// Iterator over the waiting messages to the page; the next pass can add more.
impl Iterator for Playground {
    type Item = StudioMessage;

    fn next(&mut self) -> Option<StudioMessage> {
        while let Ok(said) = self.answers.try_recv() {
            self.say(said);
        }
        loop {
            match self.news.try_recv() {
                Ok(news) => self.outgoing.push_back(news),
                Err(broadcast::error::TryRecvError::Lagged(_)) => {}
                Err(_) => break,
            }
        }
        self.outgoing.pop_front()
    }
}
