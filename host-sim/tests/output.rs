//! What the command line prints and writes when all is well, on the built program: JSON, CSV, tables, labels, and the
//! keys that a user sets. Blind to figures, and to whether the numbers are right (that is for the tests of the plant).
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use serde_json::{Value, json};

/// The documented names, and on which of steps, trajectories and ramps a metric applies.
const METRICS: [(&str, [bool; 3]); 14] = [
    ("steady_state_error_deg", [true, true, false]),
    ("rest_error_counts", [true, true, false]),
    ("overshoot_deg", [true, false, false]),
    ("rise_time_s", [true, false, false]),
    ("settling_time_s", [true, false, false]),
    ("rms_error_deg", [true, true, false]),
    ("max_error_deg", [true, true, false]),
    ("cruise_error_deg", [false, true, false]),
    ("hunting_peak_to_peak_deg", [true, false, false]),
    ("hunting_period_s", [true, false, false]),
    ("control_total_variation_v_per_s", [true, true, false]),
    ("stick_v", [false, false, true]),
    ("slip_v", [false, false, true]),
    ("slip_corrected_v", [false, false, true]),
];

const COLUMNS: &str =
    "time_s,reference_deg,position_deg,error_deg,velocity_deg_per_s,v_pd_v,v_c_v,v_v,code,stuck,v_applied_v";

const SEVEN: [&str; 7] = ["pd", "ri", "rvi", "roi", "feedforward", "dnpf", "srnf"];

/// What the program prints; it must succeed, and say nothing else.
fn stiction(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{arguments:?}: {}, {said}", output.status);
    String::from_utf8(output.stdout).unwrap()
}

fn run(arguments: &[&str]) -> Value {
    serde_json::from_str(&stiction(&[&["run", "--json"], arguments].concat())).unwrap()
}

fn runs(report: &Value) -> &[Value] {
    report["runs"].as_array().unwrap()
}

fn labels(report: &Value) -> Vec<&str> {
    runs(report).iter().map(|run| run["label"].as_str().unwrap()).collect()
}

fn keys(object: &Value) -> BTreeSet<&str> {
    object.as_object().unwrap().keys().map(String::as_str).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

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
        assert_eq!(keys(&report), BTreeSet::from(["experiment", "runs", "schema", "source"]), "{experiment}");
        assert_eq!(
            [&report["schema"], &report["experiment"], &report["source"]],
            [&json!(1), &json!(experiment), &json!(source)]
        );
        for run in runs(&report) {
            let label = &run["label"];
            let expected = "cost diverged_at_s events label metrics parameters unstable";
            assert_eq!(keys(run), expected.split(' ').collect(), "{label}");
            assert_eq!(keys(&run["cost"]), BTreeSet::from(["derivative_evaluations", "wall_s"]), "{label}");
            assert_eq!(keys(&run["metrics"]), METRICS.iter().map(|(name, _)| *name).collect(), "{label}");
            assert!(number(&run["cost"]["wall_s"]) > 0.0, "{label}");
            assert!(run["unstable"].is_boolean() && run["diverged_at_s"].is_null(), "{label}");
            let mut last_s = 0.0;
            for event in run["events"].as_array().unwrap() {
                assert_eq!(keys(event), BTreeSet::from(["body", "kind", "time_s"]), "{label}");
                assert_eq!(event["body"], 1, "{label}");
                assert!(["break", "stick", "reverse"].contains(&event["kind"].as_str().unwrap()), "{label}");
                assert!(number(&event["time_s"]) >= last_s, "{label}: {event} is not after {last_s} s");
                last_s = number(&event["time_s"]);
            }
            assert_eq!(run["events"][0]["kind"], "break", "{label}: a joint at rest breaks away first");
        }
    }
}

#[test]
fn a_metric_is_null_exactly_where_it_does_not_apply() {
    // Of SRNF, which settles and rests, and of ramps; hunting has its own test.
    let experiments = [
        ("step-response", 3, 0),
        ("trajectory", 2, 1),
        ("srnf-added-friction", 4, 1),
        ("friction-identification", 5, 2),
    ];
    for (experiment, count, kind) in experiments {
        let only = if kind == 2 { "pd" } else { "srnf" };
        let report = run(&[experiment, "--controller", only]);
        let stable: Vec<&Value> = runs(&report).iter().filter(|run| run["unstable"] == false).collect();
        assert_eq!(stable.len(), count, "{experiment}");
        for run in stable {
            for (name, applies) in METRICS.iter().filter(|(name, _)| !name.starts_with("hunting")) {
                let value = &run["metrics"][name];
                assert_eq!(value.is_f64(), applies[kind], "{}: {name} is {value}", run["label"]);
                assert_eq!(value.is_null(), !applies[kind], "{}: {name} is {value}", run["label"]);
            }
        }
    }
}

#[test]
fn hunting_is_null_unless_a_step_turns_back_and_forth() {
    let hunting = |run: &Value| {
        let both = ["hunting_peak_to_peak_deg", "hunting_period_s"].map(|name| run["metrics"][name].is_f64());
        assert_eq!(both[0], both[1], "{}", run["label"]);
        both[0]
    };
    // PD comes to rest and stays; RI hunts for ever (Armstrong and Amin); a trajectory is never judged.
    let step = ["reference.steps_deg=[5.0]", "run.duration_s=120"];
    let report = run(&["step-response", "--controller", "pd,ri", "--set", step[0], "--set", step[1]]);
    let of = |label: &str| runs(&report).iter().find(|run| run["label"] == label).map(hunting);
    assert_eq!([of("pd/step-5.0"), of("ri/step-5.0")], [Some(false), Some(true)]);
    assert!(!runs(&run(&["trajectory"])).iter().any(hunting));
    assert!(!runs(&run(&["friction-identification"])).iter().any(hunting));
}

#[test]
fn every_run_of_every_experiment_has_its_label() {
    let of = |names: &[&str], motions: &[&str], variants: &[&str]| -> Vec<String> {
        let mut labels = Vec::new();
        for variant in variants {
            for name in names {
                labels.extend(motions.iter().map(|motion| format!("{name}/{motion}{variant}")));
            }
        }
        labels
    };
    let speeds = ["trajectory-5.0", "trajectory-2.5"];
    let steps = of(&SEVEN, &["step-5.0", "step-2.5", "step-1.0"], &[""]);
    let in_si = of(&SEVEN, &["step-5.0"], &["/literal-si"]);
    let five = ["pd", "ri", "roi", "dnpf", "srnf"];
    let rates = ["rate-0.001", "rate-0.002", "rate-0.005", "rate-0.01", "rate-0.02"];
    for (experiment, expected) in [
        ("step-response", [steps, in_si].concat()),
        ("trajectory", of(&SEVEN, &speeds, &[""])),
        (
            "step-added-friction",
            of(&["pd"], &["step-5.0"], &["/friction-1.25", "/friction-1.5", "/friction-2"]),
        ),
        ("srnf-robustness", of(&["srnf"], &speeds, &["/test-1", "/test-2", "/test-3", "/test-4"])),
        (
            "srnf-added-friction",
            of(&["srnf"], &speeds[1..], &["/added-0.1", "/added-0.2", "/added-0.4", "/added-variable"]),
        ),
        ("high-gain", of(&five, &speeds, &["", "/delay-1"])),
        ("friction-identification", of(&["ramp"], &rates, &[""])),
    ] {
        assert_eq!(labels(&run(&[experiment])), expected, "{experiment}");
    }
}

#[test]
fn controllers_run_in_the_order_that_was_asked_for() {
    let steps = |names: [&str; 2]| {
        let report = run(&["step-response", "--controller", &names.join(",")]);
        labels(&report).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let expected = |[a, b]: [&str; 2]| {
        let motions =
            [(a, ""), (b, "")].map(|(name, _)| ["5.0", "2.5", "1.0"].map(|deg| format!("{name}/step-{deg}")));
        let in_si = [a, b].map(|name| format!("{name}/step-5.0/literal-si"));
        [motions.concat(), in_si.to_vec()].concat()
    };
    for names in [["pd", "srnf"], ["srnf", "pd"]] {
        assert_eq!(steps(names), expected(names));
    }
    assert_eq!(steps(["pd", " srnf"]), expected(["pd", "srnf"]), "a space after the comma");
}

#[test]
fn a_key_that_is_set_is_used_and_leaves_out_the_variants_that_set_it_otherwise() {
    let all = run(&["srnf-robustness"]);
    assert_eq!(runs(&all).len(), 8);
    let set = ["controller.srnf.v_ms_v=0.4", "run.duration_s=24.5"];
    let report = run(&["srnf-robustness", "--set", set[0], "--set", set[1]]);
    // Tests 3 and 4 have v_ms = 0.4 (Table 18).
    let speeds = ["trajectory-5.0", "trajectory-2.5"];
    let expected =
        ["test-3", "test-4"].map(|test| speeds.map(|speed| format!("srnf/{speed}/{test}"))).concat();
    assert_eq!(labels(&report), expected);
    for run in runs(&report) {
        assert_eq!(run["parameters"]["run"]["duration_s"], 24.5, "{}", run["label"]);
        assert_eq!(run["parameters"]["controller"]["v_ms_v"], 0.4, "{}", run["label"]);
        let last_s = run["events"].as_array().unwrap().last().map(|event| number(&event["time_s"]));
        assert!(last_s <= Some(24.5), "{}", run["label"]);
    }
    // 5 is 5.0 to a variant.
    let whole = run(&["step-response", "--controller", "pd", "--set", "reference.steps_deg=[5]"]);
    assert_eq!(labels(&whole), ["pd/step-5.0", "pd/step-5.0/literal-si"]);
    let other = run(&["step-response", "--controller", "pd", "--set", "reference.steps_deg=[4]"]);
    assert_eq!(labels(&other), ["pd/step-4.0"]);
}

#[test]
fn the_last_of_two_values_of_a_key_counts() {
    let arguments = ["trajectory", "--controller", "pd", "--set", "run.duration_s=25"];
    let report = run(&[&arguments[..], &["--set", "run.duration_s=24"]].concat());
    assert_eq!(runs(&report)[0]["parameters"]["run"]["duration_s"], 24.0);
    assert_eq!(runs(&run(&arguments))[0]["parameters"]["run"]["duration_s"], 25.0);
}

#[test]
fn a_sample_of_delay_is_in_the_label_and_in_the_motion() {
    let without = run(&["trajectory", "--controller", "srnf", "--delay", "0"]);
    let with = run(&["trajectory", "--controller", "srnf", "--delay", "1"]);
    assert_eq!(labels(&without), ["srnf/trajectory-5.0", "srnf/trajectory-2.5"]);
    assert_eq!(labels(&with), ["srnf/trajectory-5.0/delay-1", "srnf/trajectory-2.5/delay-1"]);
    assert_eq!(runs(&with)[0]["parameters"]["run"]["delay_samples"], 1);
    // What the first sample asks for takes effect at the second: the joint breaks away 20 ms later.
    let [early, late] = [&without, &with].map(|report| number(&runs(report)[0]["events"][0]["time_s"]));
    assert!((late - early - 0.02).abs() < 1e-9, "{early} and {late} s");
    // An experiment that has both kinds keeps the one that was asked for.
    assert_eq!(runs(&run(&["high-gain"])).len(), 20);
    let delayed = run(&["high-gain", "--delay", "1"]);
    assert_eq!(runs(&delayed).len(), 10);
    assert!(labels(&delayed).iter().all(|label| label.ends_with("/delay-1")));
}

#[test]
fn the_solver_that_was_asked_for_is_used_and_its_cost_is_counted() {
    let solved = |solver: &str| {
        let report = run(&["step-response", "--controller", "srnf", "--solver", solver]);
        let run = runs(&report)[0].clone();
        assert_eq!(run["parameters"]["run"]["solver"], solver);
        (run["cost"]["derivative_evaluations"].as_u64().unwrap(), number(&run["metrics"]["rms_error_deg"]))
    };
    let ((exact, rms), (rk4, rms_by_steps)) = (solved("exact"), solved("rk4"));
    // 10 s by steps of 1e-5 s, four evaluations each.
    assert_eq!((exact, rk4), (0, 4_000_000));
    assert!((rms - rms_by_steps).abs() < 1e-3 && rms != rms_by_steps, "{rms} and {rms_by_steps} deg");
}

#[test]
fn csv_has_a_line_a_sample_under_the_documented_header() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    let file = path.to_str().unwrap();
    let csv = |arguments: &[&str]| {
        stiction(&[&["run", "--csv", file], arguments].concat());
        fs::read_to_string(&path).unwrap()
    };
    let text = csv(&[
        "trajectory",
        "--controller",
        "srnf",
        "--set",
        "reference.trajectories=[{corner_times_s=[1, 3], \
         corner_positions_deg=[0, 10], half_blend_s=0.25}]",
        "--set",
        "run.duration_s=6",
    ]);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(COLUMNS));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 301);
    for (k, row) in rows.iter().enumerate() {
        let cell = |i: usize| row[i].parse::<f64>().unwrap();
        assert!(row.len() == 11 && (cell(0) - 0.02 * k as f64).abs() < 1e-9, "{row:?}");
        assert!((cell(1) - cell(2) - cell(3)).abs() < 1e-9, "the error is reference minus position: {row:?}");
        assert!(
            (cell(5) + cell(6) - cell(7)).abs() < 1e-5,
            "unsaturated, PD and compensator add up: {row:?}"
        );
        assert!((cell(8) - cell(7) / 0.00488).abs() <= 0.5 + 1e-3, "the code is in LSB: {row:?}");
        assert!((cell(10) - cell(8) * 0.00488).abs() < 1e-6, "what is applied is the code's volts: {row:?}");
        assert!(["true", "false"].contains(&row[9]) && (row[9] == "false" || cell(4) == 0.0), "{row:?}");
    }
    assert_eq!(rows[0][9], "true");

    let text = csv(&["friction-identification", "--set", "identification.ramp_rates_v_per_s=[0.02]"]);
    assert_eq!(text.lines().next(), Some(COLUMNS));
    // A ramp has no reference, no error and no controller.
    let row: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    let empty: Vec<usize> = (0..row.len()).filter(|i| row[*i].is_empty()).collect();
    assert_eq!((row.len(), empty), (11, vec![1, 3, 5, 6]));

    let text = csv(&["step-response", "--controller", "pd", "--set", "joint.gain_deg_per_s2_per_v=27"]);
    let header = format!("label,{COLUMNS}");
    assert_eq!(text.lines().next(), Some(header.as_str()));
    for label in ["pd/step-5.0,", "pd/step-2.5,", "pd/step-1.0,"] {
        assert_eq!(text.lines().filter(|line| line.starts_with(label)).count(), 501, "{label}");
    }
    assert_eq!(text.lines().count(), 1 + 3 * 501);
}

#[test]
fn every_table_fits_into_80_columns() {
    let directory = tempfile::tempdir().unwrap();
    let long = directory.path().join("long.toml");
    let toml = stiction(&["show", "step-response"])
        .replace("[controller.pd]", "[controller.twenty-letters-at-mo]\nlaws = []")
        .replace("controller = [\"pd\",", "controller = [\"twenty-letters-at-mo\",");
    fs::write(&long, toml).unwrap();
    let listing: Value = serde_json::from_str(&stiction(&["list", "--json"])).unwrap();
    let names =
        listing["experiments"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap());
    for experiment in names.chain([long.to_str().unwrap()]) {
        for delay in ["0", "1"] {
            let toml = fs::read_to_string(experiment).unwrap_or_else(|_| stiction(&["show", experiment]));
            // A friction experiment has no samples to delay.
            let of_friction = toml.contains("[mechanism]");
            let arguments = ["run", experiment, "--delay", delay];
            let arguments = if of_friction { &arguments[..2] } else { &arguments };
            // The runs of another delay are left out of the one experiment that has both.
            let table = stiction(arguments);
            let widest = table.lines().map(|line| line.chars().count()).max().unwrap();
            assert!((40..=80).contains(&widest), "{experiment}, delay {delay}: {widest} columns\n{table}");
        }
    }
}

#[test]
fn list_names_every_experiment_with_its_source() {
    let listing: Value = serde_json::from_str(&stiction(&["list", "--json"])).unwrap();
    assert_eq!((keys(&listing), &listing["schema"]), (BTreeSet::from(["experiments", "schema"]), &json!(1)));
    let entries = listing["experiments"].as_array().unwrap();
    let names: Vec<&str> = entries.iter().map(|entry| entry["name"].as_str().unwrap()).collect();
    let expected = "spring-mass spring-mass-2dof manipulator-1dof manipulator-2dof square-wave triangle-wave \
                    spring-mass-revisited step-response trajectory step-added-friction srnf-robustness \
                    srnf-added-friction high-gain friction-identification spring-mass-independent";
    assert_eq!(names, expected.split(' ').collect::<Vec<_>>());
    let table = stiction(&["list"]);
    for entry in entries {
        assert_eq!(keys(entry), BTreeSet::from(["name", "source", "title"]), "{entry}");
        let [name, source, title] = ["name", "source", "title"].map(|key| entry[key].as_str().unwrap());
        assert!(["Table ", "Tables ", "Section "].iter().any(|kind| source.starts_with(kind)), "{entry}");
        let line = table.lines().position(|line| line.starts_with(name) && line.ends_with(source));
        assert!(line.is_some_and(|i| table.lines().nth(i + 1).unwrap().trim() == title), "{name}:\n{table}");
    }
}

#[test]
fn a_shown_experiment_saved_as_a_file_runs_the_same() {
    let directory = tempfile::tempdir().unwrap();
    // The name of a built-in experiment, where a file of that name must not be taken for it.
    let path = directory.path().join("trajectory");
    for experiment in ["step-response", "high-gain", "srnf-added-friction", "friction-identification"] {
        fs::write(&path, stiction(&["show", experiment])).unwrap();
        let (built_in, from_file) = (run(&[experiment]), run(&[path.to_str().unwrap()]));
        assert_eq!(from_file["experiment"], path.to_str().unwrap());
        assert_eq!(built_in["experiment"], experiment);
        assert_eq!(runs(&built_in).len(), runs(&from_file).len(), "{experiment}");
        for (a, b) in runs(&built_in).iter().zip(runs(&from_file)) {
            for key in ["label", "parameters", "events", "metrics", "unstable", "diverged_at_s"] {
                assert_eq!(a[key], b[key], "{experiment}: {key} of {}", a["label"]);
            }
        }
    }
    fs::write(&path, "nonsense").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["run", "trajectory", "--json", "--controller", "pd"])
        .current_dir(directory.path())
        .output()
        .unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["experiment"], &report["source"]), (&json!("trajectory"), &json!("Table 17")));
}

#[test]
fn a_user_s_own_controller_adds_its_laws() {
    let own = r#"
        [joint]
        gain_deg_per_s2_per_v = 27.0
        viscous_v_per_deg_per_s = 0.02
        friction = { stick_v = 0.40, slip_v = 0.38 }
        [encoder]
        resolution_deg = 0.00242
        counter_bits = 16
        [drive]
        full_scale_v = 5.0
        lsb_v = 0.00488
        pwm_hz = 22000.0
        mode = "sign-magnitude"
        [loop]
        sample_time_s = 0.02
        controller = "mine"
        [controller.mine]
        laws = ["feedforward", "srnf"]
        kp_v_per_deg = 1.0
        kd_v_per_deg_per_s = 0.25
        v_slip_v = 0.37
        v_ff_deg_per_s = 0.001
        v_ms_v = 0.05
        alpha_per_deg = 100
        [[reference.trajectories]]
        corner_times_s = [1, 11]
        corner_positions_deg = [0, 50]
        half_blend_s = 0.25
    "#;
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let v_c_at_5_s = |laws: &str| {
        fs::write(file("my joint.toml"), own.replace("\"feedforward\", \"srnf\"", laws)).unwrap();
        let report = run(&[&file("my joint.toml"), "--csv", &file("run.csv")]);
        assert_eq!(labels(&report), ["mine/trajectory-5.0"]);
        assert_eq!(report["experiment"], file("my joint.toml"));
        let csv = fs::read_to_string(file("run.csv")).unwrap();
        let cells: Vec<&str> = csv.lines().nth(1 + 250).unwrap().split(',').collect();
        assert_eq!(cells[0], "5.0");
        cells[6].parse::<f64>().unwrap()
    };
    // In motion the feedforward gives v_slip; SRNF some of its 0.05 V, more where the error is large.
    assert_eq!(v_c_at_5_s("\"feedforward\""), 0.37);
    assert_eq!(v_c_at_5_s("\"srnf\""), 0.05);
    assert_eq!(v_c_at_5_s(""), 0.0);
    let both = v_c_at_5_s("\"feedforward\", \"srnf\"");
    assert!(both > 0.38 && both <= 0.42, "{both} V");
}
