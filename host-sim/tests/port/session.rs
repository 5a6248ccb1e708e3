//! A board is asked, moved, logged and configured, and its cable is pulled.

use crate::board::{Board, Manner};
use crate::program::{complaint, success};

#[test]
fn a_device_behind_a_port_is_asked_armed_moved_logged_and_configured() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (log, toml) = (file("move.csv"), file("joint.toml"));
    assert!(success(&board.device(&["status"])).contains("state      stopped"));
    let said = success(&board.device(&["move", "2.5", "--for", "3", "--log", &log]));
    assert!(said.contains("state      armed") && said.contains("the motor is off"), "{said}");
    let rows = std::fs::read_to_string(&log).unwrap();
    let last: Vec<&str> = rows.lines().last().unwrap().split(',').collect();
    let position: f64 = last[2].parse().unwrap();
    // SRNF rests within ten counts; the encoder says the same as the joint.
    assert!((position - 2.5).abs() < 0.03, "{position}");
    assert!(rows.lines().count() > 140, "{}", rows.lines().count());

    success(&board.device(&["params", "pull", &toml]));
    success(&board.device(&["params", "push", &toml, "--save"]));
    assert!(success(&board.device(&["arm", "--for", "0.1"])).contains("state      armed"));
    assert!(success(&board.device(&["stop"])).contains("state      stopped"));
    assert!(success(&board.device(&["faults"])).contains("no fault since power-on"));
}

#[test]
fn a_cable_that_is_pulled_while_armed_is_reported_with_the_reaction_of_the_board() {
    let board = Board::new(Manner::PulledWhileArmed(20));
    let said = complaint(&board.device(&["move", "2.5", "--for", "60"]));
    assert!(
        said.contains("the port is gone") && said.contains("an armed board turns the motor off"),
        "{said}"
    );
    assert!(said.contains("THE MOTOR MAY STILL BE DRIVEN: the stop was not confirmed"), "{said}");
}

/// Returns the rows of a log, each of which is whole.
fn whole_rows(log: &str) -> usize {
    let text = std::fs::read_to_string(log).unwrap();
    assert!(text.ends_with('\n'));
    let cells = text.lines().next().unwrap().split(',').count();
    assert!(text.lines().all(|line| line.split(',').count() == cells), "{text}");
    text.lines().count() - 1
}

#[test]
fn ctrl_c_in_a_log_keeps_what_was_logged() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("log.csv").to_str().unwrap().to_owned();
    let output = board.interrupted_after(30, &["log", &log, "--for", "86400"]);
    let [said, complaint] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8(bytes.clone()).unwrap());
    assert_eq!(output.status.code(), Some(130), "{complaint}");
    let rows = whole_rows(&log);
    assert!(rows >= 30, "{rows}");
    assert!(said.contains(&format!("{log}: {rows} samples")), "{said}");
    assert!(complaint.contains("log: ended by Ctrl-C; what was logged is kept"), "{complaint}");
}

#[test]
fn ctrl_c_in_a_move_turns_the_motor_off_and_keeps_its_log() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("move.csv").to_str().unwrap().to_owned();
    let output = board.interrupted_after(100, &["move", "2.5", "--for", "86400", "--log", &log]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{complaint}");
    assert!(whole_rows(&log) >= 10);
    assert!(complaint.contains("move: ended by Ctrl-C; the motor is off"), "{complaint}");
    // By a stop, and not because the link fell silent.
    let status = board.device(&["status", "--json"]);
    let status: serde_json::Value = serde_json::from_slice(&status.stdout).unwrap();
    assert_eq!((&status["state"], &status["fault"]), (&"stopped".into(), &serde_json::Value::Null));
}

#[test]
fn ctrl_c_in_an_identification_turns_the_motor_off() {
    let board = Board::new(Manner::Sound);
    let output = board.interrupted_after(30, &["identify"]);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{complaint}");
    assert!(complaint.contains("ended by Ctrl-C; the motor is off"), "{complaint}");
    let status = board.device(&["status", "--json"]);
    let status: serde_json::Value = serde_json::from_slice(&status.stdout).unwrap();
    assert_eq!(status["state"], "stopped");
}
