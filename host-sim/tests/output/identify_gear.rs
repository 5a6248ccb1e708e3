//! `stiction identify` on logs with an encoder on either side of a gear.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{number, stiction};

/// Stiffness and slack of the simulated gear.
const STIFFNESS: f64 = 1500.0;
const SLACK_DEG: f64 = 0.3;

/// Counts in a turn of the joint: 4 x 500 x 50 of the motor's encoder, and the load's.
const OF_MOTOR: f64 = 100_000.0;
const OF_LOAD: &str = "65536";

/// Slow reversals first, then fast moves.
const MOTION: &str = "reference.trajectories=[{corner_times_s=[0.5, 1.5, 2.5, 3.5, 4.5, 5, 5.5, \
                      6, 6.5, 7], corner_positions_deg=[0, 4, -4, 4, 0, 20, -10, 20, -10, 0], \
                      half_blend_s=0.05}]";

const COLUMNS: [&str; 12] = [
    "--time",
    "time_s",
    "--position",
    "counts",
    "--position-unit",
    "count",
    "--counts-per-turn",
    OF_LOAD,
    "--motor-position",
    "motor_counts",
    "--effort",
    "v_applied_v",
];

fn path(directory: &Path, name: &str) -> String {
    directory.join(name).to_str().unwrap().to_owned()
}

/// A joint with two encoders, and the log of its motion.
fn joint(directory: &Path) -> (String, String) {
    joint_with(directory, [STIFFNESS, SLACK_DEG])
}

/// The same behind a gear with this stiffness, N m/rad, and slack, deg.
fn joint_with(directory: &Path, gear: [f64; 2]) -> (String, String) {
    let [file, log] = ["joint.toml", "log.csv"].map(|name| path(directory, name));
    let gear = gear.map(|value| value.to_string());
    let gear = ["--at", "motor", "--stiffness", &gear[0], "--backlash", &gear[1]];
    let new = ["new", &file, "--typical", "harmonic", "--counts-per-turn", OF_LOAD];
    stiction(&[&new[..], &gear[..]].concat());
    let run = ["run", &file, "--controller", "pd", "--csv", &log, "--set", MOTION];
    stiction(&[&run[..], &["--set", "reference.steps_deg=[]"]].concat());
    (file, log)
}

/// The result, and what is said beside it.
fn identify(log: &str, options: &[&str]) -> (Value, String) {
    identify_by(log, &COLUMNS, options)
}

fn identify_by(log: &str, columns: &[&str], options: &[&str]) -> (Value, String) {
    let arguments = [&["identify", log, "--json"], columns, options].concat();
    let done = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{said}");
    (serde_json::from_slice(&done.stdout).unwrap(), said)
}

#[test]
fn the_gear_of_a_simulated_joint_comes_back_from_the_log_of_both_encoders() {
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = joint(directory.path());
    let (found, said) = identify(&log, &["--machine", &file]);
    assert_eq!(said, "");
    let gear = &found["gear"];
    let slack = SLACK_DEG.to_radians();
    // Of the joint's 0.437 kg m^2 the rotor has 50^2 x 1.348e-4, and of its 4.1 N m the motor's
    // side has 0.7.
    for (name, truth, part) in [
        ("ratio", OF_MOTOR, 1e-3),
        ("stiffness", STIFFNESS, 0.02),
        ("slack", slack, 0.02),
        ("motor_inertia", 0.337, 0.02),
        ("motor_coulomb", 0.7 * 4.1, 0.02),
    ] {
        let [value, sd] = ["value", "sd"].map(|key| number(&gear[name][key]));
        assert!((value / truth - 1.0).abs() < part, "{name}: {value}, not {truth}");
        assert!((value - truth).abs() < 3.0 * sd && sd < part * truth, "{name}: +- {sd}");
    }
    assert_eq!((&gear["doubts"], &found["gear_refused"]), (&Value::Array(vec![]), &Value::Null));
    // The joint as a rigid body; without the motor's column it leaves 12 % of the effort.
    // Viscous friction 1.3 and the back-EMF's (50 x 0.0909)^2 / 2.51.
    for (name, truth) in [("inertia", 0.437), ("viscous", 9.5299), ("coulomb", 4.10)] {
        let value = number(&found["parameters"][name]["value"]);
        assert!((value / truth - 1.0).abs() < 0.02, "{name}: {value}, not {truth}");
    }
    assert!(number(&found["relative_residual_percent"]) < 1.0, "{found:#}");
    let text = stiction(&[&["identify", &log, "--machine", &file], &COLUMNS[..]].concat());
    assert!(text.contains("gear, all at the joint") && text.contains("N m/rad"), "{text}");
}

#[test]
fn a_wrong_gear_of_a_file_is_named_and_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = joint(directory.path());
    let text = fs::read_to_string(&file).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}: {text}");
        let file = path(directory.path(), "changed.toml");
        fs::write(&file, text.replacen(from, to, 1)).unwrap();
        file
    };
    let wrong = changed("ratio = 50.0", "ratio = 52.0");
    let (_, said) = identify(&log, &["--machine", &wrong]);
    assert!(said.contains("the ratio is wrong: encoder.lines and gear.ratio"), "{said}");
    let (_, said) = identify(&log, &["--machine", &wrong, "--motor-position-unit", "rad"]);
    assert!(said.contains("the ratio is wrong: gear.ratio"), "{said}");
    // The motor's wires are swapped.
    let rows = fs::read_to_string(&log).unwrap();
    let mut lines = rows.lines();
    let header = lines.next().unwrap();
    let place = header.split(',').position(|name| name == "motor_counts").unwrap();
    let turned = lines.map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[place] = format!("{}", -cells[place].parse::<i64>().unwrap());
        cells.join(",")
    });
    let turned: Vec<String> = std::iter::once(header.to_owned()).chain(turned).collect();
    let swapped = path(directory.path(), "swapped.csv");
    fs::write(&swapped, turned.join("\n")).unwrap();
    let (found, said) = identify(&swapped, &["--machine", &file]);
    assert!(said.contains("the direction is wrong"), "{said}");
    assert!((number(&found["gear"]["slack"]["value"]).to_degrees() / SLACK_DEG - 1.0).abs() < 0.02);
    // Stiffness and slack are replaced.
    let soft = changed("stiffness_nm_per_rad = 1500.0", "stiffness_nm_per_rad = 4000.0");
    let into = path(directory.path(), "new.toml");
    let (found, _) = identify(&log, &["--machine", &soft, "--into", &into]);
    let contradicted = found["contradicted"].as_array().unwrap();
    let stiffness = contradicted.iter().find(|one| one["key"] == "gear.stiffness_nm_per_rad");
    assert_eq!(stiffness.unwrap()["in_file"], 4000.0, "{contradicted:?}");
    assert!(contradicted.iter().all(|one| one["key"] != "gear.backlash_deg"), "{contradicted:?}");
    let new: toml::Table = fs::read_to_string(&into).unwrap().parse().unwrap();
    let of = |key: &str| new["gear"][key].as_float().unwrap();
    assert!((of("stiffness_nm_per_rad") / STIFFNESS - 1.0).abs() < 0.02, "{new}");
    assert!((of("backlash_deg") / SLACK_DEG - 1.0).abs() < 0.02, "{new}");
    // A file that knows of no gear gets it.
    let rigid = path(directory.path(), "rigid.toml");
    let without = ["stiffness_nm_per_rad =", "backlash_deg =", "damping_nm_s_per_rad ="];
    let kept = |line: &&str| !without.iter().any(|key| line.starts_with(key));
    let lines: Vec<&str> = text.lines().filter(kept).collect();
    fs::write(&rigid, lines.join("\n").replace("at = \"motor\"", "at = \"load\"")).unwrap();
    let loads = fs::read_to_string(&rigid).unwrap();
    let (before, behind) = loads.split_once("[load_encoder]").unwrap();
    let behind = behind.split_once("\n[").unwrap().1;
    fs::write(&rigid, format!("{before}[{behind}")).unwrap();
    let (found, said) = identify(&log, &["--machine", &rigid, "--into", &into, "--force"]);
    let contradicted = found["contradicted"].as_array().unwrap();
    let slack = contradicted.iter().find(|one| one["key"] == "gear.backlash_deg");
    assert_eq!(slack.unwrap()["in_file"], 0.0, "{contradicted:?}, {said}");
    let new: toml::Table = fs::read_to_string(&into).unwrap().parse().unwrap();
    assert!(
        (new["gear"]["stiffness_nm_per_rad"].as_float().unwrap() / STIFFNESS - 1.0).abs() < 0.02
    );
    let run = Command::new(env!("CARGO_BIN_EXE_stiction")).args(["run", &into]).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

#[test]
fn a_gear_that_does_not_show_is_refused_and_the_joint_is_still_identified() {
    let directory = tempfile::tempdir().unwrap();
    let (_, log) = joint(directory.path());
    // The motor's column is the load's.
    let mut columns = COLUMNS;
    columns[9] = "position_deg";
    let rigid = identify_by(&log, &columns, &[]).0;
    assert_eq!(rigid["gear"], Value::Null);
    let why = rigid["gear_refused"].as_str().unwrap();
    assert!(why.contains("stiffer than they can show"), "{why}");
    assert!(number(&rigid["parameters"]["inertia"]["value"]) > 0.0);
}

/// The load swings farther than the motor, so the slope of the positions is not the ratio: a fit
/// that takes it for the ratio finds 1.2 % less viscous friction.
#[test]
fn the_motors_viscous_friction_is_that_of_its_own_motion_behind_much_slack() {
    let directory = tempfile::tempdir().unwrap();
    let (_, log) = joint_with(directory.path(), [500.0, 0.6]);
    let (found, _) = identify(&log, &[]);
    // 0.7 of the viscous friction 1.3 and the back-EMF's (50 x 0.0909)^2 / 2.51, by 1.811 N m/V.
    let truth = 9.1399 / 1.8108;
    let [value, sd] = ["value", "sd"].map(|key| number(&found["gear"]["motor_viscous"][key]));
    assert!((value - truth).abs() < 3.0 * sd && sd < 0.003 * truth, "{value} +- {sd}, not {truth}");
}

/// Runs `device identify` on a simulated device with two encoders behind a gear. Returns the
/// result, and the path of the machine's file.
fn on_a_device(directory: &Path, gear: [f64; 2], options: &[&str]) -> (Value, String) {
    let file = path(directory, "device.toml");
    let [stiffness, backlash] = gear.map(|value| value.to_string());
    let new = ["new", &file, "--typical", "harmonic", "--counts-per-turn", "16384", "--force"];
    stiction(&[&new[..], &["--stiffness", &stiffness, "--backlash", &backlash]].concat());
    let device = ["device", "--simulated", "--machine", &file];
    let arguments = [&device[..], options, &["identify", "--json"]].concat();
    let done = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    (serde_json::from_slice(&done.stdout).unwrap(), file)
}

/// Behind the softer gears, the sequence of the device ends at its speed limit: the gear is
/// measured all the same.
#[test]
fn a_device_with_two_encoders_measures_the_gear_between_them() {
    let directory = tempfile::tempdir().unwrap();
    for (truth, widest, outcome) in [
        ([1000.0, 0.3], [0.05, 0.05], "speed"),
        ([5000.0, 0.1], [0.20, 0.05], "done"),
        ([2000.0, 0.6], [0.05, 0.05], "speed"),
    ] {
        let (found, _) = on_a_device(directory.path(), truth, &[]);
        assert_eq!((&found["outcome"], &found["gear_refused"]), (&outcome.into(), &Value::Null));
        let gear = &found["gear"];
        println!("{truth:?}: {gear}");
        let values = [
            ("stiffness", &gear["si"]["stiffness"], truth[0], widest[0]),
            ("slack", &gear["slack_deg"], truth[1], widest[1]),
            ("ratio", &gear["ratio"], OF_MOTOR, 1e-3),
        ];
        for (name, value, truth, widest) in values {
            let [value, sd] = ["value", "sd"].map(|key| number(&value[key]));
            // The counts of the load make a stiff gear soft, and so its slack small.
            let most = if name == "slack" { 2.0 } else { 3.0 };
            assert!((value - truth).abs() < most * sd, "{name}: {value} +- {sd}, not {truth}");
            assert!(sd < widest * truth, "{name}: {value} +- {sd}, not {truth}");
        }
        assert_eq!(gear["doubts"], Value::Array(vec![]), "{gear:#}");
        assert_eq!(number(&gear["lost_samples"]), 0.0);
        // 4.1 N m are 2.264 V, so 1 V is 1.811 N m.
        let [volts, torque] = [gear, &gear["si"]].map(|of| number(&of["stiffness"]["value"]));
        assert!((torque / volts / 1f64.to_degrees() / 1.811 - 1.0).abs() < 1e-3, "{gear:#}");
    }
}

/// The new file has the measured gear, and the same parameters of the device but for its twists.
#[test]
fn the_file_of_an_identified_device_has_its_measured_gear() {
    let directory = tempfile::tempdir().unwrap();
    let into = path(directory.path(), "into.toml");
    let truth = path(directory.path(), "truth.toml");
    let of = |file: &str, stiffness: &str, backlash: &str| {
        let new = ["new", file, "--typical", "harmonic", "--counts-per-turn", "16384", "--force"];
        stiction(&[&new[..], &["--stiffness", stiffness, "--backlash", backlash]].concat());
    };
    // The file has another gear than the joint.
    let file = path(directory.path(), "file.toml");
    of(&file, "9000", "0.05");
    of(&truth, "4000", "0.15");
    let device = ["device", "--simulated", "--machine", &file, "--truth", &truth];
    let arguments = [&device[..], &["identify", "--into", &into]].concat();
    let done = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(text.contains("contradicted: gear.stiffness_nm_per_rad"), "{text}");
    assert!(text.contains("contradicted: gear.backlash_deg"), "{text}");
    let new: toml::Table = fs::read_to_string(&into).unwrap().parse().unwrap();
    for (key, truth, part) in [("stiffness_nm_per_rad", 4000.0, 0.1), ("backlash_deg", 0.15, 0.05)]
    {
        let value = new["gear"][key].as_float().unwrap();
        assert!((value / truth - 1.0).abs() < part, "{key}: {value}");
        let range = new["spread"][&format!("gear.{key}")].as_array().unwrap();
        let [low, high] = [0, 1].map(|end| range[end].as_float().unwrap());
        assert!(low < truth && truth < high, "{key}: {low} to {high}");
    }
    assert!(new.get("motor_encoder").is_none() && new.get("joint").is_none(), "{new}");
    let run = Command::new(env!("CARGO_BIN_EXE_stiction")).args(["run", &into]).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

/// Writes the file of a device with two encoders, with more tables or other values at its end.
fn device_file(directory: &Path, gear: [&str; 2], more: &[&str]) -> String {
    let file = path(directory, "device.toml");
    let new = ["new", &file, "--typical", "harmonic", "--force"];
    let gear = ["--stiffness", gear[0], "--backlash", gear[1]];
    stiction(&[&new[..], &gear[..], more].concat());
    file
}

/// Runs `device identify`. Returns its result, its exit code and its error.
fn identify_device(file: &str, options: &[&str]) -> (Value, Option<i32>, String) {
    let device = ["device", "--simulated", "--machine", file, "identify", "--json"];
    let arguments = [&device[..], options].concat();
    let done = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    (serde_json::from_slice(&done.stdout).unwrap(), done.status.code(), said)
}

/// The samples begin when the device is armed, and the set point moves after the wait.
#[test]
fn the_moves_for_the_gear_wait_for_the_driver_and_for_the_holding_brake() {
    let directory = tempfile::tempdir().unwrap();
    let file = device_file(directory.path(), ["1000", "0.3"], &["--counts-per-turn", "16384"]);
    let text = fs::read_to_string(&file).unwrap();
    let samples = |waits: &str| {
        fs::write(&file, format!("{text}\n[device]\n{waits}")).unwrap();
        let (found, ..) = identify_device(&file, &[]);
        let [slack, sd] = ["value", "sd"].map(|key| number(&found["gear"]["slack_deg"][key]));
        assert!((slack - 0.3).abs() < 3.0 * sd && sd < 0.01, "{waits}: {slack} +- {sd}");
        number(&found["gear"]["samples"])
    };
    let at_once = samples("");
    // Samples are taken in portions of 0.25 s, of 1 ms each.
    for (waits, wait_s) in
        [("wake_up_s = 1.0", 1.0), ("wake_up_s = 1.0\nbrake_open_s = 0.75", 1.75)]
    {
        let more_s = 1e-3 * (samples(waits) - at_once);
        assert!((more_s - wait_s).abs() < 0.26, "{waits}: {more_s} s");
    }
}

#[test]
fn bounds_of_the_sequence_alone_leave_out_the_moves_and_the_result_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let file = device_file(directory.path(), ["5000", "0.1"], &["--counts-per-turn", "16384"]);
    for bound in [["--effort", "10"], ["--time", "280"]] {
        let (found, ..) = identify_device(&file, &bound);
        let why = found["gear_refused"].as_str().unwrap();
        assert!(found["gear"].is_null() && why.contains("again without them"), "{bound:?}: {why}");
    }
    let (found, code, said) = identify_device(&file, &["--travel", "30"]);
    assert_eq!((code, &found["gear_refused"]), (Some(0), &Value::Null), "{said}");
}

/// A load's encoder that is finer than the motor's makes `robust` work hard, until the modelled
/// heat of the motor ends the moves.
#[test]
fn a_fault_that_ends_the_moves_keeps_the_joint_and_its_file_and_names_what_is_missing() {
    let directory = tempfile::tempdir().unwrap();
    let more = ["--counts-per-turn", "131072", "--at", "motor", "--inertia", "0.0929"];
    let friction = ["--slip", "4.207", "--stick", "5.048"];
    let more = [&more[..], &friction].concat();
    let file = device_file(directory.path(), ["5000.4", "0.1975"], &more);
    let into = path(directory.path(), "into.toml");
    let (found, code, said) = identify_device(&file, &["--into", &into]);
    let why = found["gear_refused"].as_str().unwrap();
    assert!(why.contains("fault 21") && why.contains("faults --clear"), "{why}");
    assert_eq!((&found["outcome"], code), (&"done".into(), Some(2)), "{said}");
    assert!(said.contains("the joint is identified, its gear is not"), "{said}");
    assert!(said.contains("the motor is off"), "{said}");
    assert!(found["written"].as_str().unwrap().contains("into.toml"), "{found:#}");
    let new: toml::Table = fs::read_to_string(&into).unwrap().parse().unwrap();
    let spread = new.get("spread").and_then(|spread| spread.get("gear.backlash_deg"));
    assert!(spread.is_none(), "{new}");
}

/// The gear is measured, and the user must copy it: a file without a joint is not written.
#[test]
fn no_file_is_written_with_a_gear_after_a_sequence_that_a_bound_has_ended() {
    let directory = tempfile::tempdir().unwrap();
    let file = device_file(directory.path(), ["1000", "0.3"], &["--counts-per-turn", "16384"]);
    let into = path(directory.path(), "into.toml");
    let (found, code, said) = identify_device(&file, &["--into", &into]);
    assert_eq!((&found["outcome"], code), (&"speed".into(), Some(2)));
    assert!(found["gear"].is_object() && found["written"].is_null(), "{found:#}");
    assert!(said.contains("nothing is written") && said.contains("the motor is off"), "{said}");
    assert!(said.contains("copy stiffness and slack of the gear by hand"), "{said}");
    assert!(!Path::new(&into).exists());
}
