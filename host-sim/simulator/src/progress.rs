//! Progress of work that takes long, and how to end it early.

use files::error::Error;

/// Receives the progress of work on all cores. A command draws a bar; a program that embeds the
/// simulator ends the work when its user interrupts it.
pub trait Progress: Sync {
    /// Called before a batch of work, with its number of steps and their name in the plural. One
    /// piece of work can have several batches, one after the other.
    fn start(&self, steps: u64, name: &'static str);

    /// Called after each step, from any thread.
    ///
    /// # Errors
    /// Returns an error to end the work; the work returns it. Steps that run on other threads
    /// finish first.
    fn step(&self) -> Result<(), Error>;
}

/// Progress that reports nothing and never ends the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _: u64, _: &'static str) {}

    fn step(&self) -> Result<(), Error> {
        Ok(())
    }
}
