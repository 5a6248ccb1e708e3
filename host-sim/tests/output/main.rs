//! What the command line prints and writes when all is well, on the built program: JSON, CSV,
//! tables, labels, and the keys that a user sets. These tests are blind to figures, and to whether
//! the numbers are right (that is for the tests of the plant).
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::process::Command;

use serde_json::Value;

mod csv;
mod experiments;
mod identified;
mod identified_slack;
mod identify;
mod identify_gear;
mod identify_machine;
mod json;
mod motor_current;
mod new_joint;
mod own_file;
#[cfg(feature = "shared-law")]
mod own_law;
mod plots;
mod runs;
mod standard_output;
mod table;
mod tuning;
mod version;

/// Returns what the program prints. It must succeed, and say nothing on its standard error but
/// which files it wrote.
fn stiction(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let writes = ["--csv", "--into", "--plot", "tune"];
    let asked = arguments.iter().any(|argument| writes.contains(argument));
    let is_reported = said.lines().all(|line| asked && line.starts_with("wrote "));
    assert!(
        output.status.success() && is_reported && asked != said.is_empty(),
        "{arguments:?}: {}, {said}",
        output.status
    );
    String::from_utf8(output.stdout).unwrap()
}

fn run(arguments: &[&str]) -> Value {
    serde_json::from_str(&stiction(&[&["run", "--json"], arguments].concat())).unwrap()
}

fn runs(report: &Value) -> &[Value] {
    report["runs"].as_array().unwrap()
}

fn labels(report: &Value) -> Vec<&str> {
    runs(report).iter().map(|run| run["label"].as_str().unwrap()).collect()
}

fn keys(object: &Value) -> BTreeSet<&str> {
    object.as_object().unwrap().keys().map(String::as_str).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}
