//! What the command line answers to a friction experiment that cannot be: one sentence that names the key, what was
//! found and what is allowed; exit code 2; nothing on the standard output.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Stdio};

/// Why an answer is not as it should be.
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
        (set("mechanism.stiffness_n_per_m=[0.0]"), &["`mechanism.stiffness_n_per_m[0]` is 0", "above 0"]),
        (set("mechanism.stiffness_n_per_m=[-100]"), &["is -100", "above 0"]),
        (set("mechanism.length_m=[1.0]"), &["`mechanism.length_m` has no meaning", "spring-mass"]),
        (set("friction.stick_n=[0.1]"), &["`friction.stick_n[0]` is 0.1", "not below", "friction.slip_n"]),
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
        (set("run.friction=[\"dry\"]"), &["\"dry\"", "allowed are classical"]),
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
            vec!["spring-mass", "--friction", "karnopp-banded", "--solver", "rk4", "--coupling", "neglected"],
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
        (vec!["step-response", "--friction", "karnopp"], &["--friction karnopp", "friction experiments"]),
    ];
    let complaints: Vec<String> =
        cases.iter().filter_map(|(arguments, fragments)| complaint(arguments, fragments)).collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn the_json_of_a_friction_run_is_what_scripts_rely_on() {
    let run = |arguments: &[&str]| -> serde_json::Value {
        let output =
            Command::new(env!("CARGO_BIN_EXE_stiction")).arg("run").args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let json = run(&["spring-mass", "--friction", "karnopp", "--solver", "exact", "--json"]);
    assert_eq!((&json["schema"], &json["experiment"]), (&1.into(), &"spring-mass".into()));
    let [only] = &json["runs"].as_array().unwrap()[..] else { unreachable!() };
    assert_eq!(only["label"], "karnopp/exact");
    assert_eq!((&only["unstable"], &only["diverged_at_s"]), (&false.into(), &serde_json::Value::Null));
    let first = &only["events"][0];
    assert_eq!((&first["body"], &first["kind"]), (&1.into(), &"break".into()));
    assert!((first["time_s"].as_f64().unwrap() - 1.25).abs() < 1e-9);
    assert_eq!(only["metrics"]["breaks"], serde_json::json!([7]));
    // Closed form: V_o + sqrt(V_o^2 + ((F_s - F_d) / (m w))^2) with w = sqrt(K/m).
    let expected = 0.002 + (0.002_f64.powi(2) + (0.05 / 0.1_f64 / 1000_f64.sqrt()).powi(2)).sqrt();
    let fastest = only["metrics"]["max_speed"][0].as_f64().unwrap();
    assert!((fastest / expected - 1.0).abs() < 1e-6, "{fastest}, not {expected}");
    assert!((only["metrics"]["peak_friction"][0].as_f64().unwrap() - 0.25).abs() < 1e-9);
    assert!(only["cost"]["derivative_evaluations"].as_u64().unwrap() > 100);
    assert!(only["cost"]["wall_s"].as_f64().unwrap() > 0.0);
    let both = run(&["manipulator-2dof", "--json"]);
    let labels: Vec<_> = both["runs"].as_array().unwrap().iter().map(|run| run["label"].clone()).collect();
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
