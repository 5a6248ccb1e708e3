//! `stiction device` on the built program: what a simulated device does, that it says what it is, and what is answered to
//! what cannot be done. Blind to real ports.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

fn device(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stiction")).arg("device").args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const SAYS_SO: &str = "SIMULATED DEVICE: no motor moves or stops.";

#[test]
fn every_output_of_a_simulated_device_says_so_first() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (log, record) = (file("log.csv"), file("device.params"));
    let actions: [&[&str]; 9] = [
        &["status"],
        &["stop"],
        &["arm", "--for", "0.2"],
        &["move", "1", "--for", "1"],
        &["faults"],
        &["log", &log, "--for", "1"],
        &["params", "show"],
        &["params", "push", "step-response", "--controller", "pd", "--save"],
        &["params", "pull", &record],
    ];
    for action in actions {
        let output = device(&[&["--simulated"], action].concat());
        let said = text(&output.stdout);
        assert!(output.status.success(), "{action:?}: {}", text(&output.stderr));
        assert!(said.starts_with(SAYS_SO), "{action:?}: {said}");
        assert!(said.lines().all(|line| line.chars().count() <= 80), "{action:?}: {said}");
        assert!(text(&output.stderr).starts_with(SAYS_SO), "{action:?}");
    }
    // And where it goes wrong, too.
    let output = device(&["--simulated", "move", "1e300"]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()));
    assert!(text(&output.stderr).starts_with(SAYS_SO));
}

#[test]
fn a_move_arrives_and_its_log_has_the_columns_of_a_run() {
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("move.csv");
    let output = device(&["--simulated", "move", "-2.5", "--for", "3", "--log", log.to_str().unwrap()]);
    let said = text(&output.stdout);
    assert!(said.contains("state      armed") && said.contains("the output is off"), "{said}");
    let mut reader = csv::Reader::from_path(&log).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let run = [
        "time_s",
        "reference_deg",
        "position_deg",
        "error_deg",
        "velocity_deg_per_s",
        "v_pd_v",
        "v_c_v",
        "v_v",
        "code",
        "stuck",
    ];
    assert_eq!(header, run);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    // 3 s of 20 ms, and the ticks in which the last answer was waited for.
    assert!((149..=153).contains(&rows.len()), "{}", rows.len());
    let position: f64 = rows[rows.len() - 1][2].parse().unwrap();
    assert!((position + 2.5).abs() < 0.03, "{position}");
}

#[test]
fn what_cannot_be_done_is_one_sentence_and_exit_code_2() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["status"], &["exactly one of --port DEV, --emulator and --simulated"]),
        (&["--simulated", "--port", "/dev/null", "status"], &["exactly one of"]),
        (&["--simulated", "--image", "x.elf", "status"], &["--image needs --emulator"]),
        (&["--port", "/dev/does-not-exist", "status"], &["--port /dev/does-not-exist", "no such port"]),
        (&["--simulated", "--machine", "nope", "status"], &["nope"]),
        (&["--simulated", "--controller", "srn", "status"], &["`srn`", "did you mean `srnf`?"]),
        (&["--simulated", "move", "nan"], &["allowed is a position within 2^30 counts"]),
        (&["--simulated", "arm", "--for", "-1"], &["--for -1", "0 to 86400"]),
    ];
    for (arguments, fragments) in cases {
        let output = device(arguments);
        let said = text(&output.stderr).replace(&format!("{SAYS_SO}\n"), "");
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()), "{arguments:?}");
        assert_eq!(said.trim_end().lines().count(), 1, "{arguments:?}: {said}");
        for fragment in *fragments {
            assert!(said.contains(fragment), "{arguments:?}: {said}");
        }
    }
}

#[cfg(not(feature = "emulator"))]
#[test]
fn a_build_without_the_emulator_says_how_to_build_one_with_it() {
    let output = device(&["--emulator", "status"]);
    let said = text(&output.stderr);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()));
    assert!(said.contains("device --emulator") && said.contains("--features emulator"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}
