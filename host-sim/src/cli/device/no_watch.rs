//! Replaces the live view in a program that is built without it.

use files::error::Error;
use files::missing_part::not_built;
use simulator::device::client::Client;
use simulator::device::wire::Wire;

/// Refuses the command before the device receives anything.
///
/// # Errors
/// Always returns an error, with the command that builds a program with the view.
pub fn on_a_terminal() -> Result<(), Error> {
    Err(not_built("device watch", "the live view is", "watch"))
}

/// Replaces the view. It is not reached, since `on_a_terminal` refuses the command first.
///
/// # Errors
/// Always returns an error.
pub fn watch<W: Wire>(_: &mut Client<W>) -> Result<String, Error> {
    on_a_terminal().map(|()| String::new())
}
