//! Keys of the JSON of a run, and which metrics are null.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{keys, number, run, runs};

/// The documented metrics, and whether each applies to steps, trajectories, ramps and sines.
const METRICS: [(&str, [bool; 4]); 16] = [
    ("steady_state_error_deg", [true, true, false, false]),
    ("rest_error_counts", [true, true, false, false]),
    ("overshoot_deg", [true, false, false, false]),
    ("rise_time_s", [true, false, false, false]),
    ("settling_time_s", [true, false, false, false]),
    ("rms_error_deg", [true, true, false, true]),
    ("max_error_deg", [true, true, false, true]),
    ("cruise_error_deg", [false, true, false, false]),
    ("reversal_error_deg", [false, false, false, true]),
    ("sticks_in_motion", [false, true, false, true]),
    ("hunting_peak_to_peak_deg", [true, false, false, false]),
    ("hunting_period_s", [true, false, false, false]),
    ("control_total_variation_v_per_s", [true, true, false, true]),
    ("stick_v", [false, false, true, false]),
    ("slip_v", [false, false, true, false]),
    ("slip_corrected_v", [false, false, true, false]),
];

/// Metrics of both sides of the gear. Settling is null where the file's goal is missed.
const OF_SIDES: [&str; 6] = [
    "rest_at_encoder_counts",
    "rest_at_load_counts",
    "settled_at_encoder_s",
    "settled_at_load_s",
    "success_at_encoder",
    "success_at_load",
];

#[test]
fn json_of_a_run_has_the_documented_keys_and_no_others() {
    for (experiment, source) in [
        ("step-response", "Table 17"),
        ("trajectory", "Table 17"),
        ("step-added-friction", "Section 3.3.2"),
        ("srnf-robustness", "Table 18"),
        ("srnf-added-friction", "Table 19"),
        ("high-gain", "Table 24"),
        ("friction-identification", "Section 3.2"),
    ] {
        let report = run(&[experiment]);
        assert_eq!(
            keys(&report),
            BTreeSet::from(["experiment", "runs", "schema", "source", "unseen_slack"]),
            "{experiment}"
        );
        assert_eq!(
            [&report["schema"], &report["experiment"], &report["source"]],
            [&json!(1), &json!(experiment), &json!(source)]
        );
        for run in runs(&report) {
            let label = &run["label"];
            let expected = "cost diverged_at_s events goal label metrics parameters unstable";
            assert_eq!(keys(run), expected.split(' ').collect(), "{label}");
            assert_eq!(
                keys(&run["cost"]),
                BTreeSet::from(["derivative_evaluations", "wall_s"]),
                "{label}"
            );
            assert_eq!(
                keys(&run["metrics"]),
                METRICS.iter().map(|(name, _)| *name).chain(OF_SIDES).collect(),
                "{label}"
            );
            assert!(number(&run["cost"]["wall_s"]) > 0.0, "{label}");
            assert!(run["unstable"].is_boolean() && run["diverged_at_s"].is_null(), "{label}");
            let mut last_s = 0.0;
            for event in run["events"].as_array().unwrap() {
                assert_eq!(keys(event), BTreeSet::from(["body", "kind", "time_s"]), "{label}");
                assert_eq!(event["body"], 1, "{label}");
                assert!(
                    ["break", "stick", "reverse"].contains(&event["kind"].as_str().unwrap()),
                    "{label}"
                );
                assert!(
                    number(&event["time_s"]) >= last_s,
                    "{label}: {event} is not after {last_s} s"
                );
                last_s = number(&event["time_s"]);
            }
            assert_eq!(
                run["events"][0]["kind"], "break",
                "{label}: a joint at rest breaks away first"
            );
        }
    }
}

#[test]
fn a_metric_is_null_exactly_where_it_does_not_apply() {
    // The runs are of SRNF, which settles and rests, and of ramps; hunting has its own test.
    const SINE: &[&str] = &[
        "--set",
        "reference.trajectories=[]",
        "--set",
        "reference.sines=[{amplitude_deg=2, frequency_hz=0.5}]",
    ];
    let experiments: [(&str, &[&str], usize, usize); 5] = [
        ("step-response", &[], 3, 0),
        ("trajectory", &[], 2, 1),
        ("srnf-added-friction", &[], 4, 1),
        ("friction-identification", &[], 5, 2),
        ("trajectory", SINE, 1, 3),
    ];
    for (experiment, set, count, kind) in experiments {
        let only = if kind == 2 { "pd" } else { "srnf" };
        let report = run(&[&[experiment, "--controller", only], set].concat());
        let stable: Vec<&Value> =
            runs(&report).iter().filter(|run| run["unstable"] == false).collect();
        assert_eq!(stable.len(), count, "{experiment}");
        for run in stable {
            for (name, applies) in METRICS.iter().filter(|(name, _)| !name.starts_with("hunting")) {
                let value = &run["metrics"][name];
                assert_eq!(value.is_number(), applies[kind], "{}: {name} is {value}", run["label"]);
                assert_eq!(value.is_null(), !applies[kind], "{}: {name} is {value}", run["label"]);
            }
        }
    }
}

/// A rigid joint has the same on both sides, by the goal of two counts; a ramp has no goal to meet.
#[test]
fn both_sides_of_a_rigid_joint_are_the_same_and_judged_by_the_goal() {
    let report = run(&["step-response", "--controller", "srnf,dnpf"]);
    assert!(report["unseen_slack"].is_null());
    for run in runs(&report).iter().filter(|run| run["unstable"] == false) {
        let metrics = &run["metrics"];
        let rest = number(&metrics["rest_error_counts"]);
        for side in ["encoder", "load"] {
            assert!((number(&metrics[format!("rest_at_{side}_counts")]) - rest).abs() < 1e-9);
            let success = &metrics[format!("success_at_{side}")];
            assert_eq!(*success, metrics[format!("settled_at_{side}_s")].is_number(), "{run}");
            // A joint that rests outside of two counts is no success.
            assert!(rest.abs() <= 2.0 || *success == false, "{run}");
        }
        assert_eq!(run["goal"]["tolerance_counts"], 2.0);
    }
    // 100 counts of 0.00242 deg are wide enough for every stable run.
    let wide = "goal.tolerance_deg=0.242";
    let report = run(&["step-response", "--controller", "srnf", "--set", wide]);
    for run in runs(&report).iter().filter(|run| run["unstable"] == false) {
        assert_eq!(run["metrics"]["success_at_load"], true, "{run}");
        assert!((number(&run["goal"]["tolerance_counts"]) - 100.0).abs() < 1e-9, "{run}");
    }
    // The settling time of a step is that of the goal, and of 0.05 deg in a file without one.
    let settled = |set: &[&str]| {
        let report = run(&[&["step-response", "--controller", "srnf"], set].concat());
        let metrics = &runs(&report)[0]["metrics"];
        ["settling_time_s", "settled_at_load_s"].map(|name| metrics[name].as_f64())
    };
    let ([default, _], [wider, by_goal]) = (settled(&[]), settled(&["--set", wide]));
    assert!(wider == by_goal && wider.is_some() && wider < default, "{wider:?} {default:?}");
    let ramps = run(&["friction-identification"]);
    let nulls = |run: &Value| OF_SIDES.iter().all(|name| run["metrics"][name].is_null());
    assert!(runs(&ramps).iter().all(nulls), "{ramps}");
}

#[test]
fn hunting_is_null_unless_a_step_turns_back_and_forth() {
    let hunting = |run: &Value| {
        let both = ["hunting_peak_to_peak_deg", "hunting_period_s"]
            .map(|name| run["metrics"][name].is_f64());
        assert_eq!(both[0], both[1], "{}", run["label"]);
        both[0]
    };
    // PD comes to rest and stays; RI hunts for ever (Armstrong and Amin); a trajectory is never
    // judged.
    let step = ["reference.steps_deg=[5.0]", "run.duration_s=120"];
    let report =
        run(&["step-response", "--controller", "pd,ri", "--set", step[0], "--set", step[1]]);
    let of = |label: &str| runs(&report).iter().find(|run| run["label"] == label).map(hunting);
    assert_eq!([of("pd/step-5.0"), of("ri/step-5.0")], [Some(false), Some(true)]);
    assert!(!runs(&run(&["trajectory"])).iter().any(hunting));
    assert!(!runs(&run(&["friction-identification"])).iter().any(hunting));
}
