//! `stiction identify LOG.csv --machine FILE`: the joint of a log in a user's own file.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{number, stiction};

const COLUMNS: [&str; 6] =
    ["--time", "time_s", "--position", "position_deg", "--effort", "v_applied_v"];

fn path(directory: &Path, name: &str) -> String {
    directory.join(name).to_str().unwrap().to_owned()
}

/// A joint as its user knows it, and the log of what it is: 0.437 kg m^2 with the rotor, 4.1 N m.
fn joint(directory: &Path) -> (String, String) {
    let [truth, file, log] =
        ["truth.toml", "joint.toml", "log.csv"].map(|name| path(directory, name));
    stiction(&["new", &truth, "--typical", "harmonic"]);
    let trajectory = "reference.trajectories=[{corner_times_s=[0.5, 1.5, 2, 2.3, 3, 5, 5.5, 6.1], \
                      corner_positions_deg=[0, 40, 40, 10, 10, -30, -30, 20], half_blend_s=0.1}]";
    let run = ["run", &truth, "--controller", "both", "--csv", &log, "--set", trajectory];
    stiction(&[&run[..], &["--set", "reference.steps_deg=[]"]].concat());
    let text = fs::read_to_string(&truth).unwrap();
    let known = [
        ("slip_nm = 4.1 ", "slip_nm = 3.0 "),
        ("inertia_kg_m2 = 0.1 ", "inertia_kg_m2 = 0.5 "),
        ("# stiffness_nm_per_rad = 1e4  ", "stiffness_nm_per_rad = 1e4  "),
        ("ratio = 50.0  ", "backlash_deg = 0.05\nratio = 50.0  "),
    ];
    let text = known.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let more = "\n[goal]\ntolerance_deg = 0.05\n\n[limits]\nbreakaway_v = 3.0 # mine\n";
    fs::write(&file, text + more).unwrap();
    (file, log)
}

#[test]
fn the_joint_of_a_log_is_merged_into_the_user_s_file_of_which_everything_else_stays() {
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = joint(directory.path());
    let into = path(directory.path(), "new.toml");
    let identify = [&["identify", &log, "--machine", &file, "--json"], &COLUMNS[..]].concat();
    let found = stiction(&[&identify[..], &["--into", &into]].concat());
    let found: Value = serde_json::from_str(&found).unwrap();
    // The effort is in volts by its name, so the gain is the file's: 50 x 0.0909 / 2.51.
    assert!((number(&found["effort_gain"]) / 1.81076 - 1.0).abs() < 1e-5, "{found}");
    let [before, after] = [&file, &into].map(|file| fs::read_to_string(file).unwrap());
    let [old, new]: [toml::Table; 2] = [&before, &after].map(|text| text.parse().unwrap());
    for table in
        ["motor", "gear", "encoder", "supply", "drive", "loop", "controller", "limits", "goal"]
    {
        assert_eq!(old[table], new[table], "{table}");
    }
    let of = |table: &str, key: &str| new[table][key].as_float().unwrap();
    // The viscous friction is without the back-EMF.
    for (table, key, truth) in [
        ("load", "inertia_kg_m2", 0.1),
        ("friction", "slip_nm", 4.1),
        ("friction", "viscous_nm_s_per_rad", 1.3),
    ] {
        assert!((of(table, key) / truth - 1.0).abs() < 0.03, "{key}: {after}");
    }
    // A log has no static friction.
    assert_eq!(of("friction", "stick_nm"), 4.9);
    let kept = found["kept"].to_string();
    for key in ["gear.backlash_deg", "gear.stiffness_nm_per_rad", "friction.stick_nm"] {
        assert!(kept.contains(key), "{key}: {kept}");
    }
    let contradicted = found["contradicted"].as_array().unwrap();
    let named: Vec<&str> = contradicted.iter().map(|one| one["key"].as_str().unwrap()).collect();
    assert_eq!(named, ["load.inertia_kg_m2", "friction.slip_nm"]);
    // Each line of the user's that is no number of the joint is there.
    for line in before.lines() {
        let is_measured =
            ["slip_nm", "inertia_kg_m2", "viscous_nm"].iter().any(|key| line.starts_with(key));
        assert!(is_measured || after.contains(line), "`{line}` is gone");
    }
    assert!(after.contains("# identified"), "comments of measured lines stay, too: {after}");
    for (key, range) in new["spread"].as_table().unwrap() {
        let (table, key) = key.split_once('.').unwrap();
        let [low, high] = [0, 1].map(|end| range[end].as_float().unwrap());
        assert!(low <= of(table, key) && of(table, key) <= high, "{key}: {after}");
    }
    stiction(&["run", &into, "--controller", "srnf"]);
}

#[test]
fn what_the_units_of_the_log_or_its_friction_contradict_in_the_file_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = joint(directory.path());
    let said = |options: &[&str]| {
        let command = [&["identify", &log, "--machine", &file], &COLUMNS[..], options].concat();
        let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(command).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        (String::from_utf8_lossy(&output.stdout).into_owned(), said)
    };
    let (text, warned) = said(&[]);
    assert_eq!(warned, "");
    let words = "contradicted: friction.slip_nm is 3 in ";
    assert!(text.contains(words) && text.contains("kept from "), "{text}");
    // 2.4 N m for a volt, where motor and gear give 1.81.
    let (_, warned) = said(&["--effort-gain", "2.4"]);
    assert!(warned.contains("--effort-gain is 2.4 N m for 1 V, but motor.kt_nm_per_a"), "{warned}");
    // 100000 counts in a turn of the joint.
    let options = ["--position-unit", "count", "--counts-per-turn"];
    let (_, warned) = said(&[&options[..], &["8192"]].concat());
    assert!(warned.contains("encoder.lines of ") && warned.contains("gives 100000"), "{warned}");
    let (_, warned) = said(&[&options[..], &["100000"]].concat());
    assert!(!warned.contains("encoder.lines"), "{warned}");
    // A threshold below what the log shows: 4.1 N m are 2.26 V.
    let text = fs::read_to_string(&file).unwrap();
    let text = text.replace("breakaway_v = 3.0 # mine", "breakaway_v = 1.5 # mine");
    let text = text.replace("[motor]\n", "[motor]\ndead_time_s = 1e-6\n");
    fs::write(&file, text).unwrap();
    let into = path(directory.path(), "new.toml");
    let (text, _) = said(&["--into", &into]);
    assert!(text.contains("contradicted: limits.breakaway_v is 1.5 in "), "{text}");
    let new = fs::read_to_string(&into).unwrap();
    let written: toml::Table = new.parse().unwrap();
    let limit = written["limits"]["breakaway_v"].as_float().unwrap();
    assert!((2.2..2.4).contains(&limit) && new.contains("# mine"), "{limit}");
    // What the dead time takes is in the friction of the log.
    assert!(written["motor"].get("dead_time_s").is_none(), "{new}");
    assert_eq!(written["device"]["dead_time_s"].as_float(), Some(1e-6));
}

#[test]
fn a_file_in_degrees_and_volts_and_an_effort_of_no_unit_are_refused_with_what_to_do() {
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = joint(directory.path());
    let text = fs::read_to_string(&log).unwrap().replacen("v_applied_v", "effort", 1);
    fs::write(&log, text).unwrap();
    let refused = |machine: &str| {
        let columns = ["--time", "time_s", "--position", "position_deg", "--effort", "effort"];
        let command = [&["identify", &log, "--machine", machine], &columns[..]].concat();
        let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(command).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = refused("step-response");
    assert!(said.contains("degrees and volts") && said.contains("stiction new"), "{said}");
    let said = refused(&file);
    assert!(said.contains("the unit of `effort` is unknown"), "{said}");
    assert!(said.contains("1.811 for a volt") && said.contains("4.545 for an ampere"), "{said}");
    let line = ["--position-unit", "mm", "--effort-gain", "2"];
    let columns = ["--time", "time_s", "--position", "position_deg", "--effort", "effort"];
    let command = [&["identify", &log, "--machine", &file], &columns[..], &line].concat();
    let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(command).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("along a line"), "{said}");
}
