//! `stiction tune`: gains for a joint that is known within bounds, in a new file.

use std::fs;
use std::process::Command;

use serde_json::Value;

use super::{number, run, runs, stiction};

fn file(directory: &tempfile::TempDir, name: &str) -> String {
    directory.path().join(name).to_str().unwrap().to_owned()
}

#[test]
fn tuned_gains_are_better_on_joints_they_were_not_found_on_and_stand_in_a_new_file() {
    let directory = tempfile::tempdir().unwrap();
    let (old, new) = (file(&directory, "joint.toml"), file(&directory, "joint.tuned.toml"));
    stiction(&["new", &old, "--typical", "thesis"]);
    let before = fs::read_to_string(&old).unwrap();
    let tune = ["tune", &old, "--controller", "srnf,robust", "--goal", "settle", "--cases", "3"];
    let told: Value = serde_json::from_str(&stiction(&[&tune[..], &["--json"]].concat())).unwrap();
    assert_eq!(fs::read_to_string(&old).unwrap(), before);
    let after = fs::read_to_string(&new).unwrap();
    assert_eq!(before.lines().count(), after.lines().count() - 3, "robust has three gains more");
    assert!(after.contains("# twice the highest"), "a comment is gone");
    let written: toml::Table = after.parse().unwrap();
    for law in ["srnf", "robust"] {
        let of = |key: &str, what: &str| number(&told["controllers"][law][key][what]);
        assert!(told["controllers"][law]["better"].as_bool().unwrap(), "{law}");
        assert!(of("after", "successes") >= of("before", "successes"), "{law}");
        assert!(of("after", "settling_s") < of("before", "settling_s"), "{law}");
        // What is told is what is written.
        for (key, gain) in told["controllers"][law]["gains"].as_object().unwrap() {
            let stands = written["controller"][law][key].as_float();
            assert_eq!(stands, gain["to"].as_f64(), "{law}: {key}");
        }
    }
    // And it runs.
    assert!(!runs(&run(&[&new, "--controller", "srnf,robust"])).is_empty());
    // Nothing is written over, and the same seed finds the same.
    let again = Command::new(env!("CARGO_BIN_EXE_stiction")).args(tune).output().unwrap();
    let words = String::from_utf8_lossy(&again.stderr).into_owned();
    assert_eq!(again.status.code(), Some(2));
    assert!(words.contains("the file exists"), "{words}");
    let other = file(&directory, "other.toml");
    stiction(&[&tune[..], &["--out", &other]].concat());
    assert_eq!(fs::read_to_string(other).unwrap(), after);
}

#[test]
fn a_limit_is_kept_where_the_goal_alone_would_pass_it() {
    let directory = tempfile::tempdir().unwrap();
    let joint = file(&directory, "joint.toml");
    stiction(&["new", &joint, "--typical", "thesis"]);
    let chatter = |name: &str, more: &[&str]| {
        let out = file(&directory, name);
        let tune = ["tune", &joint, "--controller", "srnf", "--goal", "settle", "--cases", "3"];
        let whole = [&tune[..], &["--json", "--out", &out], more].concat();
        let told: Value = serde_json::from_str(&stiction(&whole)).unwrap();
        number(&told["controllers"]["srnf"]["after"]["chatter_v_per_s"])
    };
    let free = chatter("free.toml", &[]);
    let most = format!("chatter_v_per_s={}", 0.75 * free);
    let bound = chatter("bound.toml", &["--limit", &most]);
    assert!(bound < 0.9 * free, "{bound} and {free} V/s");
}

#[test]
fn a_ranking_of_tuned_laws_is_that_of_the_gains_that_tune_finds_and_the_same_again() {
    let directory = tempfile::tempdir().unwrap();
    let joint = file(&directory, "joint.toml");
    stiction(&["new", &joint, "--typical", "thesis"]);
    let before = fs::read_to_string(&joint).unwrap();
    let asked = ["benchmark", &joint, "--tuned", "--cases", "2", "--json"];
    let ranked: Value = serde_json::from_str(&stiction(&asked)).unwrap();
    assert_eq!(fs::read_to_string(&joint).unwrap(), before);
    assert_eq!(ranked, serde_json::from_str::<Value>(&stiction(&asked)).unwrap());
    // A file with these gains has the same ranking.
    let out = file(&directory, "tuned.toml");
    stiction(&["tune", &joint, "--controller", "all", "--cases", "2", "--out", &out]);
    let of_file: Value = serde_json::from_str(&stiction(&["benchmark", &out, "--json"])).unwrap();
    assert_eq!(ranked["controllers"], of_file["controllers"]);
    let plain: Value = serde_json::from_str(&stiction(&["benchmark", &joint, "--json"])).unwrap();
    assert_ne!(ranked["controllers"], plain["controllers"]);
    assert!(plain.get("tuned").is_none() && ranked["tuned"]["controllers"]["srnf"].is_object());
}
