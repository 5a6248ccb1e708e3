//! The liveness of the tasks that the watchdog watches: which of them have run since it was fed
//! last.
//!
//! The control task is not among them: it wakes the feeder, so the feeder runs only if the control
//! task has run.

use core::sync::atomic::{AtomicBool, Ordering};

/// Flag of one task: whether it has run.
pub struct Liveness(AtomicBool);

/// The flag of the link's task.
pub static LINK: Liveness = Liveness(AtomicBool::new(false));
/// The flag of the log's task.
pub static REPORT: Liveness = Liveness(AtomicBool::new(false));

impl Liveness {
    /// Sets the flag: the task has run to its end.
    pub fn has_run(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn clear(&self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// Returns whether all of the tasks have run since this last returned true. Only the feeder may
/// call this.
pub fn all_have_run() -> bool {
    let tasks = [&LINK, &REPORT];
    let all = tasks.iter().all(|task| task.is_set());
    if all {
        // A flag that is set right now is lost: that task sets it again, a tick later.
        tasks.iter().for_each(|task| task.clear());
    }
    all
}
