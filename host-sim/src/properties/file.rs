//! A machine's file: any text is a machine or one sentence that names the file.

use crate::device::machine_file::{read, render};
use crate::experiment::Document;

const NAME: &str = "joint.toml";

/// Returns whether the text is a machine that a device can run.
pub fn holds(text: &str) -> bool {
    let said = |error: &crate::Error| {
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
    assert!(parameters.prepare().is_ok(), "what a file says is valid");
    // What is pulled from the device that it was pushed to.
    if let Ok(pulled) = render(&parameters, &machine.joint, NAME) {
        assert_eq!(read(NAME, &pulled).ok().as_ref(), Some(&parameters), "{pulled}");
    }
    true
}
