//! `stiction new` in a terminal of its own.

use std::fs::{self, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::process::Command;
use std::time::Duration;

use serialport::SerialPort;

use crate::program::{SPAWNING, pseudoterminal};

/// Answers each prompt, once it is seen, with the keys beside it; all others with Enter.
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
        turns += 1;
        if turns == 300 {
            // The program does not end, and this test shall.
            child.kill().unwrap();
        }
        let count = master.read(&mut bytes).unwrap_or(0);
        screen += &String::from_utf8_lossy(&bytes[..count]);
        // It is the program's turn as long as it says something.
        if count > 0 || screen.len() == seen {
            continue;
        }
        let asks = |(prompt, _): &(&str, &str)| screen[seen..].contains(prompt);
        let keys = match open.iter().position(asks) {
            Some(place) => open.remove(place).1,
            None => "\r",
        };
        seen = screen.len();
        master.write_all(keys.as_bytes()).unwrap();
    }
    while let Ok(count @ 1..) = master.read(&mut bytes) {
        screen += &String::from_utf8_lossy(&bytes[..count]);
    }
    assert!(turns < 300 && open.is_empty(), "{open:?}: {screen}");
    (screen, child.wait().unwrap().code())
}

#[test]
fn a_dozen_answers_on_a_terminal_make_a_file_and_a_wrong_one_is_asked_again() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("joint.toml");
    // The second joint of the list; a load of its own, at the second try; the ratio by an option.
    let answers = [
        ("most like yours", "\x1b[B\r"),
        ("(load.inertia_kg_m2)", "heavy\r"),
        ("allowed is a number", "\x15\x08\x08\x08\x08\x080.01\r"),
    ];
    let (screen, code) = asked(&[path.to_str().unwrap(), "--ratio", "60"], &answers);
    assert_eq!(code, Some(0), "{screen}");
    assert!(!screen.contains("(gear.ratio)") && screen.contains("(encoder.lines)"), "{screen}");
    let text = fs::read_to_string(&path).unwrap();
    for line in ["ratio = 60.0 ", "inertia_kg_m2 = 0.01 ", "resistance_ohm = 2.18 "] {
        assert!(text.contains(line), "{line}: {text}");
    }
}
