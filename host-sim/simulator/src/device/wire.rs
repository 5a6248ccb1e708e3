//! The wire between a client and a device, and that of a simulated device.

use std::collections::VecDeque;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use stiction::link::Refused;

use super::simulated::SimulatedDevice;
use crate::error::Error;

/// A way for bytes to a device and back.
pub trait Wire {
    /// Hands bytes to the device.
    ///
    /// # Errors
    /// If the wire is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error>;

    /// Waits for bytes from the device for `at_most`, and returns none if nothing came.
    ///
    /// # Errors
    /// If the wire is gone.
    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error>;

    /// The time that has passed on this wire. It is the host's, unless the device has a time of its
    /// own that stands still while nobody waits.
    fn now(&self) -> Duration {
        static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
        BEGIN.elapsed()
    }

    /// The name that messages give the other end, such as `the simulated device`.
    fn name(&self) -> String;

    /// The words that follow a refusal if this device cannot do what a board can. Most devices need
    /// none.
    fn excuse(&self, _: &Refused) -> &'static str {
        ""
    }

    /// Makes time pass as on the wall from now on, for a device that is watched. That of a board
    /// always does.
    fn real_time(&mut self) {}

    /// The warning that has to stand before whatever is shown of the device. A board needs none.
    fn warning(&self) -> Option<&'static str>;

    /// The load's angle minus the angle of the side that the encoder sits on, deg, in a tick of
    /// the device's clock. None from a device that measures its encoder only, and for a tick that
    /// is too long ago.
    fn load_ahead_deg(&self, _clock: u32) -> Option<f64> {
        None
    }
}

/// The wire to a simulated device. Its time passes while the client waits for it, as fast as it can
/// be computed, unless it is told to keep to the [`real_time`](Wire::real_time).
#[derive(Debug)]
pub struct SimulatedWire {
    /// The device and its joint.
    pub simulated: SimulatedDevice,
    out: VecDeque<u8>,
    /// The time on the wall at which the next tick is due.
    due: Option<Instant>,
}

/// The longest absence of the host that the device catches up with. A host that was away for longer
/// has stopped the device's time as well.
pub const AWAY: Duration = Duration::from_millis(200);

/// The warning that stands before every output of a simulated device.
pub const SIMULATED: &str = "SIMULATED DEVICE: no motor moves or stops.";

impl SimulatedWire {
    /// Turns the power on, and lets the joint rest for long enough to be armed.
    pub fn new(mut simulated: SimulatedDevice) -> Self {
        let ticks = (0.1 / simulated.sample_time_s()).ceil() as u32;
        simulated.ticks(ticks.max(1));
        Self { simulated, out: VecDeque::new(), due: None }
    }

    /// Runs the ticks that are due on the wall, and returns when the next one is.
    fn catch_up(&mut self, due: Instant) -> Instant {
        let tick = Duration::from_secs_f64(self.simulated.sample_time_s());
        let (mut due, now) = (due, Instant::now());
        if now.saturating_duration_since(due) > AWAY {
            due = now;
        }
        while due <= now {
            self.simulated.tick();
            // A wire takes what the device sends as it comes: after many ticks its buffer is full.
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
            let begin = Instant::now();
            let mut due = self.catch_up(due);
            while self.out.is_empty() && due < begin + at_most {
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                due = self.catch_up(due);
            }
            if self.out.is_empty() {
                std::thread::sleep((begin + at_most).saturating_duration_since(Instant::now()));
            }
            return Ok(self.out.drain(..).collect());
        }
        // At least one tick passes, or time would stand still for a client that waits in steps
        // shorter than a tick.
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

    fn name(&self) -> String {
        "the simulated device".into()
    }

    fn real_time(&mut self) {
        self.due = Some(Instant::now());
    }

    fn warning(&self) -> Option<&'static str> {
        Some(SIMULATED)
    }

    fn load_ahead_deg(&self, clock: u32) -> Option<f64> {
        self.simulated.load_ahead_at(clock)
    }
}
