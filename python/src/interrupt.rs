//! Long work on another thread, which Ctrl-C ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::{PyErr, PyResult, Python};

use super::error::exception;
use files::error::Error;
use simulator::progress::Progress;

/// Time between two looks at the interpreter's signals.
const LOOKS_EVERY: Duration = Duration::from_millis(50);

/// Whether the user has interrupted the work.
#[derive(Debug, Default)]
pub struct Interrupt(AtomicBool);

impl Interrupt {
    /// Returns whether the work goes on.
    pub fn goes_on(&self) -> bool {
        !self.0.load(Ordering::Relaxed)
    }
}

impl Progress for Interrupt {
    fn start(&self, _: u64, _: &'static str) {}

    fn step(&self) -> Result<(), Error> {
        if self.goes_on() { Ok(()) } else { Err(Error::Run("interrupted".into())) }
    }
}

/// Runs work without the interpreter's lock. If a signal's handler raises an exception, the work is
/// ended at its next step, and the exception is returned.
///
/// # Errors
/// Returns the exception of the work's error, or that of the signal.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Interrupt) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let interrupt = Interrupt::default();
    let mut raised: Option<PyErr> = None;
    let result = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            let interrupt = &interrupt;
            let worker = scope.spawn(move || {
                let result = work(interrupt);
                // The receiver waits until this thread ends.
                let _ = sender.send(());
                result
            });
            while let Err(RecvTimeoutError::Timeout) = receiver.recv_timeout(LOOKS_EVERY) {
                if raised.is_none() {
                    raised = Python::attach(|py| py.check_signals()).err();
                }
                interrupt.0.store(raised.is_some(), Ordering::Relaxed);
            }
            worker.join()
        })
    });
    match (raised, result) {
        (Some(raised), _) => Err(raised),
        (None, Ok(result)) => result.map_err(|error| exception(&error)),
        (None, Err(panic)) => std::panic::resume_unwind(panic),
    }
}
