//! Events that do not end.

/// So many events within [`INSTANT`] of a run are no motion that anyone can follow.
const MOST: u32 = 200;

/// What counts as one instant, as a part of the run.
const INSTANT: f64 = 1e-9;

/// So many events in all are no result that anyone can read, and some tens of megabytes.
const MOST_IN_ALL: u64 = 1_000_000;

/// Counts events: those at practically one instant, where they accumulate (Zeno's) or chatter, and all of a run.
#[derive(Clone, Copy, Debug)]
pub struct Storm {
    instant_s: f64,
    from_s: f64,
    events: u32,
    in_all: u64,
}

impl Storm {
    /// For a run of a duration.
    pub fn new(duration_s: f64) -> Self {
        Self { instant_s: INSTANT * duration_s, from_s: 0.0, events: 0, in_all: 0 }
    }

    /// Counts an event.
    ///
    /// # Errors
    /// In words, when there are too many.
    pub fn count(&mut self, time_s: f64) -> Result<(), String> {
        if time_s - self.from_s > self.instant_s {
            (self.from_s, self.events) = (time_s, 0);
        }
        self.events += 1;
        self.in_all += 1;
        if self.events > MOST {
            let span_s = self.instant_s;
            return Err(format!(
                "more than {MOST} changes between sticking and slipping within {span_s:e} s"
            ));
        }
        if self.in_all > MOST_IN_ALL {
            return Err(format!("more than {MOST_IN_ALL} changes between sticking and slipping"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_bounded_at_one_instant_and_in_all() {
        let mut storm = Storm::new(1.0);
        assert!((0..MOST).all(|_| storm.count(0.5).is_ok()));
        assert!(storm.count(0.5).unwrap_err().starts_with("more than 200 changes"));
        // One an instant is no storm, until nobody can read them any more.
        let mut storm = Storm::new(1.0);
        assert!((0..MOST_IN_ALL).all(|i| storm.count(2e-9 * i as f64).is_ok()));
        assert!(storm.count(1.0).unwrap_err().starts_with("more than 1000000 changes"));
    }
}
