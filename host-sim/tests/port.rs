//! `stiction device --port` on the built program, at one end of a pseudoterminal. At the other end is a thread with the
//! core of the firmware around the simulated joint, or something that should not be there. Blind to real ports: their
//! baud rate, their drivers, their cables.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use host_sim::device::simulated::SimulatedDevice;
use host_sim::experiment::{Document, Experiment};
use nix::fcntl::{FcntlArg, FdFlag, fcntl};
use serialport::{SerialPort, TTYPort};
use stiction::Course;
use stiction::link::{Identity, Kind, Message, Numbered, PROTOCOL, Reply, encode};
use stiction::servo::State;

/// Held while a pseudoterminal is made, and while a program is started.
static SPAWNING: Mutex<()> = Mutex::new(());

#[derive(Clone, PartialEq, Eq)]
enum Manner {
    /// As it should be.
    Sound,
    /// The cable is pulled after so many ticks armed.
    PulledWhileArmed(u32),
    /// It speaks a later version of the protocol.
    Later,
    /// Another firmware that talks to people.
    Banner,
    /// Another baud rate, say.
    Garbage,
    /// Nothing.
    Silent,
    /// It is armed by somebody else as soon as a file of this name is there, and says so by one called `armed` beside it.
    ArmedBy(PathBuf),
}

struct Board {
    path: String,
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Kept open, so that the other end does not hang up between two programs.
    _slave: TTYPort,
}

impl Board {
    fn new(manner: Manner) -> Self {
        // A program that inherits the other end keeps it open.
        let spawning = SPAWNING.lock().unwrap();
        let (master, slave) = TTYPort::pair().unwrap();
        for fd in [master.as_raw_fd(), slave.as_raw_fd()] {
            fcntl(fd, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).unwrap();
        }
        drop(spawning);
        let path = slave.name().unwrap();
        let done = Arc::new(AtomicBool::new(false));
        let ends = done.clone();
        let thread = Some(std::thread::spawn(move || run(manner, master, &ends)));
        Self { path, done, thread, _slave: slave }
    }

    fn device(&self, arguments: &[&str]) -> Output {
        device(&[&["--port", &self.path], arguments].concat())
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        self.thread.take().map(JoinHandle::join).unwrap().unwrap();
    }
}

/// A device that has as much time as it needs on a busy machine: a tick for every turn of the loop, and a client that may
/// be silent for long.
fn simulated() -> SimulatedDevice {
    let mut document = Document::open("step-response").unwrap();
    document.set(&["limits.link_timeout_s=60".into()]).unwrap();
    let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(10);
    simulated
}

fn run(manner: Manner, mut master: TTYPort, done: &AtomicBool) {
    master.set_timeout(Duration::from_millis(1)).unwrap();
    let (mut simulated, mut armed) = (simulated(), 0);
    let (mut bytes, mut turn) = ([0; 512], 0u32);
    while !done.load(Ordering::Relaxed) {
        let count = master.read(&mut bytes).unwrap_or(0);
        turn = turn.wrapping_add(1);
        if let Manner::ArmedBy(file) = &manner
            && file.exists()
            && simulated.device.servo().arm_for_link(None).is_ok()
        {
            std::fs::rename(file, file.with_file_name("armed")).unwrap();
        }
        let said: Vec<u8> = match manner {
            Manner::Sound | Manner::PulledWhileArmed(_) | Manner::ArmedBy(_) => {
                simulated.device.receive(&bytes[..count]);
                armed += u32::from(simulated.tick().state == State::Armed);
                if matches!(manner, Manner::PulledWhileArmed(ticks) if armed > ticks) {
                    return;
                }
                let count = simulated.device.transmit(&mut bytes);
                bytes[..count].to_vec()
            }
            Manner::Later if count > 0 => {
                let identity = Identity {
                    protocol: PROTOCOL + 1,
                    kind: Kind::Board,
                    version: "9.8.7".try_into().unwrap(),
                };
                let reply = Numbered { number: 1, content: Reply::Hello(identity) };
                encode(&Message::Reply(reply)).unwrap().to_vec()
            }
            Manner::Banner if turn.is_multiple_of(20) => b"ok T:21.3 /0.0\r\n".to_vec(),
            Manner::Garbage if turn.is_multiple_of(5) => {
                (0..40).map(|i| (turn.wrapping_mul(2_654_435_761) >> (i % 24)) as u8).collect()
            }
            _ => continue,
        };
        let _ = master.write_all(&said);
    }
}

fn device(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    output(command.arg("device").args(arguments))
}

fn output(command: &mut Command) -> Output {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let spawning = SPAWNING.lock().unwrap();
    let child = command.spawn().unwrap();
    drop(spawning);
    child.wait_with_output().unwrap()
}

/// It went well: what was said, which begins with the warning that the device at the other end asks for.
fn told(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.starts_with("SIMULATED DEVICE: no motor moves or stops."), "{said}");
    said
}

/// It did not: one sentence, exit code 2, and where to read on.
fn complaint(output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    let sentence = said.lines().filter(|line| !line.starts_with("SIMULATED DEVICE")).collect::<Vec<_>>();
    assert_eq!((output.status.code(), sentence.len()), (Some(2), 1), "{said}");
    assert!(output.stdout.is_empty() && said.contains("docs/"), "{said}");
    sentence[0].into()
}

#[test]
fn a_device_behind_a_port_is_asked_armed_moved_logged_and_configured() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (log, toml) = (file("move.csv"), file("joint.toml"));
    assert!(told(&board.device(&["status"])).contains("state      stopped"));
    let said = told(&board.device(&["move", "2.5", "--for", "3", "--log", &log]));
    assert!(said.contains("state      armed") && said.contains("the output is off"), "{said}");
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
    assert!(said.contains("it is gone") && said.contains("turns its output off by itself"), "{said}");
    assert!(said.ends_with("it may be STILL ARMED: no stop was answered"), "{said}");
}

#[test]
fn a_move_that_cannot_be_leaves_the_drive_stopped() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("joint.toml");
    let text = host_sim::experiment::find("step-response").unwrap().toml;
    std::fs::write(&path, format!("{text}\n[limits]\nposition_max_deg = 90.0\nlink_timeout_s = 60.0\n"))
        .unwrap();
    told(&board.device(&["params", "push", path.to_str().unwrap()]));
    for (deg, fragment, left) in [
        ("400", "leads out of `limits.position_min_deg`", "; the output is off"),
        ("1e9", "move 1000000000: allowed is a position within 2^30 counts", ""),
        ("nan", "move NaN: allowed is a position within 2^30 counts", ""),
    ] {
        let output = board.device(&["move", deg]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{deg}: {said}");
        assert!(said.contains(fragment) && said.trim_end().ends_with(left), "{deg}: {said}");
        let said = told(&board.device(&["status"]));
        assert!(said.contains("state      stopped") && said.contains("faults     0 since"), "{deg}: {said}");
    }
}

/// The view in a terminal of its own; what is typed, and what ends it. Returns what was on the screen, and how the
/// terminal was left.
fn watched(board: &Board, typed: &[u8], seen: &str, end: impl Fn(u32)) -> (String, String) {
    let spawning = SPAWNING.lock().unwrap();
    let (mut master, slave) = TTYPort::pair().unwrap();
    for fd in [master.as_raw_fd(), slave.as_raw_fd()] {
        fcntl(fd, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).unwrap();
    }
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
    let mut child = command.stdin(terminal()).stdout(terminal()).stderr(terminal()).spawn().unwrap();
    drop(spawning);
    master.set_timeout(Duration::from_millis(20)).unwrap();
    let (mut screen, mut bytes, mut step) = (Vec::new(), [0; 4096], 0);
    let mut turns = 0;
    while child.try_wait().unwrap().is_none() {
        turns += 1;
        if turns == 5000 {
            // It does not end, and this test shall.
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
            assert!(Command::new("kill").args([signal, &id.to_string()]).status().unwrap().success());
        });
        assert!(screen.contains("left stopped: the output is off"), "{signal}: {screen}");
        assert!(screen.contains("\x1b[?1049l") && terminal.contains(" icanon"), "{signal}: {terminal}");
        assert!(told(&board.device(&["status"])).contains("state      stopped"), "{signal}");
    }
}

#[test]
fn what_is_no_device_of_ours_is_told_apart() {
    for (manner, fragments) in [
        (Manner::Silent, &["does not answer: is it powered"][..]),
        (Manner::Banner, &["no message of the link (\"ok T:21.3 /0.0\\r\\n", "other firmware"]),
        (Manner::Garbage, &["no message of the link", "another baud rate"]),
        (Manner::Later, &["firmware 9.8.7 with version 3 of the link", "version 2", "xtask flash"]),
    ] {
        let board = Board::new(manner);
        let said = complaint(&board.device(&["status"]));
        for fragment in fragments {
            assert!(said.contains(fragment), "{said}");
        }
    }
}

#[test]
fn a_port_that_is_missing_busy_or_none_is_told() {
    let said = complaint(&device(&["--port", "/dev/does-not-exist", "status"]));
    assert!(said.contains("there is no such port; ports that there are:"), "{said}");
    let said = complaint(&device(&["--port", "/dev/null", "status"]));
    assert!(said.contains("it is no serial port that can be used"), "{said}");
    let board = Board::new(Manner::Sound);
    let other = serialport::new(board.path.as_str(), 921_600).open().unwrap();
    assert!(complaint(&board.device(&["status"])).contains("another program has it open"));
    drop(other);
    told(&board.device(&["status"]));
}

#[test]
fn what_the_device_or_the_file_refuses_is_told() {
    let board = Board::new(Manner::Sound);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("joint.toml");
    let with = |from: &str, to: &str| {
        let text = host_sim::experiment::find("step-response").unwrap().toml.replace(from, to);
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
    assert!(said.contains("`loop.sample_time_s` is 0.05; allowed is a number from 0.0001 to 0.02"), "{said}");
    // A ramp that the device itself refuses.
    let said = complaint(&board.device(&["identify", "--rate", "100"]));
    assert!(
        said.contains("refuses: `ramp_rates_v_per_s` is 100; allowed is a number from 0 to 10"),
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
    let said = complaint(&output(command.env("AT", directory.path()).env("TMPDIR", directory.path())));
    assert!(said.contains("refuses: only with the output off"), "{said}");
    let (before, file) = said.rsplit_once(", and the text is kept in ").unwrap();
    assert!(before.ends_with("; the old parameters are in use"), "{said}");
    assert!(std::fs::read_to_string(file).unwrap().contains("kp_v_per_deg=2"), "{said}");
}
