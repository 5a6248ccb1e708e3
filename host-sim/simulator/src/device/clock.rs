//! Clock of a client, and of a simulated device in real time.

use std::fmt::Debug;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// A clock that counts from an arbitrary start.
pub trait Clock: Debug + Send + Sync {
    /// Returns the time since the clock's start.
    fn now(&self) -> Duration;

    /// Blocks the thread until a time of this clock.
    fn sleep_until(&self, time: Duration);

    /// Blocks the thread for a time.
    fn sleep(&self, time: Duration) {
        self.sleep_until(self.now() + time);
    }
}

/// The clock of the computer. Tests have a clock of their own, which stands still while a thread
/// works.
#[derive(Clone, Copy, Debug, Default)]
pub struct ComputerClock;

impl Clock for ComputerClock {
    fn now(&self) -> Duration {
        static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
        BEGIN.elapsed()
    }

    fn sleep_until(&self, time: Duration) {
        std::thread::sleep(time.saturating_sub(self.now()));
    }
}
