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
    let report: Value =
        serde_json::from_str(&stiction(&[&tune[..], &["--json"]].concat())).unwrap();
    assert_eq!(fs::read_to_string(&old).unwrap(), before);
    let after = fs::read_to_string(&new).unwrap();
    assert_eq!(before.lines().count(), after.lines().count() - 3, "robust has three gains more");
    assert!(after.contains("# twice the highest"), "a comment is gone");
    let written: toml::Table = after.parse().unwrap();
    for law in ["srnf", "robust"] {
        let of = |key: &str, what: &str| number(&report["controllers"][law][key][what]);
        assert!(report["controllers"][law]["better"].as_bool().unwrap(), "{law}");
        assert!(of("after", "successes") >= of("before", "successes"), "{law}");
        assert!(of("after", "settling_s") < of("before", "settling_s"), "{law}");
        // The reported gains are the written ones.
        for (key, gain) in report["controllers"][law]["gains"].as_object().unwrap() {
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

/// The gear with 171 counts of backlash that its encoder cannot see, with a table more at its end.
/// Its stall monitor has room for friction and unbalance together.
fn gear(directory: &tempfile::TempDir, more: &str) -> String {
    let text = include_str!("../joints_under_test/gear_with_backlash.toml");
    let path = file(directory, "gear.toml");
    fs::write(&path, format!("{text}\n[limits]\nbreakaway_v = 2.5\n{more}")).unwrap();
    path
}

fn tuned(joint: &str, more: &[&str]) -> (Option<i32>, Value, String) {
    let tune = ["tune", joint, "--cases", "1", "--json"];
    let done = Command::new(env!("CARGO_BIN_EXE_stiction")).args(tune).args(more).output().unwrap();
    let printed = serde_json::from_slice(&done.stdout).unwrap();
    (done.status.code(), printed, String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn a_load_that_no_gains_can_rest_is_refused_with_the_reason_and_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let joint = gear(&directory, "");
    let (code, printed, words) = tuned(&joint, &["--controller", "robust"]);
    assert_eq!(code, Some(1), "{words}");
    assert!(!directory.path().join("gear.tuned.toml").exists());
    assert_eq!(words.matches("cannot see 171 counts of backlash").count(), 1, "{words}");
    assert!(words.contains("no file is written"), "{words}");
    let of = &printed["controllers"]["robust"];
    assert_eq!((&printed["outcome"], &of["outcome"]), (&"refused".into(), &"refused".into()));
    let reason = of["reason"].as_str().unwrap();
    assert!(reason.starts_with("no gains can rest the load within 2 counts"), "{reason}");
    assert!(reason.contains("put an encoder on the load, or set [goal] tolerance_deg"), "{reason}");
    assert!(printed["reason"].as_str().unwrap().contains(reason));
    assert_eq!(of["better"], false);
    // Both sides: the encoder's is at its target, the load never.
    let before = &of["before"];
    assert_eq!(
        (number(&before["success_at_encoder"]), number(&before["success_at_load"])),
        (1.0, 0.0)
    );
    assert_eq!(before["successes"], before["successes_at_load"]);
    assert!(number(&before["rest_at_encoder_counts"]) < 2.0);
    assert!(number(&before["rest_at_load_counts"]) > 50.0);
    assert_eq!(of["before"], of["after"]);
    assert_eq!(printed["unseen_slack"]["backlash_deg"], 0.6);
    assert_eq!(
        (number(&printed["goal"]["tolerance_counts"]), number(&printed["goal"]["settle_s"])),
        (2.0, 5.0)
    );
}

#[test]
fn the_same_joint_is_tuned_once_its_goal_is_wider_than_its_slack() {
    let directory = tempfile::tempdir().unwrap();
    let joint = gear(&directory, "\n[goal]\ntolerance_deg = 0.7\n");
    // The balanced objective may give settling away for chatter, heat and tracking.
    let (code, printed, words) = tuned(&joint, &["--controller", "robust", "--goal", "settle"]);
    assert_eq!(code, Some(0), "{words}");
    assert!(directory.path().join("gear.tuned.toml").exists());
    assert_eq!((printed["outcome"].as_str(), printed["reason"].as_str()), (Some("tuned"), None));
    let of = &printed["controllers"]["robust"];
    assert_eq!((of["better"].as_bool(), of["outcome"].as_str()), (Some(true), Some("tuned")));
    assert_eq!(number(&of["after"]["success_at_load"]), 1.0);
    for side in ["settled_at_encoder_s", "settled_at_load_s"] {
        let settled = |what: &str| number(&of[what][side]);
        assert!(settled("after") < settled("before"), "{side}: {of}");
    }
}

/// A thousandth of the gains is not enough for friction, nor sixteen thousandths.
#[test]
fn a_law_that_never_succeeds_is_refused_beside_one_that_is_tuned() {
    let directory = tempfile::tempdir().unwrap();
    let weak = "\n[goal]\ntolerance_deg = 0.7\n\n[controller.weak]\nlaws = []\n\
                kp_v_per_deg = 0.004\nkd_v_per_deg_per_s = 0.0001\n";
    let joint = gear(&directory, weak);
    let (code, printed, words) = tuned(&joint, &["--controller", "weak,robust"]);
    assert_eq!((code, printed["outcome"].as_str()), (Some(0), Some("tuned")), "{words}");
    let of = |law: &str, key: &str| printed["controllers"][law][key].clone();
    assert_eq!(
        (of("weak", "outcome"), of("robust", "outcome")),
        ("refused".into(), "tuned".into())
    );
    assert!(of("weak", "reason").as_str().unwrap().contains("counts off"), "{printed}");
    assert_eq!(of("weak", "before")["successes"], 0);
    let [old, new] = ["gear.toml", "gear.tuned.toml"].map(|name| -> toml::Table {
        fs::read_to_string(directory.path().join(name)).unwrap().parse().unwrap()
    });
    assert_eq!(old["controller"]["weak"], new["controller"]["weak"]);
    assert_ne!(old["controller"]["robust"], new["controller"]["robust"]);
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
        let report: Value = serde_json::from_str(&stiction(&whole)).unwrap();
        number(&report["controllers"]["srnf"]["after"]["chatter_v_per_s"])
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
