//! What a client is wired to.

use std::collections::VecDeque;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use stiction::link::Refused;

use super::simulated::SimulatedDevice;
use crate::error::Error;

/// Bytes to a device and back.
pub trait Wire {
    /// Hands bytes to the device.
    ///
    /// # Errors
    /// If the wire is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error>;

    /// Waits for bytes from the device, at most so long; none if nothing came.
    ///
    /// # Errors
    /// If the wire is gone.
    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error>;

    /// Time, as it passes on this wire: the host's, unless the device has its own that stands still while nobody waits.
    fn now(&self) -> Duration {
        static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
        BEGIN.elapsed()
    }

    /// What is at the other end, for messages: `the simulated device`.
    fn name(&self) -> String;

    /// What is to be added to a refusal, where this device cannot do what a board can; nothing for most.
    fn excuse(&self, _: &Refused) -> &'static str {
        ""
    }

    /// From now on time passes as on the wall, for a device that is watched. That of a board always does.
    fn real_time(&mut self) {}

    /// What everything that is shown of it has to begin with; nothing for a board.
    fn warning(&self) -> Option<&'static str>;
}

/// A simulated device. Its time passes while the client waits for it, as fast as it can be computed, unless it is told
/// to keep to the [`real_time`](Wire::real_time).
#[derive(Debug)]
pub struct SimulatedWire {
    /// The device and its joint.
    pub simulated: SimulatedDevice,
    out: VecDeque<u8>,
    /// When the next tick is due on the wall.
    due: Option<Instant>,
}

/// A host that was away for longer has stopped the device's time as well.
pub(crate) const AWAY: Duration = Duration::from_millis(200);

/// Of every output of a simulated device.
pub const SIMULATED: &str = "SIMULATED DEVICE: no motor moves or stops.";

impl SimulatedWire {
    /// Power is on, and the joint has been at rest for long enough to be armed.
    pub fn new(mut simulated: SimulatedDevice) -> Self {
        let ticks = (0.1 / simulated.sample_time_s()).ceil() as u32;
        simulated.ticks(ticks.max(1));
        Self { simulated, out: VecDeque::new(), due: None }
    }

    /// Ticks that are due on the wall; returns when the next one is.
    fn catch_up(&mut self, due: Instant) -> Instant {
        let tick = Duration::from_secs_f64(self.simulated.sample_time_s());
        let (mut due, now) = (due, Instant::now());
        if now.saturating_duration_since(due) > AWAY {
            due = now;
        }
        while due <= now {
            self.simulated.tick();
            due += tick;
        }
        self.due = Some(due);
        self.collect();
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
        // At least one, or time would stand still for a client that waits in steps shorter than a tick.
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
}
