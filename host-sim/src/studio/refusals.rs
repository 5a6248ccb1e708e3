//! Reports of refusals, limited in their rate so that they do not hide other output.

use std::fmt;
use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use simulator::device::clock::Clock;

/// Largest number of refusals reported in a period of [`WITHIN`]; further ones are only counted.
const MOST_REPORTED: u32 = 8;

/// Period in which at most [`MOST_REPORTED`] refusals are reported.
const WITHIN: Duration = Duration::from_secs(10);

/// Refusals of the present period.
#[derive(Debug, Default)]
struct RefusalWindow {
    since: Option<Duration>,
    reported: u32,
    suppressed: u32,
}

impl RefusalWindow {
    /// Returns the line that reports a refusal, or `None` after too many in this period.
    fn line(&mut self, what: &str, now: Duration) -> Option<String> {
        if self.since.is_none_or(|since| now.saturating_sub(since) >= WITHIN) {
            (self.since, self.reported) = (Some(now), 0);
        }
        if self.reported == MOST_REPORTED {
            self.suppressed = self.suppressed.saturating_add(1);
            return None;
        }
        self.reported += 1;
        let suppressed = match std::mem::take(&mut self.suppressed) {
            0 => String::new(),
            count => format!(" ({count} refusals before it were not reported)"),
        };
        Some(format!("{what}{suppressed}"))
    }
}

/// Refusals of a server, with the function that prints them.
pub struct Refusals {
    clock: Arc<dyn Clock>,
    counted: Mutex<RefusalWindow>,
    to: Box<dyn Fn(&str) + Send + Sync>,
}

impl fmt::Debug for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Refusals").field("counted", &self.counted).finish_non_exhaustive()
    }
}

impl Refusals {
    /// Reports refusals to a function, in periods of a clock.
    pub fn new(clock: Arc<dyn Clock>, to: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { clock, counted: Mutex::default(), to: Box::new(to) }
    }

    /// Reports a refusal, unless too many were reported in this period.
    pub fn report(&self, what: &str) {
        let mut counted = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(line) = counted.line(what, self.clock.now()) {
            (self.to)(&line);
        }
    }
}

/// Reports a refusal at the terminal.
pub fn at_the_terminal(what: &str) {
    // If this cannot be written, there is no other place to report to.
    let _ = writeln!(std::io::stderr(), "stiction: studio: {what}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_refusal_is_reported_until_there_are_too_many_and_those_are_counted() {
        let (mut all, begin) = (RefusalWindow::default(), Duration::from_secs(5));
        for _ in 0..MOST_REPORTED {
            assert_eq!(all.line("no", begin).as_deref(), Some("no"));
        }
        let almost = begin + WITHIN - Duration::from_millis(1);
        assert_eq!((all.line("no", begin), all.line("no", almost)), (None, None));
        let counted = all.line("again", begin + WITHIN);
        assert_eq!(counted.as_deref(), Some("again (2 refusals before it were not reported)"));
        assert_eq!(all.line("no", begin + WITHIN).as_deref(), Some("no"));
    }
}
