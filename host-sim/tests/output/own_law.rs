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
