//! A line to a simulated device that can be slow or cut, and records the requests to the device.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use files::Error;
use host_sim::studio::Server;
use simulator::device::wire::{SimulatedWire, Wire};
use stiction::link::{Deframer, decode_request};

use super::page::{device, studio_of};

/// A hook before a request reaches the device; its argument is the name of the request.
type Before = Box<dyn FnMut(&str, &mut SimulatedWire) + Send>;

/// A device that keeps its state when another client opens the line.
#[derive(Clone)]
pub struct Line {
    pub device: Arc<Mutex<SimulatedWire>>,
    /// Delay of the next request, ms.
    pub stalls_ms: Arc<AtomicU64>,
    /// Whether the line is cut.
    pub is_cut: Arc<AtomicBool>,
    /// Names of the requests to the device.
    pub asked: Arc<Mutex<Vec<String>>>,
    pub deframer: Arc<Mutex<Deframer>>,
    pub before: Arc<Mutex<Option<Before>>>,
    /// Whether the device runs faster than real time.
    pub in_haste: bool,
}

impl Line {
    pub fn new(set: &[&str]) -> Self {
        Self {
            device: Arc::new(Mutex::new(SimulatedWire::new(device(set)))),
            stalls_ms: Arc::default(),
            is_cut: Arc::default(),
            asked: Arc::default(),
            deframer: Arc::default(),
            before: Arc::default(),
            in_haste: false,
        }
    }

    pub fn serve(&self) -> Server {
        let line = self.clone();
        studio_of(move || Ok(line.clone()))
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

    /// Delays the next request of a kind. The flag is set when it does.
    pub fn stalls(&self, kind: &'static str, time: Duration) -> Arc<AtomicBool> {
        let is_stalled = Arc::new(AtomicBool::new(false));
        let stalled = is_stalled.clone();
        self.before(move |name, _| {
            if name.starts_with(kind) && !stalled.swap(true, Ordering::SeqCst) {
                std::thread::sleep(time);
            }
        });
        is_stalled
    }
}

/// Waits, and gives no word meanwhile.
pub async fn until(flag: &AtomicBool) {
    for _ in 0..2000 {
        if flag.load(Ordering::SeqCst) {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("it does not come");
}

impl Wire for Line {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            return Ok(());
        }
        for byte in bytes {
            let mut deframer = self.deframer.lock().unwrap();
            let Some(message) = deframer.push(*byte) else { continue };
            let (_, request) = decode_request(message).unwrap();
            let name = format!("{:?}", request.unwrap());
            self.asked.lock().unwrap().push(name.clone());
            if let Some(before) = &mut *self.before.lock().unwrap() {
                before(&name, &mut self.device.lock().unwrap());
            }
        }
        let stalls = self.stalls_ms.swap(0, Ordering::SeqCst);
        std::thread::sleep(Duration::from_millis(stalls));
        self.device.lock().unwrap().send(bytes)
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            std::thread::sleep(at_most);
            return Ok(vec![]);
        }
        self.device.lock().unwrap().receive(at_most)
    }

    fn name(&self) -> String {
        "the device of the test".into()
    }

    fn real_time(&mut self) {
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
