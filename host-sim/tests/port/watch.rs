//! `stiction device watch` in a terminal of its own.

use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::process::Command;
use std::time::Duration;

use serialport::SerialPort;

use crate::board::{Board, Manner};
use crate::program::{SPAWNING, pseudoterminal, success};

/// Runs the view in a terminal of its own, types into it, and ends it once it shows what it should.
/// Returns what was on the screen, and how the terminal was left.
fn watched(board: &Board, typed: &[u8], seen: &str, end: impl Fn(u32)) -> (String, String) {
    let spawning = SPAWNING.lock().unwrap();
    let (mut master, slave) = pseudoterminal(&spawning);
    let path = slave.name().unwrap();
    let stty = |arguments: &[&str]| {
        let output = Command::new("stty").arg("-F").arg(&path).args(arguments).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    stty(&["sane", "rows", "24", "cols", "100"]);
    let terminal = || {
        let flags = nix::fcntl::OFlag::O_NOCTTY.bits();
        OpenOptions::new().read(true).write(true).custom_flags(flags).open(&path).unwrap()
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(["device", "--port", &board.path, "watch"]).env("TERM", "xterm");
    let mut child =
        command.stdin(terminal()).stdout(terminal()).stderr(terminal()).spawn().unwrap();
    drop(spawning);
    master.set_timeout(Duration::from_millis(20)).unwrap();
    let (mut screen, mut bytes, mut step) = (Vec::new(), [0; 4096], 0);
    let mut turns = 0;
    while child.try_wait().unwrap().is_none() {
        turns += 1;
        if turns == 5000 {
            // The view does not end, and this test shall.
            child.kill().unwrap();
        }
        let count = master.read(&mut bytes).unwrap_or(0);
        screen.extend_from_slice(&bytes[..count]);
        let text = String::from_utf8_lossy(&screen);
        if step == 0 && text.contains("q quit") {
            assert!(stty(&["-a"]).contains("-icanon"));
            master.write_all(typed).unwrap();
            step = 1;
        } else if step == 1 && text.contains(seen) {
            end(child.id());
            step = 2;
        }
    }
    while let Ok(count @ 1..) = master.read(&mut bytes) {
        screen.extend_from_slice(&bytes[..count]);
    }
    let screen = String::from_utf8_lossy(&screen).into_owned();
    assert!(step == 2 && turns < 5000, "{step}: {screen}");
    (screen, stty(&["-a"]))
}

#[test]
fn a_view_that_is_ended_by_a_signal_stops_what_it_armed_and_gives_the_terminal_back() {
    for signal in ["-TERM", "-HUP", "-INT"] {
        let board = Board::new(Manner::Sound);
        let (screen, terminal) = watched(&board, b"a", "ARMED", |id| {
            assert!(
                Command::new("kill").args([signal, &id.to_string()]).status().unwrap().success()
            );
        });
        assert!(screen.contains("left stopped: the motor is off"), "{signal}: {screen}");
        assert!(
            screen.contains("\x1b[?1049l") && terminal.contains(" icanon"),
            "{signal}: {terminal}"
        );
        assert!(success(&board.device(&["status"])).contains("state      stopped"), "{signal}");
    }
}
