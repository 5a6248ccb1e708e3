//! The parameters in use as a machine's file, and how long they last.

use stiction::Parameters;

use files::error::Error;
use simulator::device::client::Client;
use simulator::device::machine_file;
use simulator::device::wire::Wire;
use simulator::experiment::Document;

/// Saves the parameters in use if `save` is set, and returns a sentence on how long they last.
pub fn keep<W: Wire>(client: &mut Client<W>, save: bool) -> Result<&'static str, Error> {
    if save {
        client.save()?;
        return Ok("in use now, and saved for the next reset\n");
    }
    Ok("in use now, not saved: `params save` keeps them across a reset\n")
}

/// Returns parameters of the device as the text of a machine's file with the joint of `machine`. If
/// the device is not a board, the file begins with a warning.
pub fn pulled<W: Wire>(
    client: &Client<W>,
    found: &Parameters,
    machine: &str,
) -> Result<String, Error> {
    let joint = Document::open(machine)?.machine()?.joint;
    let warning = client.warning().map_or(String::new(), |warning| format!("# {warning}\n"));
    Ok(warning + &machine_file::render(found, &joint, machine)?)
}
