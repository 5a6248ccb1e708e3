//! Property of a machine's file: any text is read as a machine, or refused with one sentence that
//! names the file.

use crate::device::machine_file::{read, render};
use crate::experiment::Document;
use files::hardware::STM32F405;

const NAME: &str = "joint.toml";

/// Reasons of `device::machine_file` for parameters that no file can hold: a number without exact
/// decimals, or a motion that only holds.
const NO_FILE: [&str; 2] = ["a value cannot be written exactly", "nothing to run"];

/// Reads the text, and asserts the property. Returns whether the text is a machine that a device
/// can run.
pub fn holds(text: &str) -> bool {
    let said = |error: &files::Error| {
        let said = error.to_string();
        assert!(said.starts_with(NAME) && said.lines().count() == 1, "{said}");
    };
    let machine = match Document::parse(NAME, text).and_then(|document| document.machine()) {
        Ok(machine) => machine,
        Err(error) => {
            said(&error);
            return false;
        }
    };
    let parameters = match read(NAME, text) {
        Ok(parameters) => parameters,
        Err(error) => {
            said(&error);
            return false;
        }
    };
    assert!(parameters.prepare(&STM32F405).is_ok(), "parameters of a file are valid");
    // Pulls the parameters back from a device.
    match render(&parameters, &machine.joint, NAME) {
        Ok(pulled) => assert_eq!(read(NAME, &pulled).ok().as_ref(), Some(&parameters), "{pulled}"),
        Err(error) => {
            let said = error.to_string();
            assert!(NO_FILE.iter().any(|reason| said.contains(reason)), "{said}");
        }
    }
    true
}
