//! Which page commands the device.
//!
//! One page at a time does: the first one, and after it whichever asks first. Two pages that both
//! move a joint would each be surprised. Every page may stop it.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Silence after which a page counts as gone: its connection may be cut without an end.
const SILENT: Duration = Duration::from_secs(3);

/// The page that commands, and when it last gave a word.
#[derive(Debug, Default)]
pub struct Control(Mutex<Option<(u64, Instant)>>);

/// What a page that may not command is told.
pub const TAKEN: &str = "another page commands the device, and one page at a time does. This one \
                         shows everything, and can stop it. Close the other page, and ask again";

impl Control {
    fn holder(&self) -> MutexGuard<'_, Option<(u64, Instant)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a page command if no other one does, and tells whether it does now.
    pub fn ask(&self, page: u64) -> bool {
        self.ask_at(page, Instant::now())
    }

    fn ask_at(&self, page: u64, now: Instant) -> bool {
        let mut holder = self.holder();
        let is_free = holder.is_none_or(|(held_by, word)| held_by == page || word + SILENT < now);
        if is_free {
            *holder = Some((page, now));
        }
        is_free
    }

    /// A page has given a word. Tells whether it commands.
    pub fn word(&self, page: u64) -> bool {
        let mut holder = self.holder();
        match holder.as_mut() {
            Some((held_by, word)) if *held_by == page => {
                *word = Instant::now();
                true
            }
            _ => false,
        }
    }

    /// Tells whether this page commands.
    pub fn is_held_by(&self, page: u64) -> bool {
        self.holder().is_some_and(|(held_by, _)| held_by == page)
    }

    /// Tells whether no page commands.
    pub fn is_free(&self) -> bool {
        self.holder().is_none()
    }

    /// A page has gone. Tells whether it was the one that commanded.
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
        let control = Control::default();
        assert!(control.ask(1) && control.ask(1));
        assert!(!control.ask(2) && !control.word(2));
        assert!(!control.leave(2), "it did not command");
        assert!(control.word(1) && control.is_held_by(1) && !control.is_free());
        assert!(control.leave(1) && control.is_free());
        assert!(control.ask(2) && !control.ask(1));
    }

    #[test]
    fn a_page_that_is_silent_for_long_loses_the_command_to_one_that_asks() {
        let (control, now) = (Control::default(), Instant::now());
        assert!(control.ask_at(1, now));
        assert!(!control.ask_at(2, now + SILENT - Duration::from_millis(1)));
        assert!(control.ask_at(2, now + SILENT + Duration::from_millis(1)));
        assert!(!control.word(1) && control.word(2));
    }
}
