//! What scripts of users rest on: the commands, options, exit codes, file keys, names of
//! experiments and families, JSON keys and CSV columns of commit 72adde7 still work.
//!
//! The files beside this one were recorded with the program of that commit: its help, its lists,
//! and the output of the commands that they name. Names may be added; one that is gone fails,
//! unless it is an alias. Left out on purpose: `device move 1000`, which is refused since targets
//! have a range, and a tuning without a success, which ends with 1 since it says so.
#![cfg(unix)]
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const STICTION: &str = env!("CARGO_BIN_EXE_stiction");

fn run(directory: &Path, arguments: &str) -> Output {
    Command::new(STICTION)
        .args(arguments.split_whitespace())
        .current_dir(directory)
        .output()
        .unwrap()
}

/// A directory with the two files that the recorded commands use.
fn prepared() -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for new in ["new arm.toml --typical thesis", "new gear.toml --typical harmonic"] {
        assert!(run(directory.path(), new).status.success(), "{new}");
    }
    directory
}

/// Reads a record of commands, each with indented lines below it.
fn below(record: &'static str) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut commands: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in record.lines() {
        match (line.strip_prefix("  "), commands.last_mut()) {
            (Some(inner), Some((_, lines))) => lines.push(inner),
            _ => commands.push((line, Vec::new())),
        }
    }
    commands
}

/// Returns the lines of a record for which `is_kept` is false.
fn gone(record: &'static str, is_kept: impl Fn(&str) -> bool) -> Vec<&'static str> {
    record.lines().filter(|line| !is_kept(line)).collect()
}

#[test]
fn every_command_and_option_is_there() {
    let directory = tempfile::tempdir().unwrap();
    let (mut count, mut gone) = (0, Vec::new());
    for line in include_str!("options.txt").lines() {
        let (command, options) = line.split_once(':').unwrap();
        // The help of a command that is not there is an error; so is an option before it.
        for option in options.split_whitespace().chain([""]) {
            let output = run(directory.path(), &format!("{command} {option} --help"));
            let said = String::from_utf8_lossy(&output.stderr);
            let is_unknown = ["unexpected argument", "unrecognized subcommand"];
            if is_unknown.iter().any(|why| said.contains(why)) {
                gone.push(format!("{command} {option}"));
            }
            count += 1;
        }
    }
    assert!(gone.is_empty() && count > 180, "{count}, gone: {gone:?}");
}

#[test]
fn every_key_of_a_file_every_experiment_and_every_family_is_known() {
    let directory = tempfile::tempdir().unwrap();
    let page = run(directory.path(), "keys --markdown").stdout;
    let page = String::from_utf8(page).unwrap();
    let mut keys = BTreeSet::new();
    let mut table = "";
    for line in page.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            table = heading.trim_matches(['[', ']']);
        } else if let Some(rest) = line.strip_prefix("| `") {
            keys.insert(format!("{table}|{}", rest.split('`').next().unwrap()));
        }
    }
    assert_eq!(gone(include_str!("keys.txt"), |key| keys.contains(key)), [""; 0]);
    let is_shown = |name: &str| run(directory.path(), &format!("show {name}")).status.success();
    assert_eq!(gone(include_str!("experiments.txt"), is_shown), [""; 0]);
    let is_run = |family: &str| {
        let command = format!("ensemble --plant {family} --cases 1 --controller pd");
        run(directory.path(), &command).status.success()
    };
    assert_eq!(gone(include_str!("families.txt"), is_run), [""; 0]);
}

fn paths(value: &Value, path: &str, all: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let path = format!("{path}.{key}");
                paths(value, &path, all);
                all.insert(path);
            }
        }
        Value::Array(list) => {
            list.iter().for_each(|value| paths(value, &format!("{path}[]"), all));
        }
        _ => {}
    }
}

#[test]
fn every_key_of_every_json_is_printed() {
    let directory = prepared();
    let (mut count, mut gone) = (0, Vec::new());
    for (command, recorded) in below(include_str!("json.txt")) {
        let output = run(directory.path(), command);
        let printed: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{command}: {why}"));
        let mut all = BTreeSet::new();
        paths(&printed, "", &mut all);
        count += recorded.len();
        let missing = recorded.into_iter().filter(|key| !all.contains(*key));
        gone.extend(missing.map(|key| format!("{command}: {key}")));
    }
    assert!(gone.is_empty() && count > 700, "{count}, gone: {gone:#?}");
}

#[test]
fn every_column_of_every_csv_is_written() {
    let directory = prepared();
    for (command, recorded) in below(include_str!("csv.txt")) {
        assert!(run(directory.path(), command).status.success(), "{command}");
        let file = directory.path().join("a.csv");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(file).unwrap();
        let header = text.lines().find(|line| !line.starts_with('#')).unwrap();
        let columns: BTreeSet<&str> = header.split(',').collect();
        let missing: Vec<&str> =
            recorded[0].split(',').filter(|column| !columns.contains(column)).collect();
        assert!(missing.is_empty() && columns.len() > 7, "{command}: {missing:?}");
    }
}

#[test]
fn every_exit_code_is_the_same() {
    let directory = prepared();
    for line in include_str!("exit.txt").lines() {
        let (code, command) = line.split_once(' ').unwrap();
        let output = run(directory.path(), command);
        assert_eq!(output.status.code().unwrap().to_string(), code, "{command}");
    }
}
