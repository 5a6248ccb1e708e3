//! The studio in one piece: device, worker and predictions, without a server and without a thread.
//!
//! ```text
//! page --- ask() --> Control, orders, wishes --- pass() ---> worker.rs, forecaster.rs
//!      <-- next() --- answers, news <------------------------------/
//! ```
//!
//! `playground/` is this as WebAssembly, in the page itself; a page cannot tell it from a server,
//! but for what needs one. Its device is the simulated one, and time passes on it while
//! [`pass`](Playground::pass) waits for it. There is one page, and it commands.
//!
//! Guarantees: what a server tells of the same joint and the same requests. Does badly: what takes
//! long, such as a cloud of predictions, is computed in one pass, and the device stands still
//! meanwhile.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

use serde_json::json;
use tokio::sync::{broadcast, mpsc};

use super::desk::{Order, Shared, answer};
use super::forecaster::{Forecaster, Wishes};
use super::news::News;
use super::request::{Ask, Request};
use super::worker::{About, Worker};
use crate::device::client::Client;
use crate::device::simulated::SimulatedDevice;
use crate::device::wire::SimulatedWire;
use crate::error::Error;
use crate::experiment::{Document, Experiment};

/// The page.
const PAGE: u64 = 0;

/// Why it neither tunes nor predicts a self-test.
const NO_THREADS: &str =
    "this page has no threads for that: the program `stiction` does it on a computer";

/// How many orders, and how many answers may wait: a page asks for a few at once.
const WAITING: usize = 64;

/// A studio with its simulated device.
pub struct Playground {
    shared: &'static Shared,
    worker: Worker<'static, SimulatedWire>,
    orders: SyncSender<Order>,
    waiting: Receiver<Order>,
    forecaster: Forecaster<'static>,
    wishes: Wishes,
    answer: mpsc::Sender<String>,
    answers: mpsc::Receiver<String>,
    news: broadcast::Receiver<News>,
    told: VecDeque<News>,
}

impl Playground {
    /// Turns the power on, around the joint of `machine`: the name of a built-in experiment, or the
    /// path of a file. `controller` is what the device begins with, if not with the file's own.
    ///
    /// What the device is told of stays in memory until the program ends: a page opens one.
    ///
    /// # Errors
    /// Says what is wrong with the file.
    pub fn open(machine: &str, controller: Option<&str>) -> Result<Self, Error> {
        let wanted: Vec<String> = controller.iter().map(|name| (*name).to_owned()).collect();
        let first = Experiment::plan(&Document::open(machine)?, &wanted, &[])?.into_first();
        let nothing = || Error::Input(format!("{machine}: there is nothing to run"));
        let device = SimulatedDevice::new(&first.ok_or_else(nothing)?)?;
        let shared: &'static Shared = Box::leak(Box::default());
        let about = About { machine: machine.into(), is_its_file: true, every_tick: true };
        let about: &'static About = Box::leak(Box::new(about));
        let (_, news) = shared.news.listen();
        let (orders, waiting) = sync_channel(WAITING);
        let (answer, answers) = mpsc::channel(WAITING);
        let commands = shared.control.ask(PAGE);
        let role = json!({ "event": "role", "commands": commands, "why": "" });
        let worker = Worker::new(Client::connect(SimulatedWire::new(device))?, shared, about)?;
        let why = NO_THREADS;
        let tuning = json!({ "machine": null, "laws": [], "why": why, "running": null,
                             "of_found": false });
        shared.news.tell("tuning", tuning);
        let test = json!({ "phase": "none", "why": why, "said": null, "of_found": false });
        shared.news.tell("selftest", test);
        Ok(Self {
            shared,
            worker,
            orders,
            waiting,
            forecaster: Forecaster::new(Some(&about.machine)),
            wishes: Wishes::default(),
            answer,
            answers,
            news,
            told: VecDeque::from([News::Event(role.to_string().into())]),
        })
    }

    /// Takes what the page asks for. It is done in the passes that follow.
    pub fn ask(&mut self, text: &str) {
        let Request { id, what } = match serde_json::from_str(text) {
            Ok(request) => request,
            Err(error) => {
                let why = Error::Input(format!("this is no request: {error}"));
                return self.say(answer(0, &Err(why)));
            }
        };
        match what {
            Ask::Predict(_) | Ask::Compare(_) => {
                self.wishes.put(PAGE, id, what, self.answer.clone());
            }
            _ if what.is_apart() || matches!(what, Ask::PredictSelftest { .. }) => {
                self.say(answer(id, &Err(Error::Refused(NO_THREADS.into()))));
            }
            _ => self.order(id, what),
        }
    }

    /// Hands an order to the worker. Whatever it is, the page lives.
    fn order(&mut self, id: u32, what: Ask) {
        self.shared.control.word(PAGE);
        self.shared.gives_word();
        if matches!(what, Ask::Alive | Ask::Command) {
            return;
        }
        let order =
            Order { page: PAGE, given: Instant::now(), id, what, answer: self.answer.clone() };
        if order.what == Ask::Stop {
            return self.shared.stops(order);
        }
        if self.orders.try_send(order).is_err() {
            let why = "too many requests wait for the device; say it again";
            self.say(answer(id, &Err(Error::Refused(why.into()))));
        }
    }

    /// Lets the device go on for a moment, and does the next of what was asked for.
    pub fn pass(&mut self) {
        // A simulated device is not gone, unless something is wrong with this program.
        if let Err(error) = self.worker.pass(&self.waiting) {
            self.shared.news.tell("gone", json!({ "said": error.to_string() }));
        }
        let next = self.wishes.take();
        self.forecaster.pass(&self.wishes, self.shared, next);
    }

    fn say(&mut self, said: String) {
        self.told.push_back(News::Event(said.into()));
    }
}

/// What the page has to be told, as far as there is something; more may come with the next pass.
impl Iterator for Playground {
    type Item = News;

    fn next(&mut self) -> Option<News> {
        while let Ok(said) = self.answers.try_recv() {
            self.say(said);
        }
        loop {
            match self.news.try_recv() {
                Ok(news) => self.told.push_back(news),
                Err(broadcast::error::TryRecvError::Lagged(_)) => {}
                Err(_) => break,
            }
        }
        self.told.pop_front()
    }
}
