//! `stiction identify` on logs of a simulated joint, and on foreign ones whose efforts are worked
//! out in closed form from the motion.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;

use super::{keys, number, stiction};

/// A motion in closed form: three sines, so that speeds and accelerations vary.
const SINES: [[f64; 3]; 3] = [[0.20, 1.7, 0.0], [0.08, 4.3, 1.0], [0.02, 9.1, 2.0]];

/// Position, velocity and acceleration at a time.
fn motion(t: f64) -> [f64; 3] {
    SINES.iter().fold([0.0; 3], |[q, v, a], [amplitude, w, phase]| {
        let (sine, cosine) = (w * t + phase).sin_cos();
        [q + amplitude * sine, v + amplitude * w * cosine, a - amplitude * w * w * sine]
    })
}

/// The effort that a machine needs for the motion: inertia, viscous and Coulomb friction the
/// positive and the negative way.
fn effort([_, v, a]: [f64; 3], [inertia, b_up, b_down, f_up, f_down]: [f64; 5]) -> f64 {
    let friction = if v > 0.0 { b_up * v + f_up } else { b_down * v - f_down };
    inertia * a + friction
}

/// A log of the motion: the row of each time.
fn log(name: &str, header: &str, samples: u32, row: impl Fn(u32, &mut String)) -> Log {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name).to_str().unwrap().to_owned();
    let mut text = header.to_owned();
    (0..samples).for_each(|i| row(i, &mut text));
    fs::write(&path, text).unwrap();
    Log { path, _directory: directory }
}

struct Log {
    path: String,
    _directory: tempfile::TempDir,
}

fn identified(path: &str, options: &[&str]) -> Value {
    let text = stiction(&[&["identify", path, "--json"], options].concat());
    serde_json::from_str(&text).unwrap()
}

/// Values within a part of what they should be.
fn assert_near(found: &Value, expected: &[(&str, f64)], part: f64) {
    for (name, expected) in expected {
        let value = number(&found["parameters"][name]["value"]);
        assert!((value / expected - 1.0).abs() < part, "{name}: {value}, not {expected}");
    }
}

#[test]
fn a_simulated_joint_comes_back_from_its_log_and_its_file_runs() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (joint, log, into) = (file("joint.toml"), file("log.csv"), file("identified.toml"));
    stiction(&["new", &joint, "--typical", "harmonic"]);
    let trajectory = "reference.trajectories=[{corner_times_s=[0.5, 1.5, 2, 2.3, 3, 5, 5.5, 6.1], \
                      corner_positions_deg=[0, 40, 40, 10, 10, -30, -30, 20], half_blend_s=0.1}]";
    let run = ["run", &joint, "--controller", "both", "--csv", &log, "--set", trajectory];
    stiction(&[&run[..], &["--set", "reference.steps_deg=[]"]].concat());
    let columns = ["--time", "time_s", "--position", "position_deg", "--effort", "v_applied_v"];
    // The effort gain of the joint's data sheet: 50 x 0.0909 / 2.51.
    let found = identified(&log, &[&columns[..], &["--effort-gain", "1.81076"]].concat());
    assert_eq!(found["model"], "symmetric");
    // Inertia 0.1 + 50^2 x 1.348e-4; viscous 1.3 and the back-EMF's (50 x 0.0909)^2 / 2.51.
    let truth = [("inertia", 0.437), ("viscous", 9.5299), ("coulomb", 4.10)];
    assert_near(&found, &truth, 0.005);
    // The log has the effort that was set, which is held for the sample that follows.
    assert!((number(&found["effort_delay_s"]) - 0.5e-3).abs() < 0.1e-3, "{found}");
    assert_eq!(
        (&found["verdict"]["quality"], &found["misfits"]),
        (&"good".into(), &Value::Array(vec![]))
    );
    let gain = ["--effort-gain", "1.81076", "--into", &into];
    stiction(&[&["identify", &log], &columns[..], &gain[..]].concat());
    let units = stiction(&["show", "--units", &into]);
    assert!(units.contains("0.437"), "{units}");
    stiction(&["run", &into, "--controller", "srnf"]);
    // The law and the spread get the friction with its error bars.
    let text = std::fs::read_to_string(&into).unwrap();
    let written: toml::Table = text.parse().unwrap();
    let law = |key: &str| written["controller"]["robust"][key].as_float().unwrap();
    let per_volt = 1.81076;
    let inertia = 0.437 * std::f64::consts::PI / 180.0 / per_volt;
    assert!((law("inertia_v_s2_per_deg") / inertia - 1.0).abs() < 0.01, "{text}");
    let sd = number(&found["parameters"]["coulomb"]["sd"]);
    let [low, high] = [0.5 * (4.1 - 2.0 * sd), 2.0 * (4.1 + 2.0 * sd)].map(|nm| nm / per_volt);
    assert!((law("breakaway_low_v") / low - 1.0).abs() < 0.01, "{low}: {text}");
    assert!((law("breakaway_high_v") / high - 1.0).abs() < 0.01, "{high}: {text}");
    assert!(text.contains("# half of: lowest slip - 2 sd"), "{text}");
    let ends = |key: &str| [0, 1].map(|end| written["spread"][key][end].as_float().unwrap());
    for (key, truth) in [
        ("load.inertia_kg_m2", 0.437),
        ("friction.viscous_nm_s_per_rad", 9.5299),
        ("friction.slip_nm", 4.1),
    ] {
        let [low, high] = ends(key);
        assert!(low < truth && truth < high && high < 1.2 * low, "{key}: {low} to {high}");
    }
    // A log of motion does not identify the stick friction, which is 4.9 N m.
    let [low, high] = ends("friction.stick_nm");
    assert!(low <= 4.2 && high > 4.9, "{low} to {high}");
    // Every value is within its own range.
    for key in written["spread"].as_table().unwrap().keys() {
        let (table, name) = key.split_once('.').unwrap();
        let (value, [low, high]) = (written[table][name].as_float().unwrap(), ends(key));
        assert!(low <= value && value <= high, "{key}: {value} in {low} to {high}");
    }
}

/// Friction that differs by the direction is a mean and a load, each of which is drawn by itself.
#[test]
fn the_file_of_a_log_with_more_friction_one_way_is_drawn_from_and_tuned() {
    let machine = [0.5, 0.8, 0.8, 1.6, 1.2];
    let log = log("one-way.csv", "time,q_rad,tau\n", 16_000, |i, text| {
        let t = 1e-3 * f64::from(i);
        let at = motion(t);
        let _ = writeln!(text, "{t:.3},{:.6},{:.5}", at[0], effort(at, machine));
    });
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (into, out) = (file("into.toml"), file("tuned.toml"));
    let columns = ["--time", "time", "--position", "q_rad", "--effort", "tau"];
    let gain = ["--effort-gain", "1", "--into", &into];
    stiction(&[&["identify", &log.path], &columns[..], &gain].concat());
    let text = fs::read_to_string(&into).unwrap();
    let written: toml::Table = text.parse().unwrap();
    let of = |table: &str, key: &str| written[table][key].as_float().unwrap();
    // The load pushes the easy way, which is backward.
    for (table, key, truth) in [
        ("friction", "slip_nm", 1.4),
        ("load", "constant_nm", -0.2),
        ("limits", "breakaway_v", 1.6),
    ] {
        assert!((of(table, key) / truth - 1.0).abs() < 0.05, "{key}: {text}");
    }
    let ends = |key: &str| [0, 1].map(|end| written["spread"][key][end].as_float().unwrap());
    for (key, truth) in [("friction.slip_nm", 1.4), ("load.constant_nm", -0.2)] {
        let [low, high] = ends(key);
        assert!(low <= truth && truth <= high && high - low < 0.3, "{key}: {low} to {high}");
    }
    // The law gets both directions: half of 1.2 and twice 1.6, with their error bars.
    let law = |key: &str| written["controller"]["robust"][key].as_float().unwrap();
    assert!((0.5..=0.6).contains(&law("breakaway_low_v")), "{text}");
    assert!((3.2..=3.5).contains(&law("breakaway_high_v")), "{text}");
    let tuned = stiction(&["tune", &into, "--cases", "2", "--out", &out]);
    assert!(tuned.contains("load.constant_nm=") && tuned.contains("friction.stick_nm="), "{tuned}");
}

/// A friction that drives is none, whatever load turns one of both levels round.
#[test]
fn friction_that_is_negative_in_the_mean_of_both_ways_is_not_called_good() {
    let found = |name: &str, levels: [f64; 2]| {
        let log = log(name, "time,q_rad,tau\n", 16_000, |i, text| {
            let t = 1e-3 * f64::from(i);
            let at = motion(t);
            let tau = effort(at, [0.5, 0.8, 0.8, levels[0], levels[1]]);
            let _ = writeln!(text, "{t:.3},{:.8},{tau:.6}", at[0]);
        });
        let columns = ["--time", "time", "--position", "q_rad", "--effort", "tau"];
        identified(&log.path, &[&columns[..], &["--model", "asymmetric"]].concat())
    };
    let words = "the mean of `coulomb_positive` and `coulomb_negative` is negative";
    let negative = found("negative.csv", [0.1, -0.3]);
    assert!(negative["verdict"]["words"].to_string().contains(words), "{negative}");
    assert_ne!(negative["verdict"]["quality"], "good");
    // A load of 0.4 the negative way, on friction of 0.1.
    let loaded = found("loaded.csv", [0.5, -0.3]);
    assert!(!loaded["verdict"]["words"].to_string().contains("negative,"), "{loaded}");
}

/// Milliseconds, millimetres and amperes of a linear axis, with decimal commas between semicolons,
/// columns in another order, and a row of units.
#[test]
fn a_linear_axis_in_foreign_units_comes_back_in_kilograms_and_newtons() {
    let machine = [80.0, 150.0, 190.0, 14.0, 20.0];
    let log = log("axis.csv", "Strom;Weg;Zeit\nA;mm;ms\n", 20_000, |i, text| {
        let t = 5e-4 * f64::from(i);
        let at = motion(t);
        let amperes = effort(at, machine) / 35.0;
        let line = format!("{amperes:.4};{:.4};{:.1}", 1e3 * at[0], 1e3 * t);
        let _ = writeln!(text, "{}", line.replace('.', ","));
    });
    let options = ["--time", "Zeit", "--position", "weg", "--effort", "Strom"];
    let units = ["--time-unit", "ms", "--position-unit", "mm", "--effort-gain", "35"];
    // A warning reports the omitted row of units, so the helper, which allows none, is not used.
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["identify", &log.path, "--json"])
        .args(options)
        .args(units)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("below the header"), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["model"], "asymmetric");
    let names =
        ["inertia", "viscous_positive", "viscous_negative", "coulomb_positive", "coulomb_negative"];
    let truth: Vec<(&str, f64)> = names.into_iter().zip(machine).collect();
    assert_near(&found, &truth, 0.005);
    assert_eq!(
        (&found["units"]["inertia"], &found["units"]["coulomb_positive"]),
        (&"kg".into(), &"N".into())
    );
    // Half of the difference of both ways.
    assert!((number(&found["parameters"]["offset"]["value"]) + 3.0).abs() < 0.05, "{found}");
    // What scripts rely on.
    let promised = ["model", "parameters", "relative_residual_percent", "free_run"];
    assert!(promised.iter().all(|key| keys(&found).contains(key)), "{found}");
    assert!(keys(&found["free_run"]).is_superset(&["rms", "r2"].into()));
    assert_eq!(keys(&found["parameters"]["inertia"]), ["sd", "value"].into());
}

/// Counts of an encoder against microseconds of a counter, with tabs and without a header.
#[test]
fn counts_against_a_counter_come_back_in_the_effort_s_own_unit() {
    let machine = [0.5, 0.8, 0.8, 1.5, 1.5];
    let per_count = std::f64::consts::TAU / 65536.0;
    let log = log("counts.txt", "", 10_000, |i, text| {
        let at = motion(1e-3 * f64::from(i));
        let count = (at[0] / per_count).floor();
        let _ = writeln!(text, "{}\t{:.3}\t{count}", 1000 * i, effort(at, machine));
    });
    let options = ["--time", "1", "--position", "3", "--effort", "2", "--time-unit", "us"];
    let units = ["--position-unit", "count", "--counts-per-turn", "65536"];
    let found = identified(&log.path, &[&options[..], &units[..]].concat());
    assert_near(&found, &[("inertia", 0.5)], 0.01);
    let [viscous, coulomb] = if found["model"] == "symmetric" {
        ["viscous", "coulomb"]
    } else {
        ["viscous_positive", "coulomb_positive"]
    };
    assert_near(&found, &[(viscous, 0.8), (coulomb, 1.5)], 0.03);
    assert_eq!(found["units"]["inertia"], "effort s^2/rad");
}

/// An effort that is cut in the log, and a standstill in which friction holds whatever the effort
/// is. Taken for what moves the machine, the cut effort would make it lighter.
#[test]
fn a_cut_effort_and_a_standstill_are_left_out_and_reported() {
    let machine = [0.5, 0.8, 0.8, 1.5, 1.5];
    // Where the machine turns, it can as well stand still.
    let turns = (4000..).find(|i| {
        let speed = |i: u32| motion(1e-3 * f64::from(i))[1];
        speed(*i) * speed(i + 1) <= 0.0
    });
    let turns = turns.unwrap();
    let largest = (0..12_000).map(|i| effort(motion(1e-3 * f64::from(i)), machine).abs());
    let cut = 0.75 * largest.fold(0.0, f64::max);
    let log = log("cut.csv", "time,q_rad,tau\n", 14_000, |i, text| {
        let is_still = (turns..turns + 2000).contains(&i);
        let moved = if i < turns { i } else { turns.max(i.saturating_sub(2000)) };
        let at = motion(1e-3 * f64::from(moved));
        let tau = if is_still { 0.9 * (0.01 * f64::from(i)).sin() } else { effort(at, machine) };
        let _ =
            writeln!(text, "{:.3},{:.8},{:.5}", 1e-3 * f64::from(i), at[0], tau.clamp(-cut, cut));
    });
    let columns = ["--time", "time", "--position", "q_rad", "--effort", "tau"];
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["identify", &log.path, "--json", "--model", "symmetric"])
        .args(columns)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["verdict"]["words"].to_string().contains("saturated"), "{found}");
    assert_near(&found, &[("inertia", 0.5), ("viscous", 0.8), ("coulomb", 1.5)], 0.03);
}

/// Rows without a number, a gap, jitter and rounded times are reported, and the machine is
/// identified.
#[test]
fn holes_gaps_and_uneven_times_are_handled_and_reported() {
    let machine = [0.5, 0.8, 0.8, 1.5, 1.5];
    let log = log("holes.csv", "time,q_rad,tau\n", 16_000, |i, text| {
        if (6000..6500).contains(&i) {
            return;
        }
        let t = 1e-3 * (f64::from(i) + 0.25 * (2.4 * f64::from(i)).sin());
        let at = motion(t);
        let tau = if i % 997 == 5 { "NaN".into() } else { format!("{:.5}", effort(at, machine)) };
        let _ = writeln!(text, "{t:.7},{:.8},{tau}", at[0]);
    });
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["identify", &log.path, "--json", "--time", "time", "--position", "q_rad"])
        .args(["--effort", "tau", "--model", "symmetric"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    // The header is row 1, and the sample of number 5 is row 7.
    for part in ["rows lack a number", "first is row 7", "1 gap", "uneven"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_near(&found, &[("inertia", 0.5), ("viscous", 0.8), ("coulomb", 1.5)], 0.02);
}

/// An effort that no model explains, of a frequency that the motion does not have.
#[test]
fn a_residual_above_5_percent_is_a_doubt_and_one_above_15_is_poor() {
    let machine = [0.5, 0.8, 0.8, 1.5, 1.5];
    let columns = ["--time", "time", "--position", "q_rad", "--effort", "tau"];
    for (disturbance, [low, high], is_doubt) in
        [(0.1, [2.0, 5.0], false), (0.25, [5.0, 10.0], true), (0.8, [15.0, 60.0], true)]
    {
        let log = log("disturbed.csv", "time,q_rad,tau\n", 16_000, |i, text| {
            let t = 1e-3 * f64::from(i);
            let at = motion(t);
            let tau = effort(at, machine) + disturbance * (7.7 * t).sin();
            let _ = writeln!(text, "{t:.3},{:.8},{tau:.6}", at[0]);
        });
        let found = identified(&log.path, &columns);
        let residual = number(&found["relative_residual_percent"]);
        assert!((low..high).contains(&residual), "{residual}");
        let doubts = found["verdict"]["doubts"].to_string();
        assert_eq!(doubts.contains("the residual is"), is_doubt, "{residual}: {doubts}");
        let is_poor = found["verdict"]["quality"] == "poor";
        assert_eq!(is_poor, residual > 15.0, "{residual}: {doubts}");
    }
}

/// A weight of 0.08 N m beside 9 N m of inertia and friction, over strokes of 1.5 rad.
#[test]
fn a_term_that_would_lower_the_residual_is_proposed_with_its_option() {
    let machine = [0.5, 0.8, 0.8, 1.5, 1.5];
    let log = log("weight.csv", "time,q_rad,tau\n", 16_000, |i, text| {
        let t = 1e-3 * f64::from(i);
        let at = motion(t).map(|one| 5.0 * one);
        let tau = effort(at, machine) + 0.08 * at[0].sin();
        let _ = writeln!(text, "{t:.3},{:.8},{tau:.6}", at[0]);
    });
    let columns = ["--time", "time", "--position", "q_rad", "--effort", "tau"];
    let found = identified(&log.path, &columns);
    let proposals = found["proposals"].as_array().unwrap();
    assert_eq!(proposals.len(), 1, "{found}");
    let proposal = &proposals[0];
    assert_eq!((&proposal["term"], &proposal["option"]), (&"gravity".into(), &"--gravity".into()));
    let [before, with] = ["residual_before", "residual_with"].map(|key| number(&proposal[key]));
    assert_eq!(before, number(&found["relative_residual_percent"]));
    assert!(with < before / 3.0, "{proposal}");
    assert_eq!(found["verdict"]["quality"], "fair");
    // The option does what was said, and nothing is left to propose.
    let heavy = identified(&log.path, &[&columns[..], &["--gravity"]].concat());
    assert!((number(&heavy["relative_residual_percent"]) / with - 1.0).abs() < 0.2, "{heavy}");
    assert_eq!(
        (&heavy["proposals"], &heavy["verdict"]["quality"]),
        (&Value::Array(vec![]), &"good".into())
    );
    let text = stiction(&[&["identify", &log.path], &columns[..]].concat());
    let words = "gravity would lower the residual from ";
    assert!(text.contains(words) && text.contains("add `--gravity`"), "{text}");
}
