//! The wire between a client and a device, and the wire of a simulated device.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use stiction::link::RequestRefusal;

use super::clock::{Clock, ComputerClock};
use super::simulated::SimulatedDevice;
use files::error::Error;

/// A byte channel to a device and back.
pub trait Wire {
    /// Sends bytes to the device.
    ///
    /// # Errors
    /// Returns an error if the wire is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error>;

    /// Returns bytes from the device; no bytes if none arrive within `at_most`.
    ///
    /// # Errors
    /// Returns an error if the wire is gone.
    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error>;

    /// Returns the time of this wire, by default that of the computer. The time of an emulated
    /// board stands still while the client does not wait.
    fn now(&self) -> Duration {
        ComputerClock.now()
    }

    /// Returns the name of the other end in messages, such as `the simulated device`.
    fn name(&self) -> String;

    /// Returns words that follow a refusal if this device lacks a feature of a board. Empty for
    /// most devices.
    fn excuse(&self, _: &RequestRefusal) -> &'static str {
        ""
    }

    /// Switches a simulated device to real time, so that it can be watched. A board always runs in
    /// real time.
    fn real_time(&mut self) {}

    /// Returns whether the joint is at zero and the device has no reference yet: the case of an
    /// emulated board that has just been switched on.
    fn stands_at_zero(&mut self) -> bool {
        false
    }

    /// Returns the warning that precedes every output about the device. A board needs none.
    fn warning(&self) -> Option<&'static str>;

    /// Returns the load's angle minus that of the encoder's side, deg, at a tick of the device's
    /// clock. `None` if the device measures its encoder only, or if the tick is too long ago.
    fn load_ahead_deg(&self, _clock: u32) -> Option<f64> {
        None
    }
}

/// The wire to a simulated device. The device's time passes only while the client waits, as fast as
/// it can be computed, unless [`real_time`](Wire::real_time) is on.
#[derive(Debug)]
pub struct SimulatedWire {
    /// The device and its joint.
    pub simulated: SimulatedDevice,
    out: VecDeque<u8>,
    /// Clock for real time.
    clock: Arc<dyn Clock>,
    /// Time of the next tick on the clock; `None` without real time.
    due: Option<Duration>,
}

/// Longest pause of the host that a device in real time catches up with. A longer pause is skipped:
/// the device's time stands still meanwhile.
pub const AWAY: Duration = Duration::from_millis(200);

/// Warning that precedes every output about a simulated device.
pub const SIMULATED: &str = "SIMULATED DEVICE: no motor moves or stops.";

impl SimulatedWire {
    /// Creates the wire of a powered device whose joint has rested long enough (0.1 s) to be armed.
    pub fn new(simulated: SimulatedDevice) -> Self {
        Self::on_clock(simulated, Arc::new(ComputerClock))
    }

    /// Creates the wire as [`new`](Self::new) does, with a given clock for real time.
    pub fn on_clock(mut simulated: SimulatedDevice, clock: Arc<dyn Clock>) -> Self {
        let ticks = (0.1 / simulated.sample_time_s()).ceil() as u32;
        simulated.ticks(ticks.max(1));
        Self { simulated, out: VecDeque::new(), clock, due: None }
    }

    /// Runs the ticks that are due in real time, and returns the time of the next one.
    fn catch_up(&mut self, due: Duration) -> Duration {
        let tick = Duration::from_secs_f64(self.simulated.sample_time_s());
        let (mut due, now) = (due, self.clock.now());
        if now.saturating_sub(due) > AWAY {
            due = now;
        }
        while due <= now {
            self.simulated.tick();
            // Collect after each tick: the send buffer of the device overflows otherwise.
            self.collect();
            due += tick;
        }
        self.due = Some(due);
        due
    }

    fn collect(&mut self) {
        let mut buffer = [0; 256];
        loop {
            match self.simulated.device.transmit(&mut buffer) {
                0 => return,
                count => self.out.extend(buffer.iter().take(count)),
            }
        }
    }
}

impl Wire for SimulatedWire {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if let Some(due) = self.due {
            self.catch_up(due);
        }
        self.simulated.device.receive(bytes);
        self.collect();
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        if let Some(due) = self.due {
            let end = self.clock.now() + at_most;
            let mut due = self.catch_up(due);
            while self.out.is_empty() && due < end {
                self.clock.sleep_until(due);
                due = self.catch_up(due);
            }
            if self.out.is_empty() {
                self.clock.sleep_until(end);
            }
            return Ok(self.out.drain(..).collect());
        }
        // At least one tick passes: otherwise time would stand still for a client that waits in
        // steps shorter than a tick.
        let ticks = (at_most.as_secs_f64() / self.simulated.sample_time_s() - 1e-6).ceil() as u32;
        for _ in 0..ticks {
            if !self.out.is_empty() {
                break;
            }
            self.simulated.tick();
            self.collect();
        }
        Ok(self.out.drain(..).collect())
    }

    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn name(&self) -> String {
        "the simulated device".into()
    }

    fn real_time(&mut self) {
        self.due = Some(self.clock.now());
    }

    fn warning(&self) -> Option<&'static str> {
        Some(SIMULATED)
    }

    fn load_ahead_deg(&self, clock: u32) -> Option<f64> {
        self.simulated.load_ahead_at(clock)
    }
}
