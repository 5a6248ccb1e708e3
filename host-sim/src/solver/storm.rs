//! Events that do not end.

/// So many events within [`INSTANT`] of a run are no motion that anyone can follow.
const MOST: u32 = 200;

/// What counts as one instant, as a part of the run.
const INSTANT: f64 = 1e-9;

/// Counts events that happen at practically one instant: an accumulation of them (Zeno's) or chatter.
#[derive(Clone, Copy, Debug)]
pub struct Storm {
    instant_s: f64,
    from_s: f64,
    events: u32,
}

impl Storm {
    /// For a run of a duration.
    pub fn new(duration_s: f64) -> Self {
        Self { instant_s: INSTANT * duration_s, from_s: 0.0, events: 0 }
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
        if self.events > MOST {
            let span_s = self.instant_s;
            return Err(format!(
                "more than {MOST} changes between sticking and slipping within {span_s:e} s"
            ));
        }
        Ok(())
    }
}
