//! Starts the built program, and checks what it says.

use std::os::fd::AsRawFd;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard};

use nix::fcntl::{FcntlArg, FdFlag, fcntl};
use serialport::TTYPort;

/// A lock that is held while a pseudoterminal is made, and while a program is started.
pub static SPAWNING: Mutex<()> = Mutex::new(());

/// Makes a pseudoterminal, and returns its two ends. A program that inherited an end would keep it
/// open, so none may start meanwhile.
pub fn pseudoterminal(_spawning: &MutexGuard<()>) -> (TTYPort, TTYPort) {
    let (master, slave) = TTYPort::pair().unwrap();
    for fd in [master.as_raw_fd(), slave.as_raw_fd()] {
        fcntl(fd, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).unwrap();
    }
    (master, slave)
}

pub fn device(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    output(command.arg("device").args(arguments))
}

/// Starts a command of a device.
pub fn start(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.arg("device").args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    let _spawning = SPAWNING.lock().unwrap();
    command.spawn().unwrap()
}

pub fn output(command: &mut Command) -> Output {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let spawning = SPAWNING.lock().unwrap();
    let child = command.spawn().unwrap();
    drop(spawning);
    child.wait_with_output().unwrap()
}

/// Returns the output of a successful program. It starts with the warning of the device at the
/// other end.
pub fn success(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.starts_with("SIMULATED DEVICE: no motor moves or stops."), "{said}");
    said
}

/// Returns the one sentence of a failed program. Its exit code is 2, and the sentence names a page.
pub fn complaint(output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    let sentence =
        said.lines().filter(|line| !line.starts_with("SIMULATED DEVICE")).collect::<Vec<_>>();
    assert_eq!((output.status.code(), sentence.len()), (Some(2), 1), "{said}");
    assert!(output.stdout.is_empty() && said.contains("docs/"), "{said}");
    sentence[0].into()
}
