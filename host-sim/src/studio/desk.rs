//! State that the connections and the threads behind them share: queued requests, the page that
//! commands, events for the pages, and the parameters in use.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::Parameters;

use super::control::PageControl;
use super::news::Broadcaster;
use super::request::StudioAction;
use files::error::Error;
use simulator::device::clock::{Clock, ComputerClock};

/// Largest number of waiting stops.
const STOPS: usize = 256;

/// Error of a request for the identified joint before an identification.
pub const NONE_IDENTIFIED: &str = "no joint was identified here yet; identify it first";

/// State that the threads and the connections share.
#[derive(Debug)]
pub struct StudioState {
    /// Clock of keep-alives and of the age of requests.
    clock: Arc<dyn Clock>,
    /// Arbiter of the page that commands.
    pub control: PageControl,
    /// Events for all pages.
    pub news: Broadcaster,
    /// Time of the last keep-alive of the page that commands.
    word: Mutex<Option<Duration>>,
    /// Whether a stop is requested; a stop overtakes every waiting request. The flag changes under
    /// the lock of `stops`, so that a request after the answer to a stop does not count as waiting.
    stop: AtomicBool,
    /// Waiting stops. They are not in the queue of requests, so a long queue does not delay their
    /// answers.
    stops: Mutex<Vec<QueuedRequest>>,
    /// Whether the thread of the device has ended.
    has_ended: AtomicBool,
    /// Number of the last event `hello`.
    pub(super) generation: AtomicU32,
    /// Number of the last prediction of a self-test.
    pub(super) predictions: AtomicU32,
    /// Parameters of the device, if known, for the threads that cannot query the device.
    in_use: Mutex<Option<Parameters>>,
    /// The last identified joint.
    found: Mutex<Option<UnsavedJoint>>,
}

/// A joint that was identified in this session, as a machine's file that is not saved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsavedJoint {
    /// Name of the file.
    pub name: String,
    /// Contents of the file.
    pub text: String,
    /// Laws in the file.
    pub laws: Vec<String>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Default for StudioState {
    /// Returns the initial state, with the computer's clock.
    fn default() -> Self {
        Self::on_clock(Arc::new(ComputerClock))
    }
}

impl StudioState {
    /// Returns the initial state, with a clock for keep-alives and the age of requests.
    pub fn on_clock(clock: Arc<dyn Clock>) -> Self {
        Self {
            clock,
            control: PageControl::default(),
            news: Broadcaster::default(),
            word: Mutex::default(),
            stop: AtomicBool::default(),
            stops: Mutex::default(),
            has_ended: AtomicBool::default(),
            generation: AtomicU32::default(),
            predictions: AtomicU32::default(),
            in_use: Mutex::default(),
            found: Mutex::default(),
        }
    }

    /// Returns the time of the clock.
    pub fn now(&self) -> Duration {
        self.clock.now()
    }

    /// Stores the parameters of the device.
    pub fn set_in_use(&self, parameters: Option<Parameters>) {
        *locked(&self.in_use) = parameters;
    }

    /// Returns the parameters of the device, if known.
    pub fn in_use(&self) -> Option<Parameters> {
        locked(&self.in_use).clone()
    }

    /// Stores the time of a keep-alive of the page that commands.
    pub fn record_keep_alive(&self) {
        *locked(&self.word) = Some(self.now());
    }

    /// Returns the time of the last keep-alive.
    pub fn last_keep_alive(&self) -> Option<Duration> {
        *locked(&self.word)
    }

    /// Stores the identified joint.
    pub fn set_found(&self, joint: UnsavedJoint) {
        *locked(&self.found) = Some(joint);
    }

    /// Returns the last identified joint.
    ///
    /// # Errors
    /// Returns an error if no joint was identified.
    pub fn found(&self) -> Result<UnsavedJoint, Error> {
        let none = || Error::Input(NONE_IDENTIFIED.into());
        locked(&self.found).clone().ok_or_else(none)
    }

    /// Queues a stop. It overtakes every waiting request.
    pub fn queue_stop(&self, order: QueuedRequest) {
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

    /// Returns whether a stop is requested.
    pub fn is_stop_wanted(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Removes and returns the waiting stops if a stop is requested; the caller must then turn the
    /// output off.
    pub fn take_stops(&self) -> Option<Vec<QueuedRequest>> {
        let mut stops = locked(&self.stops);
        let is_wanted = self.stop.swap(false, Ordering::SeqCst);
        is_wanted.then(|| std::mem::take(&mut *stops))
    }

    /// Refuses the waiting stops. The flag stays set, so the device is stopped once it answers.
    pub fn refuse_stops(&self, why: &str) {
        for stop in locked(&self.stops).drain(..) {
            stop.answered(&Err(Error::Device(why.into())));
        }
    }
}

/// Marks the end of the device's thread when it is dropped, and refuses the waiting stops.
#[derive(Debug)]
pub struct DeviceThreadGuard<'a>(pub &'a StudioState);

impl Drop for DeviceThreadGuard<'_> {
    fn drop(&mut self) {
        self.0.has_ended.store(true, Ordering::SeqCst);
        self.0.refuse_stops("the studio ends");
    }
}

/// A request of a page, with the sender of its answer.
#[derive(Debug)]
pub struct QueuedRequest {
    /// Number of the page.
    pub page: u64,
    /// Time of the request.
    pub given: Duration,
    /// The page's number of the request.
    pub id: u32,
    /// Requested action.
    pub what: StudioAction,
    /// Sender of the answer.
    pub answer: tokio::sync::mpsc::Sender<String>,
}

impl QueuedRequest {
    /// Sends the answer. If the page is gone or does not read, the answer is dropped.
    pub fn answered(&self, done: &Result<Value, Error>) {
        let _ = self.answer.try_send(answer(self.id, done));
    }
}

/// Returns the answer to a request as JSON.
pub fn answer(id: u32, done: &Result<Value, Error>) -> String {
    let said = match done {
        Ok(said) => json!({ "event": "answer", "id": id, "ok": true, "said": said }),
        Err(error) => {
            json!({ "event": "answer", "id": id, "ok": false, "said": error.to_string() })
        }
    };
    said.to_string()
}
