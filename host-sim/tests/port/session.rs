//! A board is asked, moved, logged and configured, and its cable is pulled.

use crate::board::{Board, Manner};
use crate::program::{complaint, told};

#[test]
fn a_device_behind_a_port_is_asked_armed_moved_logged_and_configured() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (log, toml) = (file("move.csv"), file("joint.toml"));
    assert!(told(&board.device(&["status"])).contains("state      stopped"));
    let said = told(&board.device(&["move", "2.5", "--for", "3", "--log", &log]));
    assert!(said.contains("state      armed") && said.contains("the motor is off"), "{said}");
    let rows = std::fs::read_to_string(&log).unwrap();
    let last: Vec<&str> = rows.lines().last().unwrap().split(',').collect();
    let position: f64 = last[2].parse().unwrap();
    // SRNF rests within ten counts; the encoder says the same as the joint.
    assert!((position - 2.5).abs() < 0.03, "{position}");
    assert!(rows.lines().count() > 140, "{}", rows.lines().count());

    told(&board.device(&["params", "pull", &toml]));
    told(&board.device(&["params", "push", &toml, "--save"]));
    assert!(told(&board.device(&["arm", "--for", "0.1"])).contains("state      armed"));
    assert!(told(&board.device(&["stop"])).contains("state      stopped"));
    assert!(told(&board.device(&["faults"])).contains("no fault since power-on"));
}

#[test]
fn a_cable_that_is_pulled_while_armed_is_told_with_what_the_board_does() {
    let board = Board::new(Manner::PulledWhileArmed(20));
    let said = complaint(&board.device(&["move", "2.5", "--for", "60"]));
    assert!(
        said.contains("it is gone") && said.contains("turns the motor off by itself"),
        "{said}"
    );
    assert!(said.contains("THE MOTOR MAY STILL BE DRIVEN: the stop was not confirmed"), "{said}");
}
