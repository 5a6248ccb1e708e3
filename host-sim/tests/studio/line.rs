//! A line to a simulated device that can be slow or cut, and records the requests to the device.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use files::Error;
use simulator::device::clock::Clock;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use stiction::link::{Deframer, decode_request};

use super::clock::{STEP, TestClock};
use super::page::{Studio, device, studio_of};

/// A hook before a request reaches the device; its argument is the name of the request.
type Before = Box<dyn FnMut(&str, &mut SimulatedWire) + Send>;

/// A device that keeps its state when another client opens the line.
#[derive(Clone)]
pub struct Line {
    pub device: Arc<Mutex<SimulatedWire>>,
    pub clock: Arc<TestClock>,
    /// Whether the line is cut.
    pub is_cut: Arc<AtomicBool>,
    /// Names of the requests to the device.
    pub asked: Arc<Mutex<Vec<String>>>,
    pub deframer: Arc<Mutex<Deframer>>,
    pub before: Arc<Mutex<Option<Before>>>,
    /// Whether the device runs [`HASTE`] times as fast as the clock.
    pub in_haste: bool,
    /// Whether the start is over: the device keeps to the clock.
    pub is_real: Arc<AtomicBool>,
    /// Time of the clock until which the device has run in haste.
    pub hasted: Arc<Mutex<Duration>>,
}

/// Speed of a device in haste, in times of the clock's.
const HASTE: f64 = 50.0;

/// How far a device in haste is ahead of the clock before it waits. A wait for each tick takes most
/// of the test's time.
const AHEAD: Duration = Duration::from_millis(1);

impl Line {
    pub fn new(set: &[&str]) -> Self {
        Self::around(device(set))
    }

    /// A line to a device in any state.
    pub fn around(device: SimulatedDevice) -> Self {
        let clock = Arc::<TestClock>::default();
        Self {
            device: Arc::new(Mutex::new(SimulatedWire::on_clock(device, clock.clone()))),
            clock,
            is_cut: Arc::default(),
            asked: Arc::default(),
            deframer: Arc::default(),
            before: Arc::default(),
            in_haste: false,
            is_real: Arc::default(),
            hasted: Arc::default(),
        }
    }

    pub fn serve(&self) -> Studio {
        self.serve_as("step-response", true)
    }

    /// A studio around the device, with a machine's file or without its own.
    pub fn serve_as(&self, machine: &str, is_its_file: bool) -> Studio {
        let line = self.clone();
        studio_of(&self.clock, machine, is_its_file, move || Ok(line.clone()))
    }

    pub fn names(&self) -> Vec<String> {
        self.asked.lock().unwrap().clone()
    }

    pub fn was_asked(&self, what: &str) -> bool {
        self.names().iter().any(|name| name.starts_with(what))
    }

    pub fn before(&self, what: impl FnMut(&str, &mut SimulatedWire) + Send + 'static) {
        *self.before.lock().unwrap() = Some(Box::new(what));
    }

    /// Delays the next request of a kind (empty: of any kind). The flag is set when it does.
    pub fn stalls(&self, kind: &'static str, time: Duration) -> Arc<AtomicBool> {
        let is_stalled = Arc::new(AtomicBool::new(false));
        let (stalled, clock) = (is_stalled.clone(), self.clock.clone());
        self.before(move |name, _| {
            if name.starts_with(kind) && !stalled.swap(true, Ordering::SeqCst) {
                clock.sleep(time);
            }
        });
        is_stalled
    }

    /// Waits for a flag, without a keep-alive meanwhile.
    pub async fn until(&self, flag: &AtomicBool) {
        self.clock.until(|| flag.load(Ordering::SeqCst)).await;
    }
}

impl Wire for Line {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            return Ok(());
        }
        for byte in bytes {
            let mut deframer = self.deframer.lock().unwrap();
            let Some(message) = deframer.push(*byte) else { continue };
            let request = decode_request(message).unwrap().content;
            let name = format!("{:?}", request.unwrap());
            self.asked.lock().unwrap().push(name.clone());
            if let Some(before) = &mut *self.before.lock().unwrap() {
                before(&name, &mut self.device.lock().unwrap());
            }
        }
        self.device.lock().unwrap().send(bytes)
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            self.clock.sleep(at_most);
            return Ok(vec![]);
        }
        if !self.is_real.load(Ordering::SeqCst) {
            return self.device.lock().unwrap().receive(at_most);
        }
        if self.in_haste {
            let mut device = self.device.lock().unwrap();
            // Each tick sends a sample, and ends the reading.
            let heard = device.receive(at_most);
            let tick = Duration::from_secs_f64(device.simulated.sample_time_s() / HASTE);
            drop(device);
            let mut hasted = self.hasted.lock().unwrap();
            let now = self.clock.now();
            *hasted = hasted.max(now.saturating_sub(STEP)) + tick;
            if *hasted > now + AHEAD {
                self.clock.sleep_until(*hasted);
            }
            return heard;
        }
        // The device is not kept from the test meanwhile.
        let end = self.clock.now() + at_most;
        loop {
            let heard = self.device.lock().unwrap().receive(Duration::ZERO)?;
            let now = self.clock.now();
            if !heard.is_empty() || now >= end {
                return Ok(heard);
            }
            self.clock.sleep_until(end.min(now + STEP));
        }
    }

    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn name(&self) -> String {
        "the device of the test".into()
    }

    fn real_time(&mut self) {
        self.is_real.store(true, Ordering::SeqCst);
        if !self.in_haste {
            self.device.lock().unwrap().real_time();
        }
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }

    fn load_ahead_deg(&self, clock: u32) -> Option<f64> {
        self.device.lock().unwrap().load_ahead_deg(clock)
    }
}
