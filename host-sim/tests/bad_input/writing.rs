//! Files and pipes that cannot be written, or that are not read to the end.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use super::refusal::{answer, complaint};
use super::stiction;

#[test]
fn a_refused_run_leaves_no_file_behind_and_an_old_one_as_it_was() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    let csv = path.to_str().unwrap();
    let refused = ["run", "step-response", "--csv", csv, "--set", "loop.sample_time_s=0"];
    assert_eq!(complaint(stiction(&refused), &["`loop.sample_time_s` is 0"]), None);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    fs::write(&path, "old").unwrap();
    assert_eq!(complaint(stiction(&refused), &["`loop.sample_time_s` is 0"]), None);
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert!(stiction(&["run", "step-response", "--csv", csv]).output().unwrap().status.success());
    assert_ne!(fs::read_to_string(&path).unwrap(), "old");
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let occupied = directory.path().join("occupied");
    fs::write(&occupied, "").unwrap();
    let inside = |parent: &Path| parent.join("run.csv").to_str().unwrap().to_owned();
    for path in [
        inside(&directory.path().join("absent")),
        inside(&occupied),
        directory.path().to_str().unwrap().to_owned(),
    ] {
        let command = stiction(&["run", "step-response", "--controller", "pd", "--csv", &path]);
        assert_eq!(complaint(command, &[&format!("cannot write {path}: ")]), None);
    }
    // Nothing else has appeared, such as half a file under another name.
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_reported_and_leaves_nothing_half_written() {
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in
        [&["list"][..], &["list", "--json"], &["show", "trajectory"], &["run", "trajectory"]]
    {
        let mut command = stiction(arguments);
        let output = command.stdout(full()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let expected = "stiction: cannot write the output: No space left on device\n";
        assert_eq!((output.status.code(), said.as_str()), (Some(2), expected), "{arguments:?}");
    }
    let command = stiction(&["run", "step-response", "--controller", "pd", "--csv", "/dev/full"]);
    assert_eq!(complaint(command, &["cannot write /dev/full: No space left on device"]), None);

    // The file may not grow beyond 4 KiB, as on a disk that fills up while it is written.
    let directory = tempfile::tempdir().unwrap();
    let csv = directory.path().join("run.csv");
    let csv = csv.to_str().unwrap();
    let limited = |blocks: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", "trap '' XFSZ; ulimit -f $1; shift; exec \"$@\"", "sh", blocks]);
        command.args([
            env!("CARGO_BIN_EXE_stiction"),
            "run",
            "step-response",
            "--controller",
            "pd",
        ]);
        command.args(["--csv", csv]);
        command
    };
    assert_eq!(complaint(limited("8"), &[&format!("cannot write {csv}: ")]), None);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    assert!(answer(limited("unlimited")).unwrap().status.success());
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let runs: [&[&str]; 4] = [
        &["list"],
        &["show", "step-response"],
        &["run", "trajectory", "--json"],
        #[cfg(target_os = "linux")]
        &["run", "trajectory", "--csv", "/dev/stdout"],
    ];
    for arguments in runs {
        let mut child =
            stiction(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""), "{arguments:?}");
    }
}
