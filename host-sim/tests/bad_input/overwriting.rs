//! No command writes over a file that it reads, nor over a machine's file, unless `--force` is
//! given; and a path that cannot be written is refused before the work. The work of each command
//! here takes longer than an answer may take, or would move a joint.

use std::fs::{self, Permissions};
use std::path::{Path, PathBuf};
use std::process::Command;

use super::refusal::{answer, assert_all_refused};
use super::{shown, stiction};

/// A directory with what the commands read.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        fs::write(desk.path("joint.toml"), shown("step-response")).unwrap();
        fs::write(desk.path("log.csv"), "t,q_rad,tau\n0,0,0\n").unwrap();
        let rows = ["ensemble", "--plant", "rigid", "--controller", "pd", "--cases", "1"];
        let rows = desk.command(&[&rows[..], &["--csv", "rows.csv"]].concat());
        assert!(answer(rows).unwrap().status.success());
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = stiction(arguments);
        command.current_dir(self.0.path());
        command
    }

    /// Names and contents of all files.
    fn contents(&self) -> Vec<(PathBuf, Option<Vec<u8>>)> {
        let entries = fs::read_dir(self.0.path()).unwrap().map(|entry| entry.unwrap().path());
        let mut all: Vec<_> = entries.map(|path| (path.clone(), fs::read(path).ok())).collect();
        all.sort();
        all
    }
}

/// Every command that writes a file, to the path after it.
const WRITING: [&[&str]; 13] = [
    &["run", "step-response", "--csv"],
    &["run", "spring-mass", "--csv"],
    &["ensemble", "--plant", "rigid", "--cases", "1000000", "--csv"],
    &["ensemble", "--plant", "joint.toml", "--cases", "1000000", "--csv"],
    &["ensemble", "--plant", "rigid", "--cases", "1000000", "--resume"],
    &["ensemble", "merge", "rows.csv", "--csv"],
    &["tune", "joint.toml", "--controller", "all", "--cases", "1000", "--out"],
    &["identify", "log.csv", "--time", "t", "--position", "q_rad", "--effort", "tau", "--into"],
    &["params", "step-response", "--out"],
    &["new", "--typical", "thesis"],
    &["device", "--simulated", "log", "--for", "86400"],
    &["device", "--simulated", "move", "5", "--for", "86400", "--log"],
    &["device", "--simulated", "params", "pull"],
];

fn refused(desk: &Desk, path: &str, says: &'static str) {
    let identify = &["device", "--simulated", "identify", "--into"][..];
    let before = desk.contents();
    assert_all_refused(WRITING.iter().copied().chain([identify]).map(|arguments| {
        let arguments = [arguments, &[path]].concat();
        (arguments.join(" "), desk.command(&arguments), vec![says, path])
    }));
    assert!(desk.contents() == before, "{path}: a refused command has changed a file");
}

#[test]
fn no_command_writes_over_a_machine_s_file() {
    let desk = Desk::new();
    fs::write(desk.path("other.toml"), shown("trajectory")).unwrap();
    refused(&desk, "other.toml", "--force");
    // Its name does not matter, nor does a mistake in the file that is called so.
    fs::write(desk.path("other"), shown("spring-mass")).unwrap();
    refused(&desk, "other", "--force");
    fs::write(desk.path("broken.toml"), "[joint\n").unwrap();
    refused(&desk, "broken.toml", "--force");
}

#[test]
fn no_command_writes_over_a_file_that_it_reads() {
    let desk = Desk::new();
    fs::hard_link(desk.path("rows.csv"), desk.path("hard.csv")).unwrap();
    fs::hard_link(desk.path("joint.toml"), desk.path("joint.csv")).unwrap();
    fs::write(desk.path("run.svg"), "time_s,position_deg\n0,0\n").unwrap();
    let mut cases = vec![
        vec!["ensemble", "merge", "rows.csv", "--csv", "rows.csv"],
        vec!["ensemble", "merge", "rows.csv", "--csv", "hard.csv"],
        vec!["ensemble", "merge", "rows.csv", "--csv", "./rows.csv"],
        vec!["ensemble", "--plant", "rigid", "--resume", "new.csv", "--csv", "new.csv"],
        vec!["run", "joint.toml", "--csv", "joint.csv"],
        vec!["params", "joint.toml", "--out", "joint.csv"],
        vec!["device", "--simulated", "--machine", "joint.toml", "log", "joint.csv"],
        vec!["plot", "run.svg", "--out", "."],
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("rows.csv", desk.path("soft.csv")).unwrap();
        cases.push(vec!["ensemble", "merge", "rows.csv", "--csv", "soft.csv"]);
    }
    if cfg!(not(feature = "figures")) {
        cases.retain(|case| case[0] != "plot");
    }
    let before = desk.contents();
    assert_all_refused(cases.iter().map(|case| {
        (case.join(" "), desk.command(case), vec!["this command reads the file", "--force"])
    }));
    assert!(desk.contents() == before, "a refused command has changed a file");
}

#[test]
fn a_path_that_cannot_be_written_is_refused_before_the_work() {
    let desk = Desk::new();
    refused(&desk, "absent/out.csv", "the directory absent does not exist");
    fs::create_dir(desk.path("directory")).unwrap();
    refused(&desk, "directory", "is a directory");
    refused(&desk, "rows.csv/out.csv", "cannot write");
}

/// A file in place of a directory.
#[test]
fn a_directory_that_cannot_be_made_is_refused_before_the_work() {
    let desk = Desk::new();
    let mut cases = vec![
        vec!["run", "step-response", "--plot"],
        vec!["benchmark", "joint.toml", "--plot"],
        vec!["ensemble", "--plant", "rigid", "--cases", "1000000", "--plot"],
        vec!["tune", "joint.toml", "--controller", "all", "--cases", "1000", "--plot"],
        vec!["identify", "log.csv", "--time=t", "--position=q_rad", "--effort=tau", "--plot"],
        vec!["report", "joint.toml", "--out"],
        vec!["report", "--out"],
    ];
    if cfg!(not(feature = "figures")) {
        cases.clear();
    }
    let before = desk.contents();
    assert_all_refused(cases.iter().map(|case| {
        let arguments = [&case[..], &["rows.csv"]].concat();
        (arguments.join(" "), desk.command(&arguments), vec!["cannot write rows.csv"])
    }));
    assert!(desk.contents() == before, "a refused command has changed a file");
}

#[cfg(feature = "figures")]
#[test]
fn results_are_written_before_charts_that_cannot_be_drawn() {
    let desk = Desk::new();
    for (arguments, file) in [
        (&["tune", "joint.toml", "--controller", "rvi", "--cases", "4", "--out"][..], "gains.toml"),
        (
            &["ensemble", "--plant", "rigid", "--controller", "pd", "--cases", "1", "--csv"],
            "all.csv",
        ),
    ] {
        let run = || answer(desk.command(&[arguments, &[file, "--plot", "figures"]].concat()));
        assert!(run().unwrap().status.success(), "{arguments:?}");
        fs::remove_file(desk.path(file)).unwrap();
        for figure in fs::read_dir(desk.path("figures")).unwrap() {
            let figure = figure.unwrap().path();
            fs::remove_file(&figure).unwrap();
            fs::create_dir(&figure).unwrap();
        }
        let failed = run().unwrap();
        assert_eq!(failed.status.code(), Some(2), "{arguments:?}");
        assert!(fs::metadata(desk.path(file)).unwrap().len() > 0, "{arguments:?}");
        fs::remove_dir_all(desk.path("figures")).unwrap();
    }
}

/// A user who has protected a file has said enough; the system would let the owner of the directory
/// replace it.
#[test]
fn a_read_only_file_is_not_replaced() {
    let desk = Desk::new();
    let read_only = |path: &Path, is_read_only: bool| {
        let mut permissions: Permissions = fs::metadata(path).unwrap().permissions();
        permissions.set_readonly(is_read_only);
        fs::set_permissions(path, permissions).unwrap();
    };
    read_only(&desk.path("rows.csv"), true);
    let command = desk.command(&["run", "step-response", "--csv", "rows.csv"]);
    assert_all_refused([("run".into(), command, vec!["cannot write rows.csv: ", "read-only"])]);
    let command = desk.command(&["run", "step-response", "--csv", "rows.csv", "--force"]);
    assert_all_refused([("run".into(), command, vec!["cannot write rows.csv: ", "read-only"])]);
    read_only(&desk.path("rows.csv"), false);
}

#[test]
fn results_replace_earlier_results_and_force_replaces_anything() {
    let desk = Desk::new();
    let run = ["run", "step-response", "--controller", "pd", "--csv"];
    for file in ["run.csv", "run.csv"] {
        let done = answer(desk.command(&[&run[..], &[file]].concat())).unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let csv = fs::read(desk.path("run.csv")).unwrap();
    let forced = answer(desk.command(&[&run[..], &["joint.toml", "--force"]].concat())).unwrap();
    assert!(forced.status.success(), "{}", String::from_utf8_lossy(&forced.stderr));
    assert!(fs::read(desk.path("joint.toml")).unwrap() == csv);
    // An empty file holds no joint.
    fs::write(desk.path("empty.toml"), "").unwrap();
    let done = answer(desk.command(&[&run[..], &["empty.toml"]].concat())).unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn two_outputs_are_not_mixed_on_the_standard_output() {
    let desk = Desk::new();
    assert_all_refused(
        [
            &["run", "step-response", "--json", "--csv", "-"][..],
            &["ensemble", "--cases", "1000000", "--json", "--csv", "-"],
            &["tune", "joint.toml", "--json", "--out", "-"],
            &["device", "--simulated", "move", "5", "--json", "--log", "-"],
            &["device", "--simulated", "identify", "--json", "--into", "-"],
        ]
        .map(|arguments| {
            let command = desk.command(arguments);
            (arguments.join(" "), command, vec!["--json and ", "name a file"])
        }),
    );
}
