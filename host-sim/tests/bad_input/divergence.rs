//! Allowed input may lead to a motion that is unstable, not finite or without an end.

use std::fs;

use serde_json::Value;

use super::{json, stiction};

#[test]
fn an_unstable_run_is_reported_as_such_and_no_other() {
    let report = json(&["run", "step-response", "--controller", "pd", "--json"]);
    let unstable: Vec<&str> = report["runs"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|run| run["unstable"] == true)
        .map(|run| run["label"].as_str().unwrap())
        .collect();
    assert_eq!(unstable, ["pd/step-5.0/literal-si"]);
    assert!(report["runs"].as_array().unwrap().iter().all(|run| run["diverged_at_s"].is_null()));
    let table = stiction(&["run", "step-response", "--controller", "pd"]).output().unwrap();
    let table = String::from_utf8(table.stdout).unwrap();
    let remarks: Vec<&str> = table.lines().filter(|line| line.contains(": ")).collect();
    assert_eq!(remarks, ["pd/step-5.0/literal-si: unstable"]);
}

#[test]
fn a_run_whose_state_is_no_longer_finite_ends_and_says_when() {
    // So much acceleration overflows within the first sample, at once in closed form and after some
    // steps of RK4.
    for (solver, gain) in [("exact", "1e308"), ("rk4", "1e300")] {
        let gain = format!("joint.gain_deg_per_s2_per_v={gain}");
        let directory = tempfile::tempdir().unwrap();
        let csv = directory.path().join("run.csv");
        let mut arguments = vec!["run", "step-response", "--controller", "pd", "--solver", solver];
        arguments.extend(["--set", &gain, "--set", "reference.steps_deg=[5.0]"]);
        let with = |more: &[&'static str]| {
            let all: Vec<&str> = arguments.iter().copied().chain(more.iter().copied()).collect();
            stiction(&all).output().unwrap()
        };
        let table = String::from_utf8(with(&[]).stdout).unwrap();
        assert!(
            table.contains("pd/step-5.0: the simulation diverged") && table.contains("0.02 s"),
            "{solver}: {table}"
        );
        // Strict JSON has no NaN, so a report with one would not be read.
        let report: Value = serde_json::from_slice(&with(&["--json"]).stdout).unwrap();
        let run = &report["runs"][0];
        assert_eq!(
            (run["diverged_at_s"].as_f64(), &run["unstable"]),
            (Some(0.02), &Value::Bool(true))
        );
        arguments.extend(["--csv", csv.to_str().unwrap()]);
        assert!(stiction(&arguments).output().unwrap().status.success());
        let csv = fs::read_to_string(&csv).unwrap();
        assert_eq!(csv.lines().count(), 2, "{solver}: the header and the sample before");
        assert!(!csv.contains("NaN") && !csv.contains("inf"), "{solver}: {csv}");
    }
}

/// The joint has neither friction nor viscosity: nothing ends its motion but the bound of the ramp.
#[test]
fn a_ramp_on_a_joint_that_never_stops_ends_without_a_slip_level() {
    let set = [
        "joint.friction.slip_v=0",
        "joint.viscous_v_per_deg_per_s=0",
        "identification.ramp_rates_v_per_s=[0.1]",
    ];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"));
    command
        .args(["run", "friction-identification", "--json"])
        .args(set.iter().flat_map(|set| ["--set", set]));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let metrics = &report["runs"][0]["metrics"];
    assert!(metrics["stick_v"].is_number() && metrics["slip_v"].is_null(), "{metrics}");
}
