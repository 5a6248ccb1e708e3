//! `stiction device identify --into`: the joint that was found, with its error bars, as a file that
//! other commands take; and its table in SI units. The joint is simulated, so that its truth is
//! known.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use super::{number, stiction};

fn device(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(["device", "--simulated"]).args(arguments).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn path(directory: &Path, name: &str) -> String {
    directory.join(name).to_str().unwrap().to_owned()
}

/// The thesis's joint: 27 deg/s^2 per V, 0.02 V s/deg, 0.40 V to start it and 0.38 V to keep it
/// moving.
const TRUTH: [(&str, f64, f64); 4] = [
    ("joint.gain_deg_per_s2_per_v", 27.0, 0.05),
    ("joint.viscous_v_per_deg_per_s", 0.02, 0.10),
    ("joint.friction.slip_v", 0.38, 0.03),
    ("joint.friction.stick_v", 0.40, 0.03),
];

#[test]
fn the_joint_that_was_found_is_a_file_whose_spread_holds_the_truth() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "found.toml");
    let found = device(&["identify", "--into", &file]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    assert!(words(&found.stdout).contains("found.toml: written, with the joint that was found"));
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# SIMULATED DEVICE"), "{text}");
    let written: toml::Table = text.parse().unwrap();
    for (key, truth, share) in TRUTH {
        let table = toml::Value::Table(written.clone());
        let value = key.split('.').try_fold(&table, |at, part| at.get(part));
        let value = value.and_then(toml::Value::as_float).unwrap();
        assert!((value / truth - 1.0).abs() < share, "{key}: {value}, and {truth}");
        let range: Vec<f64> = written["spread"][key]
            .as_array()
            .unwrap()
            .iter()
            .map(|end| end.as_float().unwrap())
            .collect();
        assert!(range[0] <= truth && truth <= range[1], "{key}: {range:?}, and {truth}");
        assert!(range[0] <= value && value <= range[1], "{key}: {range:?}, and {value}");
        assert!(range[1] - range[0] < 0.3 * truth, "{key}: {range:?} says nothing");
    }
    // Other commands take the joint, and its error bars.
    stiction(&["run", &file]);
    let out = path(directory.path(), "tuned.toml");
    let tuned = stiction(&["tune", &file, "--cases", "2", "--out", &out]);
    let [low, high] = [0, 1].map(|end| written["spread"]["joint.friction.slip_v"][end].as_float());
    let drawn = format!("joint.friction.slip_v={:?}..{:?}", low.unwrap(), high.unwrap());
    assert!(tuned.contains(&drawn), "{tuned}");
    // Nothing is written over, and nothing moves for that.
    let again = device(&["identify", "--into", &file]);
    assert_eq!((again.status.code(), words(&again.stdout)), (Some(2), String::new()));
    assert!(words(&again.stderr).contains("--overwrite"), "{}", words(&again.stderr));
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
}

#[test]
fn a_sequence_that_is_not_whole_writes_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "found.toml");
    let ended = device(&["identify", "--time", "20", "--into", &file]);
    assert_eq!(ended.status.code(), Some(2));
    let said = words(&ended.stderr);
    assert!(said.contains("nothing is written") && said.contains("--time"), "{said}");
    assert!(said.contains("the motor is off") && !Path::new(&file).exists(), "{said}");
    // Twenty seconds of motion have found something, and that is told.
    assert!(words(&ended.stdout).contains("verdict    not whole"), "{}", words(&ended.stdout));
}

/// A gear whose friction varies by 10 % to either side with the angle, of a data sheet.
#[test]
fn the_file_of_a_doubtful_joint_says_what_is_doubted_and_is_wider_than_its_error_bars() {
    let directory = tempfile::tempdir().unwrap();
    let [sheet, file] = ["joint.toml", "found.toml"].map(|name| path(directory.path(), name));
    stiction(&["new", &sheet, "--typical", "thesis"]);
    let text = fs::read_to_string(&sheet).unwrap();
    let ripple = "[friction]\nripple = 0.1\nripple_per_turn = 9\n";
    fs::write(&sheet, text.replace("[friction]\n", ripple)).unwrap();
    let found = device(&["--machine", &sheet, "identify", "--into", &file]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    let text = fs::read_to_string(&file).unwrap();
    let (_, table) = text.split_once("# Verdict of the identification").unwrap();
    let (comment, _) = table.split_once("[spread]").unwrap();
    let joined = comment.replace("\n#", " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(joined.starts_with(": doubtful."), "{table}");
    assert!(joined.contains("differs by more than 15 % from place to place"), "{table}");
    assert!(comment.lines().all(|line| line.chars().count() <= 80), "{table}");
    let written: toml::Table = text.parse().unwrap();
    let end = |end: usize| written["spread"]["joint.friction.slip_v"][end].as_float().unwrap();
    // The levels of the joint are 10 % off either way; the bars of a good fit are some percent.
    assert!(end(1) / end(0) > 1.1, "{table}");
}

/// The joint of a data sheet by hand: `J = J_load + n^2 J_rotor`, and a winding that brakes by its
/// back-EMF: `B = b + (n K_t)^2 / R`. Its gear loses nothing.
#[test]
fn the_table_in_si_units_is_the_data_sheet_s() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "joint.toml");
    stiction(&["new", &file, "--typical", "harmonic"]);
    let sheet: toml::Table = fs::read_to_string(&file).unwrap().parse().unwrap();
    let of = |table: &str, key: &str| {
        let value = &sheet[table][key];
        value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
    };
    assert_eq!(of("gear", "efficiency"), 1.0);
    let ratio = of("gear", "ratio");
    let inertia = of("load", "inertia_kg_m2") + ratio.powi(2) * of("motor", "rotor_inertia_kg_m2");
    let braked = (ratio * of("motor", "kt_nm_per_a")).powi(2) / of("motor", "resistance_ohm");
    let viscous = of("friction", "viscous_nm_s_per_rad") + braked;
    // Twice its breakaway effort: four times would be too fast for the profile of such gains.
    let found = device(&["--machine", &file, "identify", "--effort", "5", "--json"]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    let found: Value = serde_json::from_slice(&found.stdout).unwrap();
    for (name, unit, truth, share) in [
        ("inertia", "kg m^2", inertia, 0.05),
        ("viscous", "N m s/rad", viscous, 0.10),
        ("slip", "N m", of("friction", "slip_nm"), 0.03),
    ] {
        let row = &found["si"][name];
        let value = number(&row["value"]);
        assert_eq!(row["unit"], unit);
        assert!((value / truth - 1.0).abs() < share, "{name}: {value}, and {truth} {unit}");
        // Both columns are the same number in two units: so is their relative deviation.
        let core = if name == "slip" { "coulomb" } else { name };
        let core = &found["parameters"][core];
        let relative = |of: &Value| number(&of["sd"]) / number(&of["value"]);
        assert!((relative(row) / relative(core) - 1.0).abs() < 1e-6, "{name}: {found}");
    }
}
