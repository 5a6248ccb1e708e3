//! `stiction new` writes files that run at once, and whose first controllers come to rest.

use std::fs;

use serde_json::Value;

use super::{labels, number, run, runs, stiction};

const TYPICAL: [&str; 3] = ["harmonic", "gimbal", "thesis"];

fn file(directory: &tempfile::TempDir, name: &str) -> String {
    directory.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn each_typical_joint_runs_at_once_and_settles() {
    let directory = tempfile::tempdir().unwrap();
    for name in TYPICAL {
        let path = file(&directory, &format!("{name}.toml"));
        stiction(&["new", &path, "--typical", name]);
        let report = run(&[&path]);
        let of = |begin: &str| -> Vec<&Value> {
            let all = runs(&report).iter();
            all.filter(|run| run["label"].as_str().unwrap().starts_with(begin)).collect()
        };
        assert_eq!(["robust/", "srnf/", "both/", "pd/"].map(|law| of(law).len()), [3; 4]);
        let rest = |run: &Value| number(&run["metrics"]["rest_error_counts"]).abs();
        for run in of("srnf/step").into_iter().chain(of("both/step")) {
            // Six counts are what SRNF's rule leaves it: tanh(alpha e) with alpha q = 0.242 at
            // most.
            assert!(rest(run) < 6.0, "{name}, {}: {} counts", run["label"], rest(run));
            assert_eq!(run["metrics"]["hunting_peak_to_peak_deg"], Value::Null, "{name}");
            assert!(number(&run["metrics"]["overshoot_deg"]) < 0.1, "{name}, {}", run["label"]);
            assert_eq!(run["unstable"], false, "{name}");
        }
        // The law promises two counts for a joint that its model describes.
        for run in of("robust/step") {
            assert!(rest(run) <= 2.0, "{name}, {}: {} counts", run["label"], rest(run));
            assert_eq!(run["metrics"]["hunting_peak_to_peak_deg"], Value::Null, "{name}");
        }
        // PD alone stops where its spring is as strong as the friction: F_s / Kp at most.
        let stops = of("pd/step").into_iter().map(rest).fold(0.0, f64::max);
        let srnf = of("srnf/step").into_iter().map(rest).fold(0.0, f64::max);
        assert!(stops > srnf, "{name}: {stops} and {srnf} counts");
        // No monitor of a servo is in the way of the first moves.
        let watched = run(&[&path, "--target", "servo"]);
        assert!(runs(&watched).iter().all(|run| run.get("fault").is_none()), "{name}");
        stiction(&["params", &path, "--out", &file(&directory, "parameters.bin")]);
    }
}

/// The thesis's axis, whose file in the core's own units is `step-response`.
#[test]
fn the_thesis_s_data_sheet_is_the_thesis_s_axis() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "thesis.toml");
    stiction(&["new", &path, "--typical", "thesis"]);
    let tables = |report: &Value| runs(report)[0]["parameters"].clone();
    let (sheet, known) = (tables(&run(&[&path])), tables(&run(&["step-response"])));
    for key in [
        "/joint/gain_deg_per_s2_per_v",
        "/joint/viscous_v_per_deg_per_s",
        "/joint/friction/stick_v",
        "/joint/friction/slip_v",
        "/drive/full_scale_v",
        "/drive/lsb_v",
        "/loop/sample_time_s",
    ] {
        let [found, expected] = [&sheet, &known].map(|tables| number(tables.pointer(key).unwrap()));
        assert!((found / expected - 1.0).abs() < 1e-9, "{key}: {found}, {expected}");
    }
    // A disc has whole lines.
    let [found, expected] =
        [&sheet, &known].map(|tables| number(&tables["encoder"]["resolution_deg"]));
    assert!((found / expected - 1.0).abs() < 1e-5, "{found}, {expected}");
}

#[test]
fn options_answer_instead_of_a_typical_joint_or_on_top_of_it() {
    let directory = tempfile::tempdir().unwrap();
    let (own, gimbal) = (file(&directory, "own.toml"), file(&directory, "gimbal.toml"));
    stiction(
        &[
            &["new", &own, "--driven-by", "voltage", "--voltage-v", "24", "--resistance-ohm", "2"]
                [..],
            &["--kt-nm-per-a", "0.05", "--rotor-inertia-kg-m2", "1e-4", "--current-limit-a", "6"],
            &["--ratio", "100", "--efficiency", "0.8", "--inertia-kg-m2", "0.2", "--stick-nm", "5"],
            &["--slip-nm", "4", "--viscous-nm-s-per-rad", "3", "--lines", "500", "--at", "motor"],
            &["--sample-time-s", "0.001"],
        ]
        .concat(),
    );
    let report = run(&[&own, "--controller", "srnf"]);
    assert_eq!(labels(&report), ["srnf/step-1.0", "srnf/step-5.0", "srnf/trajectory-2.5"]);
    let joint = &runs(&report)[0]["parameters"]["joint"];
    // G = 100 x 0.8 x 0.05 / 2 = 2 N m/V and J = 1 kg m^2.
    assert!((number(&joint["gain_deg_per_s2_per_v"]) - 2.0_f64.to_degrees()).abs() < 1e-9);
    assert!((number(&joint["friction"]["stick_v"]) - 2.5).abs() < 1e-9);
    let comments = |path: &str| fs::read_to_string(path).unwrap();
    assert!(!comments(&own).contains("assumed; the data sheet has none"));
    stiction(&["new", &gimbal, "--typical", "gimbal", "--stick-nm", "0.1"]);
    let text = comments(&gimbal);
    assert!(text.contains("stick_nm = 0.1  ") && text.contains("assumed; the data sheet has none"));
}

/// Joints of a data sheet whose friction is known within a range, with gravity, backlash and
/// travel. Each runs, is armed, moves, and trips no monitor; nor do the joints at the ends of its
/// ranges.
#[test]
fn a_joint_within_ranges_and_with_a_load_is_armed_and_moves_without_a_fault() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "joint.toml");
    let gear = ["new", &path, "--typical", "gimbal", "--force"];
    let cases: [&[&str]; 4] = [
        &["--stick", "0.05..0.15", "--slip", "0.04..0.12"],
        &["--stick", "0.08..0.12", "--unbalance", "0.03..0.05", "--travel", "-10..20"],
        &["--backlash", "0.2..0.6", "--unbalance", "0.05"],
        &["--stick", "0,1", "--unbalance", "0.15", "--hangs-at", "0"],
    ];
    for options in cases {
        // A load that moves the joint while the motor is off is a warning.
        let mut new = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"));
        assert!(new.args(gear).args(options).output().unwrap().status.success(), "{options:?}");
        let written: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        let spread = written.get("spread").and_then(toml::Value::as_table).cloned();
        let is_range = options.iter().any(|option| option.contains(".."));
        assert_eq!(spread.is_some(), is_range, "{options:?}");
        let mut joints = vec![String::new()];
        for end in [0, 1] {
            let ends = spread.iter().flatten();
            joints.push(ends.map(|(key, range)| format!("{key}={} ", range[end])).collect());
        }
        // A gear is one body or two, and a file with ranges has both ends.
        for joint in joints {
            let set: Vec<&str> = joint.split_whitespace().flat_map(|set| ["--set", set]).collect();
            let robust = ["run", "--json", &path, "--controller", "robust", "--target", "servo"];
            let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"));
            let printed = run.args(robust).args(&set).output().unwrap().stdout;
            let report: Value = serde_json::from_slice(&printed).unwrap();
            assert_eq!(runs(&report).len(), 3, "{options:?}");
            for one in runs(&report) {
                let label = &one["label"];
                assert_eq!(one.get("fault"), None, "{options:?}, {joint:?}: {label}");
                let is_calm = !joint.is_empty() || one["unstable"] == false;
                assert!(is_calm, "{options:?}: {label}");
            }
        }
        let moved = ["device", "--simulated", "--machine", &path, "move", "5", "--for", "3"];
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_stiction")).args(moved).output();
        assert!(done.as_ref().unwrap().status.success(), "{options:?}: {done:?}");
    }
}

/// A tick of a profile has 8192 counts at most, of which 20 ms of a fine encoder have more.
#[test]
fn the_profile_of_a_slow_loop_with_a_fine_encoder_is_one_that_a_device_takes() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "joint.toml");
    let fine = ["--lines", "5000", "--ratio", "100", "--at", "motor", "--sample-time-s", "0.02"];
    let light = ["--inertia-kg-m2", "1", "--viscous-nm-s-per-rad", "1"];
    let friction = ["--stick-nm", "12", "--slip-nm", "11.4"];
    let begin = ["new", &path, "--typical", "thesis"];
    stiction(&[&begin[..], &fine, &light, &friction].concat());
    let written: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
    let velocity = written["profile"]["velocity_deg_per_s"].as_float().unwrap();
    // 86 deg/s would be 9556 counts a tick, of 2,000,000 in a turn.
    let most = 8192.0 / (2e6 / 360.0) / 0.02;
    assert!(velocity <= most && velocity > 0.998 * most, "{velocity}, of {most} deg/s");
    let show = ["device", "--simulated", "--machine", &path, "params", "show"];
    let shown = std::process::Command::new(env!("CARGO_BIN_EXE_stiction")).args(show).output();
    assert!(shown.as_ref().unwrap().status.success(), "{shown:?}");
}

#[test]
fn the_two_systems_of_units_are_printed_side_by_side() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "joint.toml");
    stiction(&["new", &path, "--typical", "harmonic"]);
    let shown = stiction(&["show", "--units", &path]);
    let row = |name: &str| shown.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    // 50 x 0.0909 / 2.51 = 1.8108 N m/V; 4.9 / 1.8108 = 2.7061 V.
    assert!(row("effort per volt").contains("1.8108 N m") && row("stick").contains("2.7061 V"));
    assert!(shown.contains("G = n eta K_t / R = 50 x 1 x 0.0909 / 2.51"), "{shown}");
    assert!(shown.lines().all(|line| line.len() <= 80), "{shown}");
}

/// What a data sheet may say beyond two levels of friction, each as a user would try it.
#[test]
fn a_joint_with_more_than_two_levels_of_friction_runs_and_runs_otherwise() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "joint.toml");
    stiction(&["new", &path, "--typical", "harmonic"]);
    let moves = |set: &[&str]| {
        let set: Vec<&str> = set.iter().flat_map(|set| ["--set", *set]).collect();
        let report = run(&[&[path.as_str(), "--controller", "srnf"], &set[..]].concat());
        let one = &runs(&report)[1];
        assert_eq!(one["label"], "srnf/step-5.0");
        assert_eq!((&one["unstable"], &one["diverged_at_s"]), (&false.into(), &Value::Null));
        // It gets there: within a tenth of the step.
        assert!(number(&one["metrics"]["rest_error_counts"]).abs() < 139.0, "{set:?}");
        number(&one["metrics"]["rms_error_deg"])
    };
    let plain = moves(&[]);
    let stribeck = "friction.stribeck_rad_per_s=0.05";
    for set in [
        &["load.constant_nm=3"][..],
        &["load.unbalance_nm=4", "load.hangs_at_deg=-90"],
        &[stribeck],
        &[stribeck, "friction.bristle_stiffness_nm_per_rad=5000"],
        &["friction.ripple=0.2", "friction.ripple_per_turn=100"],
        &["friction.slip_reverse_nm=4.6", "friction.stick_reverse_nm=5.4"],
        &["gear.stiffness_nm_per_rad=10000", "gear.backlash_deg=0.02"],
        &["motor.inductance_h=0.002"],
        &["motor.dead_time_s=5e-7"],
        &["supply.internal_resistance_ohm=1"],
        &["supply.takes_current_back=false"],
        &["encoder.noise_counts=1"],
    ] {
        let found = moves(set);
        assert!(found != plain, "{set:?}: {found}");
    }
}

/// Makes a device run another controller of a new file than `robust`.
fn under(controller: &str, text: &str) -> String {
    let all = "controller = [\"robust\", \"srnf\", \"both\", \"pd\"]";
    let changed = text.replace(all, &format!("controller = [{controller:?}]"));
    assert_ne!(changed, text);
    changed
}

/// A device knows its joint in the core's units alone, and so does the file that is pulled from it.
#[test]
fn a_file_that_is_pulled_from_a_device_moves_like_the_data_sheet() {
    let directory = tempfile::tempdir().unwrap();
    let (path, pulled) = (file(&directory, "joint.toml"), file(&directory, "pulled.toml"));
    stiction(&["new", &path, "--typical", "harmonic"]);
    fs::write(&path, under("srnf", &fs::read_to_string(&path).unwrap())).unwrap();
    let pull = ["device", "--simulated", "--machine", &path, "params", "pull", &pulled];
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_stiction")).args(pull).output();
    assert!(done.unwrap().status.success());
    let first = |path: &str| {
        let report = run(&[path, "--controller", "srnf"]);
        let metrics = &runs(&report)[0]["metrics"];
        ["rest_error_counts", "rms_error_deg", "rise_time_s"].map(|name| number(&metrics[name]))
    };
    // The device has its values in single precision.
    for (found, expected) in first(&pulled).into_iter().zip(first(&path)) {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found}, {expected}");
    }
}

/// The simulated device has the joint of the data sheet: it ends elsewhere with a load.
#[test]
fn a_simulated_device_has_the_load_of_its_data_sheet() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(&directory, "joint.toml");
    stiction(&["new", &path, "--typical", "harmonic"]);
    let reached = |load: &str| {
        // `robust` and SRNF would carry the load, and end on the target all the same.
        let text = under("pd", &fs::read_to_string(&path).unwrap());
        let loaded = file(&directory, "loaded.toml");
        fs::write(&loaded, text.replace("[load]\n", &format!("[load]\nconstant_nm = {load}\n")))
            .unwrap();
        let program = env!("CARGO_BIN_EXE_stiction");
        let moved = ["device", "--simulated", "--machine", &loaded, "move", "2", "--for", "1.5"];
        let done = std::process::Command::new(program).args(moved).output().unwrap();
        let said = String::from_utf8(done.stdout).unwrap();
        assert!(done.status.success(), "{said}");
        let line = said.lines().find(|line| line.starts_with("reached")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    let (pulled, free) = (reached("-3.0"), reached("0.0"));
    // Kp's share no longer overcomes the slip friction and the load nearer than at (4.1 + 3) N m /
    // 1.8108 N m/V / 10.64 V/deg; a count is 0.0036 deg. Its own momentum carries the joint on from
    // there, but not as far as without a load.
    let balance = |load: f64| 2.0 - (4.1 + load) / 1.8108 / 10.64;
    assert!((balance(3.0) - 0.0036..balance(0.0)).contains(&pulled), "{pulled} deg");
    assert!((balance(0.0) - 0.0036..2.0).contains(&free), "{free} deg");
}
