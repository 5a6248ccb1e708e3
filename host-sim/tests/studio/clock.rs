//! The clock of a test: it goes on only while the studio's thread waits for it, so a busy machine
//! makes nothing late.

use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use simulator::device::clock::Clock;

use super::page::PATIENCE;

/// The longest step.
pub const STEP: Duration = Duration::from_millis(5);

/// A clock that a test moves on.
#[derive(Debug, Default)]
pub struct TestClock {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    now: Duration,
    /// The times that threads sleep until.
    sleepers: Vec<Duration>,
    /// A thread that sleeps moves the clock on: nothing else does yet.
    is_free: bool,
}

impl State {
    /// Whether a thread sleeps, and none is about to wake up.
    fn is_idle(&self) -> bool {
        !self.sleepers.is_empty() && self.sleepers.iter().all(|until| *until > self.now)
    }
}

impl TestClock {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap()
    }

    /// Runs a start, in which the clock goes on as if nothing took any time.
    pub fn freely<T>(&self, start: impl FnOnce() -> T) -> T {
        self.state().is_free = true;
        let started = start();
        self.state().is_free = false;
        started
    }

    /// Whether the studio's thread waits for the clock.
    pub fn is_idle(&self) -> bool {
        self.state().is_idle()
    }

    /// Goes on by a step if the studio's thread waits, and returns whether it does.
    pub fn step(&self) -> bool {
        let mut state = self.state();
        let is_idle = state.is_idle();
        if is_idle {
            let next = state.sleepers.iter().min().copied().unwrap_or_default();
            state.now = next.min(state.now + STEP);
            self.changed.notify_all();
        }
        is_idle
    }

    /// Goes on by a time at once.
    pub fn jump(&self, time: Duration) {
        self.state().now += time;
        self.changed.notify_all();
    }

    /// Goes on, without any page, until something is the case.
    pub async fn until(&self, is_so: impl Fn() -> bool) {
        let begin = Instant::now();
        loop {
            let is_idle = self.is_idle();
            if is_so() {
                return;
            }
            assert!(begin.elapsed() < PATIENCE, "it does not come");
            if is_idle {
                self.step();
            } else {
                breath().await;
            }
        }
    }

    /// Goes on for a time, without any page.
    pub async fn pass(&self, time: Duration) {
        let end = self.now() + time;
        self.until(|| self.now() >= end).await;
    }
}

impl Clock for TestClock {
    fn now(&self) -> Duration {
        self.state().now
    }

    fn sleep_until(&self, time: Duration) {
        let mut state = self.state();
        if state.is_free {
            state.now = state.now.max(time);
        }
        if state.now >= time {
            return;
        }
        state.sleepers.push(time);
        while state.now < time && !state.is_free {
            state = self.changed.wait(state).unwrap();
        }
        let place = state.sleepers.iter().position(|until| *until == time).unwrap();
        state.sleepers.swap_remove(place);
    }
}

/// Lets other threads and the tasks of this one work.
pub async fn breath() {
    std::thread::sleep(Duration::from_micros(300));
    tokio::task::yield_now().await;
}
