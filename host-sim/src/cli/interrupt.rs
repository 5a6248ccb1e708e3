//! Ctrl-C: the first one ends the work in order, the second one ends the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use files::error::Error;

/// Sets `interrupt` at the first Ctrl-C, and ends the program at the second one or if it is already
/// set. Must be called once in a process.
///
/// # Errors
/// Returns an error if the system does not install the handler.
pub fn end_on_ctrl_c(interrupt: &Arc<AtomicBool>) -> Result<(), Error> {
    let interrupt = interrupt.clone();
    ctrlc::set_handler(move || {
        if interrupt.swap(true, Ordering::Relaxed) {
            std::process::exit(super::INTERRUPTED.into());
        }
    })
    .map_err(|error| Error::Device(format!("cannot listen for Ctrl-C: {error}")))
}
