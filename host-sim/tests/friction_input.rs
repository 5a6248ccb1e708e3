//! The command line answers to a friction experiment that cannot be with one sentence that names
//! the key, what was found and what is allowed, with exit code 2, and with nothing on the standard
//! output.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Stdio};

use simulator::experiment::Document;
use thesis::lab;

/// Says why an answer is not as it should be, if so.
fn complaint(arguments: &[&str], fragments: &[&str]) -> Option<String> {
    let output = Command::new(env!("CARGO_BIN_EXE_stiction"))
        .arg("run")
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let missing: Vec<_> = fragments.iter().filter(|fragment| !said.contains(**fragment)).collect();
    let good = output.status.code() == Some(2)
        && output.stdout.is_empty()
        && said.starts_with("stiction: ")
        && said.lines().count() == 1
        && missing.is_empty()
        && !["f64", "serde", "expected", "panicked"].iter().any(|word| said.contains(word));
    (!good).then(|| format!("{arguments:?}: {:?}, lacks {missing:?}: {said}", output.status.code()))
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    let set = |value: &'static str| vec!["spring-mass", "--set", value];
    let cases: Vec<(Vec<&str>, &[&str])> = vec![
        (set("mechanism.mass_kg=[0]"), &["`mechanism.mass_kg[0]` is 0", "above 0"]),
        (set("mechanism.mass_kg=[-0.1]"), &["is -0.1", "above 0"]),
        (set("mechanism.mass_kg=[nan]"), &["is NaN", "above 0"]),
        (set("mechanism.mass_kg=[0.1, 0.1]"), &["a list of 2", "a list of 1"]),
        (
            set("mechanism.stiffness_n_per_m=[0.0]"),
            &["`mechanism.stiffness_n_per_m[0]` is 0", "above 0"],
        ),
        (set("mechanism.stiffness_n_per_m=[-100]"), &["is -100", "above 0"]),
        (set("mechanism.length_m=[1.0]"), &["`mechanism.length_m` has no meaning", "spring-mass"]),
        (
            set("friction.stick_n=[0.1]"),
            &["`friction.stick_n[0]` is 0.1", "not below", "friction.slip_n"],
        ),
        (
            set("friction.stick_n=[0.3]"),
            &[
                "`friction.reset-integrator.gradient[0]` is 0.25",
                "0.5 give or take 6 %",
                "`friction.stick_n`",
                "leave it out",
            ],
        ),
        (
            set("friction.slip_n=[0.18]"),
            &[
                "`friction.reset-integrator.stiffness_n_per_m[0]` is 20000",
                "18000",
                "`friction.slip_n`",
            ],
        ),
        (
            set("friction.range_m=[2e-5]"),
            &["reset-integrator.stiffness_n_per_m[0]` is 20000", "10000", "`friction.range_m`"],
        ),
        (
            vec!["manipulator-1dof", "--set", "friction.stick_nm=[1.3]"],
            &["`friction.reset-integrator.gradient[0]` is 0.25", "0.3542", "`friction.stick_nm`"],
        ),
        (set("friction.range_m=[0.0]"), &["`friction.range_m[0]` is 0", "above 0"]),
        (set("friction.range_rad=[1e-5]"), &["two units"]),
        (set("run.tolerance=0"), &["`run.tolerance` is 0", "1e-14 to 0.01"]),
        (set("run.duration_s=0"), &["`run.duration_s` is 0", "from 1e-9 up"]),
        (set("run.duration_s=1e-321"), &["`run.duration_s`", "from 1e-9 up"]),
        (
            vec![
                "spring-mass",
                "--friction",
                "elastic-coulomb",
                "--set",
                "friction.elastic-coulomb.damping_n_s_per_m=[0]",
            ],
            &["friction.elastic-coulomb.damping_n_s_per_m[0]` is 0", "above 0"],
        ),
        (
            vec![
                "square-wave",
                "--friction",
                "reset-integrator",
                "--solver",
                "rk4",
                "--set",
                "mechanism.push.period_s=1e-9",
            ],
            &["`run.duration_s`", "a quarter of the wave's period"],
        ),
        (set("run.duration_s=1e9"), &["`run.duration_s` is 1000000000", "a number up to"]),
        (set("run.friction=[\"dry\"]"), &["\"dry\"", "must be one of classical"]),
        (set("run.friction=[\"dahl\", \"dahl\"]"), &["names `dahl` twice"]),
        (
            vec!["spring-mass", "--friction", "karnopp,lugre"],
            &["--friction karnopp,lugre", "one friction model"],
        ),
        (
            vec!["spring-mass", "--friction", "karnopp", "--friction", "dahl"],
            &["--friction karnopp,dahl", "one friction model"],
        ),
        (vec!["spring-mass", "--friction", "karnop"], &["did you mean `karnopp"]),
        (
            vec!["spring-mass", "--friction", "karnopp-banded"],
            &["`karnopp-banded` does not go with", "`exact`", "because"],
        ),
        (
            vec!["spring-mass", "--friction", "karnopp", "--solver", "rk4"],
            &["`karnopp` does not go with", "because"],
        ),
        (
            vec!["spring-mass", "--friction", "reset-integrator", "--solver", "nonsmooth"],
            &["`reset-integrator` does not go with", "because"],
        ),
        (
            vec![
                "spring-mass",
                "--friction",
                "karnopp-banded",
                "--solver",
                "rk4",
                "--coupling",
                "neglected",
            ],
            &["`neglected` does not go with", "one body"],
        ),
        (
            vec!["manipulator-2dof", "--friction", "karnopp", "--coupling", "neglected"],
            &["`neglected` does not go with `karnopp`"],
        ),
        (
            vec![
                "spring-mass",
                "--friction",
                "karnopp-banded",
                "--solver",
                "rk4",
                "--set",
                "run.step_s=1e-9",
            ],
            &["`run.duration_s` is 5", "a number up to 0.0999"],
        ),
        (vec!["spring-mass", "--controller", "pd"], &["--controller", "has none"]),
        (vec!["spring-mass", "--delay", "1"], &["--delay", "has none"]),
        (
            vec!["step-response", "--friction", "karnopp"],
            &["--friction karnopp", "friction experiments"],
        ),
    ];
    let complaints: Vec<String> =
        cases.iter().filter_map(|(arguments, fragments)| complaint(arguments, fragments)).collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn the_json_of_a_friction_run_is_what_scripts_rely_on() {
    let run = |arguments: &[&str]| -> serde_json::Value {
        let output = Command::new(env!("CARGO_BIN_EXE_stiction"))
            .arg("run")
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let json = run(&["spring-mass", "--friction", "karnopp", "--solver", "exact", "--json"]);
    assert_eq!((&json["schema"], &json["experiment"]), (&1.into(), &"spring-mass".into()));
    let [only] = &json["runs"].as_array().unwrap()[..] else { unreachable!() };
    assert_eq!(only["label"], "karnopp/exact");
    assert_eq!(
        (&only["unstable"], &only["diverged_at_s"]),
        (&false.into(), &serde_json::Value::Null)
    );
    let first = &only["events"][0];
    assert_eq!((&first["body"], &first["kind"]), (&1.into(), &"break".into()));
    assert!((first["time_s"].as_f64().unwrap() - 1.25).abs() < 1e-9);
    assert_eq!(only["metrics"]["breaks"], serde_json::json!([7]));
    // The closed form is V_o + sqrt(V_o^2 + ((F_s - F_d) / (m w))^2) with w = sqrt(K/m).
    let expected = 0.002 + (0.002_f64.powi(2) + (0.05 / 0.1_f64 / 1000_f64.sqrt()).powi(2)).sqrt();
    let fastest = only["metrics"]["max_speed"][0].as_f64().unwrap();
    assert!((fastest / expected - 1.0).abs() < 1e-6, "{fastest}, not {expected}");
    assert!((only["metrics"]["peak_friction"][0].as_f64().unwrap() - 0.25).abs() < 1e-9);
    assert!(only["cost"]["derivative_evaluations"].as_u64().unwrap() > 100);
    assert!(only["cost"]["wall_s"].as_f64().unwrap() > 0.0);
    let both = run(&["manipulator-2dof", "--json"]);
    let labels: Vec<_> =
        both["runs"].as_array().unwrap().iter().map(|run| run["label"].clone()).collect();
    assert_eq!(labels, ["karnopp/exact", "reset-integrator/exact"]);
    let coupled = run(&[
        "manipulator-2dof",
        "--friction",
        "karnopp-banded",
        "--solver",
        "rk4",
        "--coupling",
        "neglected",
        "--set",
        "run.step_s=1e-4",
        "--json",
    ]);
    assert_eq!(coupled["runs"][0]["label"], "karnopp-banded/rk4/neglected");
}

/// A table of the thesis. It has the unit that K_r has here and what it is to that of the table,
/// then for each body p_o, F_d, F_s, K_r and a as printed.
type Printed = (&'static str, &'static str, f64, &'static [[f64; 5]]);

const PRINTED: [Printed; 5] = [
    ("spring-mass", "n_per_m", 1.0, &[[1.0e-5, 0.20, 0.25, 2.0e4, 0.25]]),
    (
        "spring-mass-2dof",
        "n_per_m",
        1.0,
        &[[1.0e-5, 0.10, 0.15, 1.0e4, 0.5], [1.0e-5, 0.20, 0.30, 2.0e4, 0.5]],
    ),
    ("manipulator-1dof", "nm_per_rad", DEG, &[[5.7e-4, 0.96, 1.2, 1700.0, 0.25]]),
    (
        "manipulator-2dof",
        "nm_per_rad",
        DEG,
        &[[5.7e-5, 0.08, 0.10, 1400.0, 0.25], [5.7e-5, 0.06, 0.075, 1000.0, 0.25]],
    ),
    ("square-wave", "n_per_m", 1.0, &[[1.0e-4, 0.6, 0.8, 6000.0, 0.33]]),
];

/// One degree, rad.
const DEG: f64 = std::f64::consts::PI / 180.0;

/// The values are those of Tables 2, 5, 8, 11 and 15. The test lets 6 % pass on both sides of the
/// rules themselves.
#[test]
fn parameters_of_the_reset_integrator_are_taken_as_printed_and_not_farther_from_the_rules() {
    for (experiment, unit, of_table, bodies) in PRINTED {
        let column =
            |value: &dyn Fn(&[f64; 5]) -> f64| bodies.iter().map(value).collect::<Vec<_>>();
        let taken = |key: &str, values: &[f64]| {
            let mut document = Document::open(experiment).unwrap();
            let set = format!("friction.reset-integrator.{key}={values:?}");
            document.set(&["run.friction=[\"reset-integrator\"]".into(), set]).unwrap();
            lab::plan(&document).is_ok()
        };
        for (key, printed, rule) in [
            (
                format!("stiffness_{unit}"),
                column(&|[.., k, _]| k / of_table),
                column(&|[range, slip, ..]| slip / (range * of_table)),
            ),
            (
                "gradient".into(),
                column(&|[.., a]| *a),
                column(&|[_, slip, stick, ..]| (stick - slip) / slip),
            ),
        ] {
            assert!(taken(&key, &printed), "{experiment}: {key} = {printed:?} is refused");
            for (part, right) in [(0.939, false), (0.941, true), (1.059, true), (1.061, false)] {
                let values: Vec<f64> = rule.iter().map(|rule| part * rule).collect();
                assert_eq!(taken(&key, &values), right, "{experiment}: {key} = {values:?}");
            }
        }
    }
}

/// Eq. 4c is a guideline, and Tables 2 and 15 depart from it.
#[test]
fn the_damping_of_the_reset_integrator_is_free() {
    let set = "friction.reset-integrator.damping_n_s_per_m=[5.0]";
    let output = stiction(&["spring-mass", "--friction", "reset-integrator", "--set", set]);
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{set}");
}

fn stiction(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_stiction"))
        .arg("run")
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// The step is too long for the smooth friction, under which the block creeps from the start. The
/// block that sticks does not mind.
#[test]
fn a_run_that_is_given_up_takes_no_other_with_it() {
    let directory = tempfile::tempdir().unwrap();
    let csv = directory.path().join("run.csv");
    let arguments = [
        "spring-mass",
        "--solver",
        "nonsmooth",
        "--set",
        "run.friction=[\"karnopp\", \"tanh\"]",
        "--set",
        "friction.tanh.speed_m_per_s=[1.0]",
        "--set",
        "run.step_s=0.05",
        "--set",
        "run.duration_s=1.0",
        "--csv",
        csv.to_str().unwrap(),
        "--json",
    ];
    let output = stiction(&arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    // Beside the complaint it says only which file was written.
    let complaints = said.lines().filter(|line| !line.starts_with("wrote ")).count();
    assert_eq!((output.status.code(), complaints), (Some(1), 1), "{said}");
    for fragment in [
        "1 of 2 runs failed",
        "tanh/nonsmooth",
        "too long for the springs",
        " s, in the state q = [",
    ] {
        assert!(said.contains(fragment), "lacks {fragment}: {said}");
    }
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let labels: Vec<_> =
        json["runs"].as_array().unwrap().iter().map(|run| run["label"].clone()).collect();
    assert_eq!(labels, ["karnopp/nonsmooth"]);
    assert!(std::fs::read_to_string(&csv).unwrap().lines().count() > 20);
    // Of a run that stands alone nothing is left.
    let alone =
        stiction(&[&arguments[..4], &["run.friction=[\"tanh\"]"], &arguments[5..11]].concat());
    assert_eq!((alone.status.code(), alone.stdout.len()), (Some(1), 0));
    assert!(!String::from_utf8(alone.stderr).unwrap().contains("of 1"));
}

#[test]
fn the_table_lists_the_first_events_within_80_columns_and_says_how_many_more_there_are() {
    let output = stiction(&["spring-mass", "--friction", "karnopp", "--set", "run.duration_s=10"]);
    let table = String::from_utf8(output.stdout).unwrap();
    // In closed form the block breaks from 1.25 s on each 0.6073 s and sticks 0.1073 s later: 15 of
    // each in 10 s.
    for fragment in [
        "1.250000  1 break",
        "1.357304  1 stick",
        "5.501125  1 break",
        "and 15 more, --json has all",
    ] {
        assert!(table.contains(fragment), "lacks {fragment}:\n{table}");
    }
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    let short = stiction(&["spring-mass", "--friction", "karnopp", "--set", "run.duration_s=2"]);
    assert!(!String::from_utf8(short.stdout).unwrap().contains("more"));
}
