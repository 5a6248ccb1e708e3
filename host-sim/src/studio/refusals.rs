//! Tells what was refused, but not so often that it drowns the rest.

use std::fmt;
use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// So many refusals are told in each [`WITHIN`]; what comes beyond is counted.
const TOLD: u32 = 8;

/// The time that [`TOLD`] is counted in.
const WITHIN: Duration = Duration::from_secs(10);

/// Refusals of the time that is counted in.
#[derive(Debug, Default)]
struct Counted {
    since: Option<Instant>,
    told: u32,
    untold: u32,
}

impl Counted {
    /// Returns what is told of a refusal; nothing if there were too many.
    fn line(&mut self, what: &str, now: Instant) -> Option<String> {
        if self.since.is_none_or(|since| now.duration_since(since) >= WITHIN) {
            (self.since, self.told) = (Some(now), 0);
        }
        if self.told == TOLD {
            self.untold = self.untold.saturating_add(1);
            return None;
        }
        self.told += 1;
        let untold = match std::mem::take(&mut self.untold) {
            0 => String::new(),
            count => format!(" ({count} refusals before it were not told)"),
        };
        Some(format!("{what}{untold}"))
    }
}

/// The refusals of a server, and who is told of them.
pub struct Refusals {
    counted: Mutex<Counted>,
    to: Box<dyn Fn(&str) + Send + Sync>,
}

impl fmt::Debug for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Refusals").field("counted", &self.counted).finish_non_exhaustive()
    }
}

impl Refusals {
    /// Tells refusals to somebody.
    pub fn new(to: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { counted: Mutex::default(), to: Box::new(to) }
    }

    /// Tells of a refusal, unless there were too many.
    pub fn tell(&self, what: &str) {
        let mut counted = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(line) = counted.line(what, Instant::now()) {
            (self.to)(&line);
        }
    }
}

/// Tells the person at the terminal.
pub fn at_the_terminal(what: &str) {
    // If even this cannot be written there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "stiction: studio: {what}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_refusal_is_told_until_there_are_too_many_and_those_are_counted() {
        let (mut all, begin) = (Counted::default(), Instant::now());
        for _ in 0..TOLD {
            assert_eq!(all.line("no", begin).as_deref(), Some("no"));
        }
        let almost = begin + WITHIN - Duration::from_millis(1);
        assert_eq!((all.line("no", begin), all.line("no", almost)), (None, None));
        let counted = all.line("again", begin + WITHIN);
        assert_eq!(counted.as_deref(), Some("again (2 refusals before it were not told)"));
        assert_eq!(all.line("no", begin + WITHIN).as_deref(), Some("no"));
    }
}
