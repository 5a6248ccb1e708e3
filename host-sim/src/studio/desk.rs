//! What the connections and the threads behind them share: orders with their answers, who commands,
//! the news, and what the device runs.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde_json::{Value, json};
use stiction::Parameters;

use super::control::Control;
use super::news::Newsroom;
use super::request::Ask;
use crate::error::Error;

/// How many stops may wait.
const STOPS: usize = 256;

/// What somebody is told who wants the joint that was identified, before one was.
pub const NONE_FOUND: &str = "no joint was identified here yet; identify it first";

/// What the thread and the connections share.
#[derive(Debug, Default)]
pub struct Shared {
    /// Who commands.
    pub control: Control,
    /// What all pages are told.
    pub news: Newsroom,
    /// When the page that commands has given its last word.
    word: Mutex<Option<Instant>>,
    /// Somebody wants the output off: this passes every order that waits. It is changed under the
    /// lock of `stops`: an order that comes after the answer that the motor is off is none that
    /// waited.
    stop: AtomicBool,
    /// The stops that wait. They have no place among the orders, and are answered however many of
    /// these wait.
    stops: Mutex<Vec<Order>>,
    /// Nobody talks to the device any more.
    has_ended: AtomicBool,
    /// The number of the last `hello`.
    pub(super) generation: AtomicU32,
    /// The number of the last prediction of a self-test.
    pub(super) predictions: AtomicU32,
    /// What the device runs, as far as is known: for those who compute with it and ask nothing of
    /// the device.
    in_use: Mutex<Option<Parameters>>,
    /// The joint that was identified last.
    found: Mutex<Option<FoundJoint>>,
}

/// A joint that was identified here, as a machine's file that stands nowhere yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundJoint {
    /// What the file is called.
    pub name: String,
    /// What is in it.
    pub text: String,
    /// The laws in it.
    pub laws: Vec<String>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Says what the device runs.
    pub fn runs(&self, parameters: Option<Parameters>) {
        *locked(&self.in_use) = parameters;
    }

    /// Returns what the device runs, as far as is known.
    pub fn in_use(&self) -> Option<Parameters> {
        locked(&self.in_use).clone()
    }

    /// The page that commands has given a word.
    pub fn gives_word(&self) {
        *locked(&self.word) = Some(Instant::now());
    }

    /// When it has given the last one.
    pub fn word(&self) -> Option<Instant> {
        *locked(&self.word)
    }

    /// Keeps the joint that was identified.
    pub fn finds(&self, joint: FoundJoint) {
        *locked(&self.found) = Some(joint);
    }

    /// Returns the joint that was identified last.
    ///
    /// # Errors
    /// Says that none was.
    pub fn found(&self) -> Result<FoundJoint, Error> {
        let none = || Error::Input(NONE_FOUND.into());
        locked(&self.found).clone().ok_or_else(none)
    }

    /// Hands over a stop. It passes every order that waits, and is answered however many do.
    pub fn stops(&self, order: Order) {
        let mut stops = locked(&self.stops);
        self.stop.store(true, Ordering::SeqCst);
        if self.has_ended.load(Ordering::SeqCst) {
            order.answered(&Err(Error::Device("the studio ends".into())));
        } else if stops.len() < STOPS {
            stops.push(order);
        } else {
            let why = "too many stops wait; the first of them turns the motor off";
            order.answered(&Err(Error::Refused(why.into())));
        }
    }

    /// Whether somebody wants the output off.
    pub fn is_stop_wanted(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Takes what somebody wants the output off for, if anybody does. It has to be turned off then.
    pub fn take_stops(&self) -> Option<Vec<Order>> {
        let mut stops = locked(&self.stops);
        let is_wanted = self.stop.swap(false, Ordering::SeqCst);
        is_wanted.then(|| std::mem::take(&mut *stops))
    }

    /// Refuses the stops that wait. Whoever reaches the device again has to stop it first.
    pub fn refuse_stops(&self, why: &str) {
        for stop in locked(&self.stops).drain(..) {
            stop.answered(&Err(Error::Device(why.into())));
        }
    }
}

/// The thread that talks to the device. When it has ended, however it did, nobody waits for it.
#[derive(Debug)]
pub struct Talking<'a>(pub &'a Shared);

impl Drop for Talking<'_> {
    fn drop(&mut self) {
        self.0.has_ended.store(true, Ordering::SeqCst);
        self.0.refuse_stops("the studio ends");
    }
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
