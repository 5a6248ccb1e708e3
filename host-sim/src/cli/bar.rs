//! Progress bar of a command, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};

use files::error::Error;
use simulator::progress::Progress;

/// A bar on the standard error; hidden if that is not a terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// Creates a bar without steps.
    pub fn new() -> Self {
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}, {eta} left");
        let bar = ProgressBar::new(0);
        Self(style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style)))
    }
}

impl Progress for Bar {
    fn start(&self, steps: u64, name: &'static str) {
        self.0.reset();
        self.0.set_length(steps);
        self.0.set_message(name);
    }

    fn step(&self) -> Result<(), Error> {
        self.0.inc(1);
        Ok(())
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
