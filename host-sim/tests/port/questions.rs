//! `stiction new` in a terminal of its own.

use std::fs::{self, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::process::Command;
use std::time::Duration;

use serialport::SerialPort;

use crate::program::{SPAWNING, pseudoterminal};

/// Presses, at each prompt of the list and in its order, the keys beside it; at all others Enter.
fn asked(arguments: &[&str], answers: &[(&str, &str)]) -> (String, Option<i32>) {
    let spawning = SPAWNING.lock().unwrap();
    let (mut master, slave) = pseudoterminal(&spawning);
    let path = slave.name().unwrap();
    let terminal = || {
        let flags = nix::fcntl::OFlag::O_NOCTTY.bits();
        OpenOptions::new().read(true).write(true).custom_flags(flags).open(&path).unwrap()
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.arg("new").args(arguments).env("TERM", "xterm");
    let mut child =
        command.stdin(terminal()).stdout(terminal()).stderr(terminal()).spawn().unwrap();
    drop(spawning);
    master.set_timeout(Duration::from_millis(100)).unwrap();
    let (mut screen, mut seen, mut bytes, mut turns) = (String::new(), 0, [0; 4096], 0);
    let mut open: Vec<_> = answers.to_vec();
    while child.try_wait().unwrap().is_none() {
        let count = master.read(&mut bytes).unwrap_or(0);
        // Reads without a byte; a screen comes in many reads.
        turns += u32::from(count == 0);
        if turns == 300 {
            // The program does not end, and this test shall.
            child.kill().unwrap();
        }
        screen += &String::from_utf8_lossy(&bytes[..count]);
        // It is the program's turn as long as it says something.
        if count > 0 || screen.len() == seen {
            continue;
        }
        let asks = |(prompt, _): &&(&str, &str)| screen[seen..].contains(prompt);
        let is_next = open.first().filter(asks).is_some();
        let keys = if is_next { open.remove(0).1 } else { "\r" };
        seen = screen.len();
        master.write_all(keys.as_bytes()).unwrap();
    }
    while let Ok(count @ 1..) = master.read(&mut bytes) {
        screen += &String::from_utf8_lossy(&bytes[..count]);
    }
    assert!(turns < 300 && open.is_empty(), "{open:?}: {screen}");
    (screen, child.wait().unwrap().code())
}

/// What shows the cursor, and what hides it.
const CURSOR: [&str; 2] = ["\x1b[?25h", "\x1b[?25l"];

#[test]
fn answers_on_a_terminal_make_a_file_and_a_wrong_one_is_refused_at_once() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("pan.toml");
    // The second joint of the list; a load of its own, at the second try; the ratio by an option.
    let answers = [
        ("most like yours", "\x1b[B\r"),
        ("Inertia of the load", "heavy\r"),
        ("is not a number", "\x7f\x7f\x7f\x7f\x7f0.01\r"),
        ("Static friction", "0.1..0.2\r"),
    ];
    let (screen, code) = asked(&[path.to_str().unwrap(), "--ratio", "60"], &answers);
    assert_eq!(code, Some(0), "{screen}");
    assert!(!screen.contains("Turns of the motor") && screen.contains("Lines of"), "{screen}");
    assert!(!screen.contains("--typical") && !screen.contains("--stick"), "{screen}");
    let text = fs::read_to_string(&path).unwrap();
    for line in [
        "title = \"pan\"",
        "ratio = 60.0 ",
        "inertia_kg_m2 = 0.01 ",
        "resistance_ohm = 2.18 ",
        "stick_nm = 0.1414 ",
        "\"friction.stick_nm\" = [0.1, 0.2]",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

#[test]
fn escape_goes_back_and_ctrl_c_writes_nothing_and_shows_the_cursor() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("pan.toml");
    let answers = [
        ("most like yours", "\x1b[B\r"),
        ("Voltage of the supply", "24\r"),
        ("Resistance of the winding", "\x1b"),
        // What was answered is proposed.
        ("(24)", "\r"),
        ("Where the encoder sits", "\x03"),
    ];
    let (screen, code) = asked(&[path.to_str().unwrap()], &answers);
    assert_eq!(code, Some(130), "{screen}");
    let [shown, hidden] = CURSOR.map(|sequence| screen.rfind(sequence));
    assert!(shown > hidden, "the cursor is left hidden: {screen:?}");
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
