//! What the command line with the emulator built in answers when the image is missing, and when it
//! is interrupted. These tests are blind to Ctrl-C on other systems than Unix.

#[cfg(unix)]
use std::ffi::OsString;
#[cfg(unix)]
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A time by far longer than any of these commands takes; one that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(120);

fn stiction(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.current_dir(directory).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Waits for the end of a command, and stops one that hangs.
fn end_of(mut child: Child) -> Output {
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("it hangs");
        }
        sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

fn assert_one_sentence(output: &Output, code: i32, fragments: &[&str]) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(said.starts_with("stiction: ") && said.lines().count() == 1, "{said}");
    for fragment in fragments {
        assert!(said.contains(fragment), "{fragment}: {said}");
    }
}

#[test]
fn an_image_that_is_not_there_is_named_with_the_command_that_builds_it() {
    let nowhere = tempfile::tempdir().unwrap();
    let default = ["run", "step-response", "--target", "emulator"];
    let named = ["run", "step-response", "--target", "emulator", "--image", "no/such.elf"];
    let device = ["device", "--emulator", "status"];
    let named_device = ["device", "--emulator", "--image", "no/such.elf", "status"];
    for (arguments, path) in [
        (&default[..], "target/firmware/stiction-firmware.elf"),
        (&named, "no/such.elf"),
        (&device, "target/firmware/stiction-firmware.elf"),
        (&named_device, "no/such.elf"),
    ] {
        let output = end_of(stiction(nowhere.path(), arguments).spawn().unwrap());
        assert_one_sentence(&output, 2, &[path, "cargo xtask firmware"]);
    }
}

/// The path of the image, which `cargo xtask test` sets. A test that cannot find the image fails:
/// one that is skipped looks like one that has passed.
#[cfg(unix)]
fn image() -> OsString {
    match std::env::var_os("STICTION_IMAGE") {
        Some(path) => fs::canonicalize(path).unwrap().into(),
        None => panic!("STICTION_IMAGE does not name a flash image: run `cargo xtask test`"),
    }
}

/// Presses Ctrl-C a number of times, once the first line of the firmware's log shows that the work,
/// which takes minutes, has started. Checks the answer.
#[cfg(unix)]
fn assert_ended_by(presses: usize) {
    let directory = tempfile::tempdir().unwrap();
    let (results, log) = (directory.path().join("results"), directory.path().join("log"));
    fs::create_dir(&results).unwrap();
    let arguments = ["run", "step-response", "--target", "emulator", "--log", "--csv", "runs.csv"];
    let mut command = stiction(&results, &arguments);
    command.args(["--set", "run.duration_s=600", "--image"]).arg(image());
    let mut child = command.stderr(fs::File::create(&log).unwrap()).spawn().unwrap();
    let begin = Instant::now();
    while fs::read(&log).unwrap().is_empty() {
        assert_eq!(child.try_wait().unwrap(), None, "it has ended by itself");
        assert!(begin.elapsed() < PATIENCE, "it does not begin");
        sleep(Duration::from_millis(5));
    }
    for _ in 0..presses {
        // A second Ctrl-C may come after the end of the program.
        Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .stderr(Stdio::null())
            .status()
            .unwrap();
    }
    let output = end_of(child);
    let said = fs::read_to_string(&log).unwrap();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(output.stdout.is_empty());
    assert_eq!(fs::read_dir(&results).unwrap().count(), 0, "it has written something");
    if presses == 1 {
        let last = said.lines().last().unwrap();
        assert!(last.starts_with("stiction: interrupted") && last.contains("no results"), "{last}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_runs_and_says_so() {
    assert_ended_by(1);
}

#[cfg(unix)]
#[test]
fn ctrl_c_twice_ends_them_at_once() {
    assert_ended_by(2);
}

/// The warning with which every output of `stiction device --emulator` begins.
#[cfg(unix)]
const EMULATED: &str = "EMULATED DEVICE: no motor moves or stops.\n";

#[cfg(unix)]
#[test]
fn every_output_of_an_emulated_device_says_so_first() {
    let directory = tempfile::tempdir().unwrap();
    let image = image();
    let actions: [&[&str]; 4] = [
        &["status"],
        &["move", "1", "--for", "0.5", "--log", "move.csv"],
        &["params", "show"],
        // The warning is there where something goes wrong, too: the flash of the emulator keeps
        // nothing.
        &["params", "push", "step-response", "--controller", "pd", "--save"],
    ];
    for action in actions {
        let mut command = stiction(directory.path(), &["device", "--emulator", "--image"]);
        let output = end_of(command.arg(&image).args(action).spawn().unwrap());
        let (said, errors) =
            (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(errors.starts_with(EMULATED), "{action:?}: {errors}");
        if action.contains(&"--save") {
            assert_eq!((output.status.code(), &*said), (Some(2), ""), "{errors}");
            assert!(errors.contains("the emulator models no contents of the flash"), "{errors}");
            assert_eq!(errors.lines().count(), 2, "{errors}");
        } else {
            assert!(
                output.status.success() && said.starts_with(EMULATED),
                "{action:?}: {said}{errors}"
            );
        }
    }
    assert!(directory.path().join("move.csv").is_file());
}
