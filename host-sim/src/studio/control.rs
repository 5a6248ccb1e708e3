//! Arbiter of the page that commands the device.
//!
//! One page at a time commands the device: the first page that connects, and once it has gone, the
//! first page that requests the command. Every page may stop the device.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Silence after which a page counts as gone, since a connection can be cut without being closed.
const SILENT: Duration = Duration::from_secs(3);

/// The page that commands, and the time of its last keep-alive.
#[derive(Debug, Default)]
pub struct PageControl(Mutex<Option<(u64, Duration)>>);

/// Answer to a page that does not command.
pub const TAKEN: &str = "another page commands the device. Only one page can command it. This page \
                         shows everything, and can stop the motor. Close the other page, then \
                         press `Request the command`";

impl PageControl {
    fn holder(&self) -> MutexGuard<'_, Option<(u64, Duration)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Assigns the command to a page unless another page holds it and has sent a keep-alive within
    /// `SILENT`. Returns whether the page now commands.
    pub fn ask(&self, page: u64, now: Duration) -> bool {
        let mut holder = self.holder();
        let is_free = holder.is_none_or(|(held_by, word)| held_by == page || word + SILENT < now);
        if is_free {
            *holder = Some((page, now));
        }
        is_free
    }

    /// Stores the time of a page's keep-alive, and returns whether the page commands.
    pub fn record_keep_alive(&self, page: u64, now: Duration) -> bool {
        let mut holder = self.holder();
        match holder.as_mut() {
            Some((held_by, word)) if *held_by == page => {
                *word = now;
                true
            }
            _ => false,
        }
    }

    /// Returns whether this page commands.
    pub fn is_held_by(&self, page: u64) -> bool {
        self.holder().is_some_and(|(held_by, _)| held_by == page)
    }

    /// Returns whether no page commands.
    pub fn is_free(&self) -> bool {
        self.holder().is_none()
    }

    /// Removes a page that has gone, and returns whether it commanded.
    pub fn leave(&self, page: u64) -> bool {
        let mut holder = self.holder();
        let held = holder.is_some_and(|(held_by, _)| held_by == page);
        if held {
            *holder = None;
        }
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_commands_until_it_leaves() {
        let (control, now) = (PageControl::default(), SILENT);
        assert!(control.ask(1, now) && control.ask(1, now));
        assert!(!control.ask(2, now) && !control.record_keep_alive(2, now));
        assert!(!control.leave(2), "it did not command");
        assert!(control.record_keep_alive(1, now) && control.is_held_by(1) && !control.is_free());
        assert!(control.leave(1) && control.is_free());
        assert!(control.ask(2, now) && !control.ask(1, now));
    }

    #[test]
    fn a_page_that_is_silent_for_long_loses_the_command_to_one_that_asks() {
        let (control, moment) = (PageControl::default(), Duration::from_millis(1));
        assert!(control.ask(1, moment));
        // Its last keep-alive counts.
        assert!(control.record_keep_alive(1, SILENT));
        assert!(!control.ask(2, 2 * SILENT - moment));
        let later = 2 * SILENT + moment;
        assert!(control.ask(2, later));
        assert!(!control.record_keep_alive(1, later) && control.record_keep_alive(2, later));
    }
}
