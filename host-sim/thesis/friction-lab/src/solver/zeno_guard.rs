//! Limits the number of events, so that every run ends.
//!
//! Events can accumulate at one instant (Zeno behaviour) or chatter there, so that no step passes
//! it. They can also be too many in the whole run.

/// Largest number of events within one instant of a run.
const MOST_AT_ONE_INSTANT: u32 = 200;

/// Length of an instant, as a share of the run.
const INSTANT: f64 = 1e-9;

/// Largest number of events in a run: some tens of megabytes.
const MOST_IN_ALL: u64 = 1_000_000;

/// Counts the events within one instant, and those of the whole run.
#[derive(Clone, Copy, Debug)]
pub struct ZenoGuard {
    instant_s: f64,
    from_s: f64,
    events: u32,
    in_all: u64,
}

impl ZenoGuard {
    /// The guard of a run of this duration.
    pub fn new(duration_s: f64) -> Self {
        Self { instant_s: INSTANT * duration_s, from_s: 0.0, events: 0, in_all: 0 }
    }

    /// Counts an event.
    ///
    /// # Errors
    /// Says that there are too many.
    pub fn count(&mut self, time_s: f64) -> Result<(), String> {
        if time_s - self.from_s > self.instant_s {
            (self.from_s, self.events) = (time_s, 0);
        }
        self.events += 1;
        self.in_all += 1;
        if self.events > MOST_AT_ONE_INSTANT {
            let span_s = self.instant_s;
            return Err(format!(
                "the solver has ended the run (more than {MOST_AT_ONE_INSTANT} changes between \
                 sticking and slipping within {span_s:e} s; use another solver or friction)"
            ));
        }
        if self.in_all > MOST_IN_ALL {
            return Err(format!(
                "the solver has ended the run (more than {MOST_IN_ALL} changes between sticking \
                 and slipping; use a shorter run, or another solver or friction)"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_bounded_at_one_instant_and_in_all() {
        let mut guard = ZenoGuard::new(1.0);
        assert!((0..MOST_AT_ONE_INSTANT).all(|_| guard.count(0.5).is_ok()));
        assert!(guard.count(0.5).unwrap_err().contains("(more than 200 changes"));
        // One event per instant is accepted, up to the limit of the run.
        let mut guard = ZenoGuard::new(1.0);
        assert!((0..MOST_IN_ALL).all(|i| guard.count(2e-9 * i as f64).is_ok()));
        assert!(guard.count(1.0).unwrap_err().contains("(more than 1000000 changes"));
    }
}
