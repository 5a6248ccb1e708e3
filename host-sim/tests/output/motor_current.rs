//! What a run prints of its motor's current and its supply.

use std::collections::BTreeSet;
use std::fs;

use serde_json::json;

use super::{keys, run, runs, stiction};

/// Current at either end of the sensor's range, A, and resistance of the winding, ohm.
const FULL_SCALE_A: f64 = 30.0;
const OHM: f64 = 2.51;

/// Largest error of a reading, A: half a millivolt of rounding and a step of the converter's 4095,
/// of 1650 mV for the full scale.
const READING_A: f64 = FULL_SCALE_A * (0.5 / 1650.0 + 2.0 / 4095.0);

/// Writes the file of a joint with a sensor of its current, under PD.
fn joint(directory: &std::path::Path) -> String {
    let file = directory.join("joint.toml").to_str().unwrap().to_owned();
    stiction(&["new", &file, "--typical", "harmonic"]);
    file
}

const CURRENT: [&str; 10] = [
    "--set",
    "current_sensor.full_scale_a=30",
    "--set",
    "loop.effort=current",
    "--set",
    "drive.pwm_hz=21000",
    "--set",
    "motor.inductance_h=0.001255",
    "--set",
    "run.duration_s=1",
];

#[test]
fn a_run_with_a_current_loop_prints_the_current_that_its_effort_causes_in_a_motor_at_rest() {
    let directory = tempfile::tempdir().unwrap();
    let file = joint(directory.path());
    let csv = directory.path().join("run.csv");
    let csv = csv.to_str().unwrap();
    for target in ["host", "servo"] {
        let options = ["run", &file, "--controller", "pd", "--target", target, "--csv", csv];
        stiction(&[&options[..], &CURRENT].concat());
        let text = fs::read_to_string(csv).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let place = |name: &str| names.iter().position(|found| *found == name).unwrap();
        assert_eq!(names.iter().filter(|name| **name == "current_a").count(), 1, "{target}");
        let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        let cell = |row: &[&str], name: &str| row[place(name)].parse::<f64>().unwrap();
        // A joint that PD leaves beside its target: its effort is constant, and so is the current.
        let last = rows.last().unwrap();
        assert_eq!(last[place("stuck")], "true", "{target}");
        let (effort, current) = (cell(last, "v_applied_v"), cell(last, "current_a"));
        assert!(effort.abs() > 10.0 * OHM * READING_A, "{target}: {effort} V is no current");
        assert!((current - effort / OHM).abs() < READING_A, "{target}: {current} A, {effort} V");
        assert_eq!(cell(&rows[0], "current_a").abs(), 0.0, "{target}: the motor was off before");
    }
    stiction(&["run", &file, "--controller", "pd", "--csv", csv]);
    assert!(!fs::read_to_string(csv).unwrap().contains("current_a"), "a voltage has no sensor");
}

#[test]
fn a_figure_has_the_motors_current_if_it_is_measured() {
    let directory = tempfile::tempdir().unwrap();
    let file = joint(directory.path());
    let shows = |set: &[&str]| {
        let figures = tempfile::tempdir().unwrap();
        let plot = figures.path().to_str().unwrap();
        stiction(&[&["run", &file, "--controller", "pd", "--plot", plot], set].concat());
        let svg = fs::read_dir(figures.path()).unwrap().find_map(|found| {
            let path = found.unwrap().path();
            (path.extension()? == "svg").then(|| fs::read_to_string(path).unwrap())
        });
        svg.unwrap().contains("motor current (A)")
    };
    assert!(shows(&CURRENT));
    assert!(!shows(&["--set", "run.duration_s=1"]));
}

#[test]
fn json_names_a_supply_that_differs_from_the_nominal_one() {
    let directory = tempfile::tempdir().unwrap();
    let file = joint(directory.path());
    let of = |options: &[&str]| {
        let options = [&[&*file, "--controller", "pd"], options, &CURRENT].concat();
        let report = run(&options);
        let found = runs(&report)[0].clone();
        (keys(&found).into_iter().map(str::to_owned).collect::<BTreeSet<_>>(), found)
    };
    let (nominal, _) = of(&[]);
    assert!(!nominal.contains("supply"));
    let (_, found) = of(&["--supply", "0.8"]);
    assert_eq!(found["supply"], json!({ "ratio": 0.8, "sag": null }));
    let (_, found) = of(&["--sag", "0.7,0.5,0.1"]);
    let sag = json!({ "ratio": 0.7, "from_s": 0.5, "duration_s": 0.1 });
    assert_eq!(found["supply"], json!({ "ratio": 1.0, "sag": sag }));
}
