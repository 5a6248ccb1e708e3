use std::process::Command;

use super::stiction;
use serde_json::Value;

/// Compiles the example law.
fn example(directory: &std::path::Path) -> String {
    let sources = concat!(env!("CARGO_MANIFEST_DIR"), "/shared-law");
    let library = directory.join("law.so");
    let made = Command::new("cc")
        .args(["-O2", "-shared", "-fPIC", "-I", sources])
        .arg(format!("{sources}/example/pd_with_friction.c"))
        .args(["-lm", "-o"])
        .arg(&library)
        .status()
        .unwrap();
    assert!(made.success());
    library.to_str().unwrap().to_owned()
}

#[test]
fn a_law_of_one_s_own_is_in_the_table_of_the_built_in_laws() {
    let directory = tempfile::tempdir().unwrap();
    let law = example(directory.path());
    let run = ["ensemble", "--plant", "rigid", "--cases", "4", "--controller", "pd", "--law", &law];
    let json = stiction(&[&run[..], &["--json"]].concat());
    let report: Value = serde_json::from_str(&json).unwrap();
    let laws = report["families"]["rigid"].as_object().unwrap();
    assert!(laws.contains_key("pd") && laws["pd-with-friction"]["cases"] == 4, "{laws:?}");
    // `--resume` prints no name of a file.
    let rows = directory.path().join("rows.csv");
    stiction(&[&run[..], &["--resume", rows.to_str().unwrap()]].concat());
    let text = std::fs::read_to_string(rows).unwrap();
    assert!(text.lines().next().unwrap().contains("\"guests\":{\"pd-with-friction\":\"1\"}"));
    assert_eq!(text.lines().filter(|line| line.contains("pd-with-friction,")).count(), 4);
}

#[test]
fn a_law_of_one_s_own_runs_and_is_ranked_on_a_machine_s_file() {
    let directory = tempfile::tempdir().unwrap();
    let law = example(directory.path());
    let run = ["run", "step-response", "--controller", "pd", "--law", &law, "--json"];
    let report: Value = serde_json::from_str(&stiction(&run)).unwrap();
    let runs = report["runs"].as_array().unwrap();
    let of = |name: &str| {
        let label = format!("{name}/step-2.5");
        runs.iter().find(|run| run["label"] == label.as_str()).unwrap()
    };
    // Its compensation of friction brings it nearer than PD; both leave the start.
    let rest = |name: &str| of(name)["metrics"]["rest_error_counts"].as_f64().unwrap().abs();
    assert!(rest("pd-with-friction") < 0.5 * rest("pd"), "{}", rest("pd-with-friction"));
    let ranked = ["benchmark", "--law", &law, "--json"];
    let report: Value = serde_json::from_str(&stiction(&ranked)).unwrap();
    let names: Vec<_> = report["controllers"].as_array().unwrap().iter().collect();
    assert!(names.iter().any(|row| row["controller"] == "pd-with-friction"), "{names:?}");
    let file = directory.path().join("step-response.toml");
    std::fs::write(&file, stiction(&["show", "step-response"])).unwrap();
    let rows = directory.path().join("rows.csv");
    let around = ["ensemble", "--plant", file.to_str().unwrap(), "--cases", "1", "--law", &law];
    let pd = ["--controller", "pd", "--resume", rows.to_str().unwrap()];
    stiction(&[&around[..], &pd].concat());
    let text = std::fs::read_to_string(rows).unwrap();
    let header = text.lines().next().unwrap();
    assert!(header.contains("\"laws\":[\"pd\",\"pd-with-friction\"]"), "{header}");
    assert!(header.contains("\"guests\":{\"pd-with-friction\":\"1\"}"), "{header}");
}
