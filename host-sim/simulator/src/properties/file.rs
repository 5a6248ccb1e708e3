//! A machine's file: any text is a machine or one sentence that names the file.

use crate::device::machine_file::{read, render};
use crate::experiment::Document;
use crate::hardware::STM32F405;

const NAME: &str = "joint.toml";

/// Why there may be no file of what a device runs, as `device::machine_file` has it: its decimals
/// are those of another number, or a motion that only holds.
const NO_FILE: [&str; 2] = ["a value lies between those that a file can have", "nothing to run"];

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
    assert!(parameters.prepare(&STM32F405).is_ok(), "what a file says is valid");
    // What is pulled from the device that it was pushed to.
    match render(&parameters, &machine.joint, NAME) {
        Ok(pulled) => assert_eq!(read(NAME, &pulled).ok().as_ref(), Some(&parameters), "{pulled}"),
        Err(error) => {
            let said = error.to_string();
            assert!(NO_FILE.iter().any(|reason| said.contains(reason)), "{said}");
        }
    }
    true
}
