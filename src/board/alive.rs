//! Which of the tasks that the watchdog watches have run.
//!
//! The control task leaves no mark here: it is what wakes the feeder, so the feeder has run if it has.

use core::sync::atomic::{AtomicBool, Ordering};

/// A task that is watched.
pub struct Mark(AtomicBool);

/// Of the link.
pub static LINK: Mark = Mark(AtomicBool::new(false));
/// Of the log.
pub static REPORT: Mark = Mark(AtomicBool::new(false));

impl Mark {
    /// The task has run to its end.
    pub fn leave(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_left(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn wipe(&self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// Whether all of them have run since this was last so; of the feeder only.
pub fn all_have_run() -> bool {
    let marks = [&LINK, &REPORT];
    let all = marks.iter().all(|mark| mark.is_left());
    if all {
        // A mark that is left right now is lost: that task leaves it again, a tick later.
        marks.iter().for_each(|mark| mark.wipe());
    }
    all
}
