//! The built-in experiments: `list` and `show`.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use serde_json::{Value, json};

use super::{keys, run, runs, stiction};

#[test]
fn list_names_every_experiment_with_its_source() {
    let listing: Value = serde_json::from_str(&stiction(&["list", "--json"])).unwrap();
    assert_eq!(
        (keys(&listing), &listing["schema"]),
        (BTreeSet::from(["experiments", "schema"]), &json!(1))
    );
    let entries = listing["experiments"].as_array().unwrap();
    let names: Vec<&str> = entries.iter().map(|entry| entry["name"].as_str().unwrap()).collect();
    let expected = "spring-mass spring-mass-2dof manipulator-1dof manipulator-2dof square-wave \
                    triangle-wave \
                    spring-mass-revisited step-response trajectory step-added-friction \
                    srnf-robustness \
                    srnf-added-friction high-gain friction-identification spring-mass-independent \
                    untuned-joints";
    assert_eq!(names, expected.split(' ').collect::<Vec<_>>());
    let table = stiction(&["list"]);
    for entry in entries {
        assert_eq!(keys(entry), BTreeSet::from(["name", "source", "title"]), "{entry}");
        let [name, source, title] =
            ["name", "source", "title"].map(|key| entry[key].as_str().unwrap());
        assert!(
            ["Table ", "Tables ", "Section ", "Beyond the thesis"]
                .iter()
                .any(|kind| source.starts_with(kind)),
            "{entry}"
        );
        let line = table.lines().position(|line| line.starts_with(name) && line.ends_with(source));
        assert!(
            line.is_some_and(|i| table.lines().nth(i + 1).unwrap().trim() == title),
            "{name}:\n{table}"
        );
    }
}

#[test]
fn a_shown_experiment_saved_as_a_file_runs_the_same() {
    let directory = tempfile::tempdir().unwrap();
    // The file has the name of a built-in experiment, for which it must not be taken.
    let path = directory.path().join("trajectory");
    for experiment in
        ["step-response", "high-gain", "srnf-added-friction", "friction-identification"]
    {
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
    assert_eq!(
        (&report["experiment"], &report["source"]),
        (&json!("trajectory"), &json!("Table 17"))
    );
}
