//! What the command line answers to wrong input, on the built program: one sentence that names
//! where the input came from, the key, what was found and what is allowed; exit code 2; nothing on
//! the standard output, and no half-written file. These tests are blind to figures, and to what a
//! directory's permissions forbid (tests may run as root).
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::process::{Command, Stdio};

use serde_json::Value;

mod data_sheet;
mod divergence;
mod files;
mod logs;
mod names;
mod not_built_in;
mod overwriting;
mod refusal;
mod set_keys;
mod spread;
mod too_much_work;
mod writing;

fn stiction(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// The text of a built-in experiment.
fn shown(name: &str) -> String {
    String::from_utf8(stiction(&["show", name]).output().unwrap().stdout).unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = stiction(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), said.as_str()), (Some(0), ""), "{arguments:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}
