//! A port may be none, a device may be of another kind, and a request may be refused.

use std::process::Command;
use stiction::link::PROTOCOL;

use crate::board::{Board, Manner};
use crate::program::{complaint, device, output, success};

#[test]
fn a_move_that_cannot_be_leaves_the_drive_stopped() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("joint.toml");
    let text = simulator::experiment::find("step-response").unwrap().toml;
    std::fs::write(
        &path,
        format!("{text}\n[limits]\nposition_max_deg = 90.0\nlink_timeout_s = 60.0\n"),
    )
    .unwrap();
    success(&board.device(&["params", "push", path.to_str().unwrap()]));
    for (deg, fragment, left) in [
        ("400", "the range is 0 to 90 deg from the reference", "; the motor is off"),
        ("1e9", "move 1000000000: the position must be within 2^30 counts", ""),
        ("nan", "`nan` is not a number", ""),
    ] {
        let output = board.device(&["move", deg]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{deg}: {said}");
        assert!(said.contains(fragment) && said.trim_end().ends_with(left), "{deg}: {said}");
        let said = success(&board.device(&["status"]));
        assert!(
            said.contains("state      stopped") && said.contains("faults     0 since"),
            "{deg}: {said}"
        );
    }
}

#[test]
fn other_devices_on_a_port_are_distinguished() {
    let later = format!("firmware 9.8.7 with version {} of the link", PROTOCOL + 1);
    let ours = format!("version {PROTOCOL}");
    for (manner, fragments) in [
        (Manner::Silent, &["does not answer: check its power"][..]),
        (Manner::Banner, &["no message of the link (\"ok T:21.3 /0.0\\r\\n", "other firmware"]),
        (Manner::Garbage, &["no message of the link", "another baud rate"]),
        (Manner::Later, &[&later, &ours, "xtask flash"]),
    ] {
        let board = Board::new(manner);
        let said = complaint(&board.device(&["status"]));
        for fragment in fragments {
            assert!(said.contains(fragment), "{said}");
        }
    }
}

#[test]
fn a_port_that_is_missing_busy_or_none_is_reported() {
    let said = complaint(&device(&["--port", "/dev/does-not-exist", "status"]));
    assert!(said.contains("there is no such port; available ports:"), "{said}");
    let said = complaint(&device(&["--port", "/dev/null", "status"]));
    assert!(said.contains("it cannot be used as a serial port"), "{said}");
    let board = Board::new(Manner::Sound);
    let other = serialport::new(board.path.as_str(), 921_600).open().unwrap();
    assert!(complaint(&board.device(&["status"])).contains("another program has it open"));
    drop(other);
    success(&board.device(&["status"]));
}

#[test]
fn a_refusal_of_the_device_or_of_the_file_is_reported() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("joint.toml");
    let with = |from: &str, to: &str| {
        let text = simulator::experiment::find("step-response").unwrap().toml.replace(from, to);
        std::fs::write(&path, text).unwrap();
        let output = board.device(&["params", "push", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let said = with("kp_v_per_deg = 1.0", "kp_v_per_dge = 1.0");
    assert!(
        said.contains("joint.toml: unknown key") && said.contains("did you mean `kp_v_per_deg`?"),
        "{said}"
    );
    let said = with("sample_time_s = 0.02", "sample_time_s = 0.05");
    assert!(
        said.contains("`loop.sample_time_s` is 0.05; must be a number from 0.0001 to 0.02"),
        "{said}"
    );
    // The device itself refuses this ramp.
    let said = complaint(&board.device(&["identify", "--rate", "100"]));
    assert!(
        said.contains(
            "refuses: `identification.ramp_rates_v_per_s` is 100; must be a number from 0 to 10"
        ),
        "{said}"
    );
}

#[test]
fn what_was_edited_meanwhile_is_kept_if_the_device_refuses_it() {
    let directory = tempfile::tempdir().unwrap();
    let board = Board::new(Manner::ArmedBy(directory.path().join("arm")));
    let wait = "cd $AT; touch arm; while [ ! -e armed ]; do sleep 0.05; done";
    let editor = format!("sh -c '{wait}; sed -i s/kp_v_per_deg.*/kp_v_per_deg=2/ $0'");
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command
        .args(["device", "--port", &board.path, "params", "edit"])
        .env_remove("VISUAL")
        .env("EDITOR", editor);
    let said =
        complaint(&output(command.env("AT", directory.path()).env("TMPDIR", directory.path())));
    assert!(said.contains("refuses: the motor is driven; `stop` first"), "{said}");
    let (before, file) = said.rsplit_once(", and the text is kept in ").unwrap();
    assert!(before.ends_with("; the old parameters are in use"), "{said}");
    assert!(std::fs::read_to_string(file).unwrap().contains("kp_v_per_deg=2"), "{said}");
}
