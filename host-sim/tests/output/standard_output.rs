//! `-` as the path of an output is the standard output; the text for a person goes to the standard
//! error then.

use std::fs;
use std::process::{Command, Output};

/// Runs a command that succeeds.
fn output(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    output
}

#[test]
fn a_dash_writes_to_the_standard_output_what_a_file_would_hold() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("written.toml");
    let path = path.to_str().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let [joint, log, rows] = ["joint.toml", "log.csv", "rows.csv"].map(file);
    output(&["new", &joint, "--typical", "thesis"]);
    output(&[
        "run",
        &joint,
        "--controller",
        "srnf",
        "--set",
        "reference.steps_deg=[]",
        "--csv",
        &log,
    ]);
    let ensemble = ["ensemble", "--plant", "rigid", "--cases", "1", "--controller", "pd", "--csv"];
    output(&[&ensemble[..], &[&rows]].concat());
    let columns = ["--time", "time_s", "--position", "position_deg", "--effort", "v_applied_v"];
    let identify =
        [&["identify", &log][..], &columns, &["--effort-gain", "540", "--into"]].concat();
    for (arguments, said) in [
        (&ensemble[..], "rigid: 1 joints"),
        (&["ensemble", "merge", &rows, "--csv"], "rigid: 1 joints"),
        (&identify, "verdict"),
        (&["tune", &joint, "--controller", "srnf", "--cases", "1", "--out"], "srnf: "),
        (&["run", "step-response", "--controller", "pd", "--csv"], "pd/step-5.0"),
        (&["run", "spring-mass", "--friction", "karnopp", "--csv"], "karnopp/exact"),
        (&["params", "step-response", "--out"], "probe-rs download"),
        (&["new", "--typical", "thesis", "--title", "An axis"], "stiction run FILE.toml"),
        (&["device", "--simulated", "log", "--for", "0.1"], "samples"),
        (&["device", "--simulated", "move", "1", "--for", "0.1", "--log"], "SIMULATED DEVICE"),
        (&["device", "--simulated", "params", "pull"], "bytes"),
    ] {
        let to_file = output(&[arguments, &[path, "--force"]].concat());
        let written = fs::read(path).unwrap();
        fs::remove_file(path).unwrap();
        let to_dash = output(&[arguments, &["-"]].concat());
        assert!(to_dash.stdout == written, "{arguments:?}: another content");
        let text = String::from_utf8(to_dash.stderr).unwrap();
        assert!(text.contains(said), "{arguments:?}: {text}");
        assert!(!to_file.stdout.is_empty(), "{arguments:?}: nothing for a person");
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 3);
}
