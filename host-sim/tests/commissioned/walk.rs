//! One joint from `stiction new` to `stiction device selftest`: a 12 V gearmotor with 0.6 deg of
//! backlash behind an encoder on the motor. The simulated device has another joint than the file
//! (`--truth`). Every command that judges says the same of both sides of the gear: the goal is met
//! at the encoder and missed at the load, since no law corrects what its encoder cannot see.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use super::gearmotor::{SLACK, new};

fn stiction(desk: &TempDir, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(arguments).current_dir(desk.path()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the JSON of a command and its exit code.
fn json(desk: &TempDir, arguments: &[&str]) -> (Value, i32) {
    let output = stiction(desk, arguments);
    let found = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{arguments:?}: {}", text(&output.stderr)));
    (found, output.status.code().unwrap())
}

/// Returns the whole text of a command with one blank between two words.
fn said(desk: &TempDir, arguments: &[&str]) -> String {
    let output = stiction(desk, arguments);
    let all = text(&output.stdout) + &text(&output.stderr);
    all.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn device<'a>(machine: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    [&["device", "--simulated", "--machine", machine, "--truth", "truth.toml"][..], rest].concat()
}

/// Asserts what every judge has to say of this joint: the load lies on a flank of the gear, half of
/// its backlash off and not more than all of it with the wind-up.
fn met_at_the_encoder_alone(what: &str, found: &Value) {
    assert_eq!(found["success_at_encoder"], true, "{what}: {found}");
    assert_eq!(found["success_at_load"], false, "{what}: {found}");
    let rest = |key: &str| found[key].as_f64().unwrap().abs();
    assert!(rest("rest_at_encoder_counts") <= 2.0, "{what}: {found}");
    assert!((80.0..130.0).contains(&rest("rest_at_load_counts")), "{what}: {found}");
}

#[test]
fn a_gearmotor_is_judged_alike_from_its_first_file_to_its_self_test() {
    let desk = tempfile::tempdir().unwrap();
    let believed = ["--stick-nm", "0.3..0.4", "--slip-nm", "0.22"];
    new(desk.path(), "gearmotor.toml", &believed);
    new(desk.path(), "truth.toml", &["--stick-nm", "0.38", "--slip-nm", "0.25"]);

    // Simulated from the file alone.
    let run = ["run", "gearmotor.toml", "--controller", "robust"];
    let (simulated, _) = json(&desk, &[&run[..], &["--json"]].concat());
    for run in simulated["runs"].as_array().unwrap() {
        met_at_the_encoder_alone("run", &run["metrics"]);
    }
    assert_eq!(said(&desk, &run).matches(SLACK).count(), 1);
    let benchmark = ["benchmark", "gearmotor.toml"];
    let (ranked, _) = json(&desk, &[&benchmark[..], &["--json"]].concat());
    let scores = ranked["controllers"].as_array().unwrap();
    let robust = scores.iter().find(|score| score["controller"] == "robust").unwrap();
    met_at_the_encoder_alone("benchmark", robust);
    assert_eq!(said(&desk, &benchmark).matches(SLACK).count(), 1);
    let ensemble =
        ["ensemble", "--plant", "gearmotor.toml", "--cases", "6", "--controller", "robust"];
    let (drawn, _) = json(&desk, &[&ensemble[..], &["--json"]].concat());
    let of_all = &drawn["families"]["gearmotor"]["robust"];
    assert_eq!(of_all["success_at_encoder"], 1.0, "{drawn}");
    assert_eq!(of_all["success_at_load"], 0.0, "{drawn}");
    assert_eq!(said(&desk, &ensemble).matches(SLACK).count(), 1);

    // The device has another joint. It moves as the simulation says.
    let (moved, code) = json(&desk, &device("gearmotor.toml", &["move", "5", "--json"]));
    met_at_the_encoder_alone("move", &moved);
    assert_eq!((code, &moved["fault"]), (0, &Value::Null));

    // The joint of the device is found, and what was not measured stays.
    let identify = device("gearmotor.toml", &["identify", "--into", "found.toml", "--json"]);
    let (identified, code) = json(&desk, &identify);
    assert_eq!(code, 0, "{identified}");
    let found: toml::Table = read(desk.path(), "found.toml").parse().unwrap();
    assert_eq!(found["gear"]["backlash_deg"].as_float(), Some(0.6));
    assert_eq!(found["gear"]["stiffness_nm_per_rad"].as_float(), Some(200.0));
    for (key, range) in found["spread"].as_table().unwrap() {
        let (table, name) = key.split_once('.').unwrap();
        let nominal = found[table][name].as_float().unwrap();
        let [low, high] = [0, 1].map(|end| range[end].as_float().unwrap());
        assert!((low..=high).contains(&nominal), "{key}: {nominal} in [{low}, {high}]");
    }

    // Its page has both sides of each law, and of the moves of the self-test.
    let reported = stiction(&desk, &["report", "found.toml", "--out", "report"]);
    assert!(reported.status.success(), "{}", text(&reported.stderr));
    let page = read(&desk.path().join("report"), "found.html");
    assert_eq!(page.matches(SLACK).count(), 1);
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "misses the goal in 0 at the encoder and in 20 at the load",
        "a success is to be within 2 counts after at most 5 s until the end, and to trip no monitor",
    ] {
        assert!(page.contains(words), "{words}");
    }

    // No gains rest the load: the tuning says so instead of a success, and writes nothing.
    let tune = ["tune", "found.toml", "--controller", "robust", "--cases", "6"];
    let (tuned, code) = json(&desk, &[&tune[..], &["--json"]].concat());
    assert_eq!((tuned["outcome"].as_str(), code), (Some("refused"), 1), "{tuned}");
    assert!(tuned["reason"].as_str().unwrap().contains(SLACK), "{tuned}");
    assert_eq!(tuned["unseen_slack"]["backlash_deg"], 0.6, "{tuned}");
    assert_eq!(tuned["goal"]["tolerance_counts"], 2.0, "{tuned}");
    let before = &tuned["controllers"]["robust"]["before"];
    assert_eq!(before["success_at_load"], 0.0, "{tuned}");
    assert!(before["success_at_encoder"].as_f64().unwrap() > 0.9, "{tuned}");
    assert!(!desk.path().join("found.tuned.toml").exists());

    // The found joint is the device's: the self-test passes, and says what the encoder cannot see.
    let selftest = device("found.toml", &["selftest"]);
    let (passed, code) = json(&desk, &[&selftest[..], &["--json"]].concat());
    assert_eq!((passed["verdict"].as_str(), code), (Some("pass"), 0), "{passed}");
    for made in passed["moves"].as_array().unwrap() {
        assert_eq!(made["success_at_encoder"], true, "{made}");
    }
    let at_load = passed["moves"].as_array().unwrap().iter();
    let missed = at_load.filter(|made| made["success_at_load"] == false).count();
    assert!(2 * missed > passed["moves"].as_array().unwrap().len(), "{passed}");
    assert_eq!(said(&desk, &selftest).matches(SLACK).count(), 1);

    // With a goal that is wider than the slack, all agree again, on success. A move is watched
    // for the whole hold time.
    let wide = read(desk.path(), "found.toml") + "\n[goal]\ntolerance_deg = 1.0\nhold_s = 3.0\n";
    std::fs::write(desk.path().join("wide.toml"), wide).unwrap();
    let (moved, _) = json(&desk, &device("wide.toml", &["move", "5", "--json"]));
    let (simulated, _) = json(&desk, &["run", "wide.toml", "--controller", "robust", "--json"]);
    let (tested, code) = json(&desk, &device("wide.toml", &["selftest", "--moves", "4", "--json"]));
    assert_eq!((tested["verdict"].as_str(), code), (Some("pass"), 0), "{tested}");
    assert_eq!(tested["success_at_load"], true, "{tested}");
    // The trajectory's run ends less than the hold time after its set point.
    let steps = simulated["runs"].as_array().unwrap().iter();
    let steps = steps.filter(|run| run["label"].as_str().unwrap().contains("step"));
    for judged in steps.map(|run| &run["metrics"]).chain([&moved]) {
        assert_eq!(judged["success_at_encoder"], true, "{judged}");
        assert_eq!(judged["success_at_load"], true, "{judged}");
    }
}

/// The file of another joint: the self-test is the command that has to find out.
#[test]
fn a_self_test_fails_on_a_gearmotor_that_sticks_twice_as_much_as_its_file_says() {
    let desk = tempfile::tempdir().unwrap();
    new(desk.path(), "gearmotor.toml", &["--stick-nm", "0.35", "--slip-nm", "0.22"]);
    new(desk.path(), "truth.toml", &["--stick-nm", "0.7", "--slip-nm", "0.55"]);
    let selftest = device("gearmotor.toml", &["selftest", "--json"]);
    let (failed, code) = json(&desk, &selftest);
    assert_eq!((failed["verdict"].as_str(), code), (Some("fail"), 2), "{failed}");
}

fn read(directory: &Path, name: &str) -> String {
    std::fs::read_to_string(directory.join(name)).unwrap()
}
