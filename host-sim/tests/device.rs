//! `stiction device` on the built program: what a simulated device does, that it says what it is,
//! and what it answers to requests that cannot be done. These tests are blind to real ports.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

fn device(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.arg("device").args(arguments).env_remove("VISUAL").env_remove("EDITOR");
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const SAYS_SO: &str = "SIMULATED DEVICE: no motor moves or stops.";

#[test]
fn every_output_of_a_simulated_device_says_so_first() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (log, record, toml) = (file("log.csv"), file("device.params"), file("device.toml"));
    let actions: [&[&str]; 13] = [
        &["status"],
        &["stop"],
        &["arm", "--for", "0.2"],
        &["move", "1", "--for", "1"],
        &["faults"],
        &["log", &log, "--for", "1"],
        &["params", "show"],
        &["params", "push", "step-response", "--controller", "pd", "--save"],
        &["params", "pull", &record],
        &["params", "pull", &toml],
        &["params", "push", "trajectory"],
        &["identify", "--rate", "0.1", "--hold", "1"],
        &["selftest", "--moves", "3", "--joints", "3"],
    ];
    for action in actions {
        let output = device(&[&["--simulated"], action].concat());
        let said = text(&output.stdout);
        assert!(output.status.success(), "{action:?}: {}", text(&output.stderr));
        assert!(said.starts_with(SAYS_SO), "{action:?}: {said}");
        assert!(said.lines().all(|line| line.chars().count() <= 80), "{action:?}: {said}");
        assert!(text(&output.stderr).starts_with(SAYS_SO), "{action:?}");
    }
    // The warning is there where something goes wrong, too.
    let output = device(&["--simulated", "move", "1e300"]);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()));
    assert!(text(&output.stderr).starts_with(SAYS_SO));
}

/// The exit code is that of an agreement, and nothing else, so that a script does not go on.
#[test]
fn a_jog_says_what_it_has_found_to_a_person_and_to_a_script() {
    let output = device(&["--simulated", "jog"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("in the sense of the effort") && said.contains("the motor is off"),
        "{said}"
    );

    let json = |arguments: &[&str]| {
        let output = device(&[&["--simulated", "jog", "--json"], arguments].concat());
        let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), object, text(&output.stderr))
    };
    let (code, object, _) = json(&[]);
    assert_eq!(
        (code, &object["verdict"], &object["schema"]),
        (Some(0), &"agrees".into(), &1.into())
    );
    assert!(object["set"].is_null() && object["warning"] == SAYS_SO, "{object}");
    assert!(object["positive"]["moved_counts"].as_i64().unwrap() >= 8, "{object}");
    assert!(object["negative"]["moved_counts"].as_i64().unwrap() <= -8, "{object}");
    // Less than what starts the joint.
    let (code, object, said) = json(&["--effort", "0.3"]);
    assert_eq!((code, &object["verdict"]), (Some(2), &"still".into()));
    assert!(said.contains("nothing moved"), "{said}");

    let refused = device(&["--simulated", "jog", "--effort", "0.7"]);
    assert_eq!((refused.status.code(), text(&refused.stdout)), (Some(2), String::new()));
    let said = text(&refused.stderr);
    assert!(said.contains("`jog.effort_v` is 0.7; must be a number above 0, up to 0.6"), "{said}");
}

#[test]
fn a_move_arrives_and_its_log_has_the_columns_of_a_run() {
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("move.csv");
    let output =
        device(&["--simulated", "move", "-2.5", "--for", "3", "--log", log.to_str().unwrap()]);
    let said = text(&output.stdout);
    assert!(said.contains("state      armed") && said.contains("the motor is off"), "{said}");
    let mut reader = csv::Reader::from_path(&log).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let run = [
        "time_s",
        "reference_deg",
        "position_deg",
        "error_deg",
        "velocity_deg_per_s",
        "v_pd_v",
        "v_c_v",
        "v_v",
        "code",
        "stuck",
        "v_applied_v",
    ];
    assert_eq!(header, run);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    // These are 3 s of 20 ms, and the ticks in which the client waited for the last answer.
    assert!((149..=153).contains(&rows.len()), "{}", rows.len());
    let position: f64 = rows[rows.len() - 1][2].parse().unwrap();
    assert!((position + 2.5).abs() < 0.03, "{position}");
}

#[test]
fn a_move_that_a_fault_ends_is_over_then_and_fails() {
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("move.csv");
    // The step is beyond the largest one that SRNF takes within its limit of the speed.
    let output = device(&[
        "--simulated",
        "move",
        "60",
        "--step",
        "--for",
        "60",
        "--log",
        log.to_str().unwrap(),
    ]);
    let (said, complaint) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("state      faulted") && !said.contains("stopped: the motor is off"),
        "{said}"
    );
    let sentence = complaint.lines().last().unwrap();
    assert!(sentence.starts_with("stiction: move: ended by fault 17 (overspeed)"), "{sentence}");
    // The log has not the 3000 rows of a minute, but those of 60 deg at 50 deg/s and a status every
    // 0.1 s.
    let rows = csv::Reader::from_path(&log).unwrap().records().count();
    assert!((10..100).contains(&rows), "{rows}");
}

#[test]
fn what_cannot_be_done_is_one_sentence_and_exit_code_2() {
    // With no device yet there is nothing to warn of.
    let before_it_is_there: &[(&[&str], &[&str])] = &[
        (&["status"], &["exactly one of --port DEV, --emulator and --simulated"]),
        (&["--simulated", "--port", "/dev/null", "status"], &["exactly one of"]),
        (&["--simulated", "--image", "x.elf", "status"], &["--image needs --emulator"]),
        (
            &["--port", "/dev/does-not-exist", "status"],
            &["--port /dev/does-not-exist", "no such port"],
        ),
        (&["--simulated", "--machine", "nope", "status"], &["nope"]),
        (&["--simulated", "--controller", "srn", "status"], &["`srn`", "did you mean `srnf`?"]),
        (&["--simulated", "watch"], &["device watch needs a terminal"]),
    ];
    let of_a_device: &[(&[&str], &[&str])] = &[
        (&["--simulated", "move", "1e300"], &["move 1e300", "it must be -360 to 360 deg"]),
        // The device has no limits of travel.
        (&["--simulated", "move", "99999"], &["it must be -360 to 360 deg", "to go further"]),
        (&["--simulated", "arm", "--for", "-1"], &["--for -1", "0 to 86400"]),
        (
            &["--simulated", "identify", "--rate", "-1"],
            &["`identification.ramp_rates_v_per_s` is -1", "docs/reference/link.md"],
        ),
        (&["--simulated", "params", "edit"], &["set VISUAL or EDITOR"]),
    ];
    let of =
        |cases: &'static [(&[&str], &[&str])], begin| cases.iter().map(move |case| (case, begin));
    let warning = format!("{SAYS_SO}\n");
    for ((arguments, fragments), begin) in
        of(before_it_is_there, "").chain(of(of_a_device, &warning))
    {
        let output = device(arguments);
        let said = text(&output.stderr);
        assert!(said.starts_with(begin), "{arguments:?}: {said}");
        let said = &said[begin.len()..];
        assert!(!said.contains(SAYS_SO), "{arguments:?}: {said}");
        assert_eq!(
            (output.status.code(), text(&output.stdout)),
            (Some(2), String::new()),
            "{arguments:?}"
        );
        assert_eq!(said.trim_end().lines().count(), 1, "{arguments:?}: {said}");
        for fragment in *fragments {
            assert!(said.contains(fragment), "{arguments:?}: {said}");
        }
    }
}

/// An argument is one number, so its comma separates nothing.
#[test]
fn a_number_of_an_argument_is_read_as_everywhere_else() {
    let moved = |deg| device(&["--simulated", "move", deg, "--for", "2,5", "--json"]);
    for (typed, deg) in [("4,5", 4.5), ("-4,5", -4.5), ("45e-1", 4.5)] {
        let output = moved(typed);
        let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let target = object["target_deg"].as_f64().unwrap();
        assert!((target - deg).abs() < 0.01, "{typed}: {target}");
    }
    for (typed, why) in [
        ("1,234", "`1,234` is ambiguous: type 1.234 or 1234"),
        ("4,5,6", "`4,5,6` is not a number"),
        ("nan", "`nan` is not a number"),
        ("inf", "`inf` is not a number"),
        ("45deg", "`45deg` is not a number"),
    ] {
        let output = moved(typed);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{typed}: {said}");
        assert!(said.contains(why), "{typed}: {said}");
    }
}

#[cfg(not(feature = "emulator"))]
#[test]
fn a_build_without_the_emulator_says_how_to_build_one_with_it() {
    let output = device(&["--emulator", "status"]);
    let said = text(&output.stderr);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()));
    assert!(said.contains("device --emulator") && said.contains("--features emulator"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

/// The defaults of a law stand in the table of that law, and in no other.
#[test]
fn shown_table_of_a_law_has_its_own_gains_only() {
    let shown = |controller: &str| {
        let file = ["--simulated", "--machine", "untuned-joints"];
        let output = device(&[&file[..], &["--controller", controller, "params", "show"]].concat());
        let said = text(&output.stdout);
        let toml: toml::Table = said.trim_start_matches(SAYS_SO).parse().unwrap();
        let table = toml["controller"][controller].as_table().unwrap();
        table.keys().map(String::from).collect::<Vec<_>>()
    };
    let mut srnf = shown("srnf");
    srnf.sort();
    assert_eq!(srnf, ["alpha_per_deg", "kd_v_per_deg_per_s", "kp_v_per_deg", "v_ms_v"]);
    let robust = shown("robust");
    for key in ["inertia_v_s2_per_deg", "encoder_side", "give_up_attempts"] {
        assert!(robust.iter().any(|name| name == key), "{key} of {robust:?}");
    }
}

#[test]
fn a_pulled_file_is_one_that_run_takes() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("device.toml");
    let path = path.to_str().unwrap();
    assert!(
        device(&["--simulated", "--controller", "rvi", "params", "pull", path]).status.success()
    );
    // The file says it, too: it is of no board.
    assert!(std::fs::read_to_string(path).unwrap().starts_with(&format!("# {SAYS_SO}\n")));
    // The file has one controller, so no option has to name it.
    let output = device(&["--simulated", "--machine", path, "params", "show"]);
    assert!(text(&output.stdout).contains("[controller.rvi]"), "{}", text(&output.stderr));
    let run = |name: &str| {
        let mut stiction = Command::new(env!("CARGO_BIN_EXE_stiction"));
        let output =
            stiction.args(["run", name, "--controller", "rvi", "--json"]).output().unwrap();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["runs"][0]["metrics"].clone()
    };
    let found = run(path);
    assert!(found["rest_error_counts"].is_number() && found == run("step-response"), "{found}");
}

#[cfg(unix)]
mod edit {
    use super::*;

    /// Runs `params edit` with a command for an editor, and a folder of its own for what is kept.
    fn edit(editor: &str) -> (Output, tempfile::TempDir) {
        let directory = tempfile::tempdir().unwrap();
        let mut command = command(&["--simulated", "params", "edit", "--save"]);
        let output =
            command.env("EDITOR", editor).env("TMPDIR", directory.path()).output().unwrap();
        (output, directory)
    }

    fn kept(directory: &tempfile::TempDir) -> Vec<String> {
        let files = std::fs::read_dir(directory.path()).unwrap();
        files.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect()
    }

    #[test]
    fn what_was_changed_is_shown_and_taken_as_a_whole() {
        let (output, directory) = edit("sed -i 's/kp_v_per_deg = 1.0/kp_v_per_deg = 2/'");
        let said = text(&output.stdout);
        assert!(
            said.contains("controller.srnf.kp_v_per_deg: 1.0 -> 2.0\nin use now, and saved"),
            "{said}"
        );
        assert_eq!(kept(&directory), Vec::<String>::new());
    }

    #[test]
    fn what_was_not_changed_is_not_sent() {
        let (output, directory) = edit("true");
        assert!(text(&output.stdout).contains("nothing was changed, and nothing sent"));
        assert_eq!(kept(&directory), Vec::<String>::new());
        // The joint is none of the device's business.
        let (output, _directory) = edit("sed -i 's/stick_v = 0.4/stick_v = 0.5/'");
        assert!(text(&output.stdout).contains("no parameter of the device was changed"));
    }

    #[test]
    fn an_editor_that_is_not_there_leaves_nothing_behind() {
        let (output, directory) = edit("/does/not/exist");
        let said = text(&output.stderr);
        assert!(
            said.contains("the editor `/does/not/exist` ended with") && !said.contains("kept"),
            "{said}"
        );
        assert_eq!((output.status.code(), kept(&directory)), (Some(2), vec![]));
    }

    #[test]
    fn what_is_wrong_is_named_not_sent_and_not_lost() {
        for (editor, fragment, typed) in [
            (
                "sed -i 's/kp_v_per_deg = 1.0/kp_v_per_deg = -1/'",
                "`controller.srnf.kp_v_per_deg` is -1",
                "= -1",
            ),
            (
                "sed -i 's/stall_v/stall_vv/'",
                "unknown key `limits.stall_vv`; did you mean `stall_v`?",
                "stall_vv",
            ),
            ("sed -i '/stall_v/d'", "`limits.stall_v` is missing, and must be set", "stall_s"),
            (
                "sed -i 's/thermal_s = 10.0/thermal_s = 1e9/'",
                "`limits.thermal_s` is 1000000000;",
                "1e9",
            ),
            ("sh -c 'echo 1 > \"$0\"; exit 3'", "ended with exit status: 3", "1"),
        ] {
            let (output, directory) = edit(editor);
            let said = text(&output.stderr);
            assert_eq!((output.status.code(), said.lines().count()), (Some(2), 2), "{said}");
            assert!(said.contains(fragment) && said.contains("nothing was sent"), "{said}");
            let file = said.trim_end().rsplit_once("kept in ").unwrap().1;
            assert!(std::fs::read_to_string(file).unwrap().contains(typed), "{said}");
            assert_eq!(kept(&directory).len(), 1);
        }
    }
}

/// Writes the thesis's joint, with further answers, and returns its file.
fn joint(directory: &tempfile::TempDir, name: &str, answers: &[&str]) -> String {
    typical("thesis", directory, name, answers)
}

fn typical(of: &str, directory: &tempfile::TempDir, name: &str, answers: &[&str]) -> String {
    let file = directory.path().join(name).to_str().unwrap().to_owned();
    let new = ["new", &file, "--typical", of];
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    let made = command.args([&new[..], answers].concat()).output().unwrap();
    assert!(made.status.success(), "{}", text(&made.stderr));
    file
}

/// `--machine` is what the commands believe; `--truth` is the joint of the device.
#[test]
fn a_self_test_passes_on_the_joint_that_it_believes_and_fails_on_another_truth() {
    let directory = tempfile::tempdir().unwrap();
    let believed = joint(&directory, "arm.toml", &[]);
    let cold = joint(&directory, "cold.toml", &["--viscous-nm-s-per-rad", "2475"]);
    let slack = directory.path().join("slack.toml").to_str().unwrap().to_owned();
    // Both inertias of an elastic gear are needed: the rotor has a tenth of the joint's.
    let loose = std::fs::read_to_string(&believed)
        .unwrap()
        .replace("rotor_inertia_kg_m2 = 0.0", "rotor_inertia_kg_m2 = 3.5368e-5")
        .replace("inertia_kg_m2 = 1145.9155902616465", "inertia_kg_m2 = 1031.324")
        .replace("[load]", "backlash_deg = 1.0\nstiffness_nm_per_rad = 2e5\n\n[load]");
    std::fs::write(&slack, loose).unwrap();
    let selftest = |truth: &[&str]| {
        let moves = ["selftest", "--moves", "6", "--joints", "8"];
        device(&[&["--simulated", "--machine", &believed], truth, &moves[..]].concat())
    };
    for truth in [&[][..], &["--truth", &believed]] {
        let same = selftest(truth);
        assert!(same.status.success(), "{truth:?}: {}", text(&same.stdout));
        assert!(text(&same.stdout).contains("selftest   pass"));
    }
    for truth in [&cold, &slack] {
        let other = selftest(&["--truth", truth]);
        assert_eq!(other.status.code(), Some(2), "{truth}: {}", text(&other.stdout));
        let said = text(&other.stderr);
        assert!(said.contains("the joint does not move as") || said.contains("ended by"), "{said}");
    }
    let said = text(&selftest(&["--truth", &cold]).stdout);
    assert!(said.contains("selftest   FAIL: sliding"), "{said}");
}

/// The joint starts at its zero, where the true chip shows 5310 counts of its turn of 16384.
#[test]
fn a_jog_at_a_stated_position_names_the_zero_that_an_absolute_encoder_has() {
    let directory = tempfile::tempdir().unwrap();
    let gear = ["--backlash", "0.3", "--stiffness", "1000", "--counts-per-turn", "16384"];
    let incremental = typical("harmonic", &directory, "two.toml", &gear);
    let text_of = std::fs::read_to_string(&incremental).unwrap();
    let absolute = |zero: u32| {
        let chip = format!("[load_encoder]\nkind = \"as5047p\"\nzero_counts = {zero}\n");
        let file = directory.path().join(format!("{zero}.toml")).to_str().unwrap().to_owned();
        std::fs::write(&file, text_of.replace("[load_encoder]\n", &chip)).unwrap();
        file
    };
    let truth = absolute(5310);
    let jog = |believed: &str| {
        let joint = ["--simulated", "--machine", believed, "--truth", &truth];
        let output = device(&[&joint[..], &["jog", "--at", "0", "--json"]].concat());
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), found["offset"].clone(), text(&output.stderr))
    };
    let (code, offset, _) = jog(&truth);
    assert_eq!((code, &offset["wrong"]), (Some(0), &false.into()));
    // A hundred counts are 360 / 16384 deg each; the limit of a right offset is 1 deg.
    let (code, offset, said) = jog(&absolute(5210));
    assert_eq!((code, &offset["zero_counts"]), (Some(2), &5310.into()));
    let error = offset["error_deg"].as_f64().unwrap();
    assert!((error - 100.0 * 360.0 / 16384.0).abs() < 1e-6, "{offset}");
    assert!(said.contains("set load_encoder.zero_counts = 5310"), "{said}");

    let none = device(&["--simulated", "--machine", &incremental, "jog", "--at", "0"]);
    let said = text(&none.stderr);
    assert_eq!(none.status.code(), Some(2), "{said}");
    assert!(said.contains("no absolute encoder") && said.contains("Nothing has moved"), "{said}");
}

/// The stops of a data sheet are those of the simulated joint, which starts at zero.
#[test]
fn a_joint_is_homed_to_a_stop_of_its_data_sheet_and_one_without_a_stop_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let free = joint(&directory, "free.toml", &[]);
    let stops = "[load]\nstop_min_deg = -7.0\nstop_max_deg = 12.0\n";
    let sheet = std::fs::read_to_string(&free).unwrap().replace("[load]\n", stops);
    let between = directory.path().join("between.toml").to_str().unwrap().to_owned();
    std::fs::write(&between, sheet).unwrap();
    let home = |file: &str, arguments: &[&str]| {
        device(&[&["--simulated", "--machine", file, "home"], arguments].concat())
    };
    for (towards, at, moved_deg) in [("plus", "40", 12.0), ("minus", "-10", -7.0)] {
        let found = home(&between, &["--towards", towards, "--at", at, "--json"]);
        assert!(found.status.success(), "{}", text(&found.stderr));
        let found: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
        assert_eq!((&found["ended_by"], &found["referenced"]), (&"stop".into(), &true.into()));
        let moved = found["moved_deg"].as_f64().unwrap();
        assert!((moved - moved_deg).abs() < 0.01, "{found}");
        // It has gone back by half of jog.travel_deg, which is 2 deg, and a little more to rest.
        let back = (at.parse::<f64>().unwrap() - found["position_deg"].as_f64().unwrap()).abs();
        assert!((0.9..2.0).contains(&back), "{found}");
    }
    let none = home(&free, &["--towards", "plus", "--at", "40", "--travel", "5"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stdout).contains("no stop within the travel"), "{}", text(&none.stderr));
    assert!(text(&none.stderr).contains("not referenced"), "{}", text(&none.stderr));
    let beyond = home(&free, &["--towards", "plus", "--at", "0", "--effort", "1000"]);
    assert!(text(&beyond.stderr).contains("home.effort_v"), "{}", text(&beyond.stderr));
}

#[test]
fn a_truth_that_no_device_could_have_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let believed = joint(&directory, "arm.toml", &[]);
    let refusal = |arguments: &[&str]| {
        let output = device(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty());
        text(&output.stderr)
    };
    let own = ["--machine", &believed, "--truth"];
    for (name, answers, expected) in [
        (
            "slow.toml",
            ["--sample-time-s", "0.01"],
            "the sample time in s (`loop.sample_time_s`) is",
        ),
        (
            "coarse.toml",
            ["--lines", "1000"],
            "the joint's angle of one count in deg (`encoder.reso",
        ),
    ] {
        let truth = joint(&directory, name, &answers);
        let said = refusal(&[&["--simulated"], &own[..], &[&truth, "status"]].concat());
        assert!(
            said.contains(expected) && said.contains("must be the same in both files"),
            "{said}"
        );
    }
    let board = ["--port", "/dev/none", "--truth", &believed, "status"];
    let said = refusal(&board);
    assert!(said.contains("--truth") && said.contains("a board on a --port has its own joint"));
    let unknown = refusal(&["--simulated", "--truth", "no-such.toml", "status"]);
    assert!(unknown.contains("no-such.toml"), "{unknown}");
}

#[test]
fn a_program_reads_status_faults_and_the_fault_of_a_move() {
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = device(&[&["--simulated"], arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"))
    };
    let status = json(&["status", "--json"]);
    assert_eq!((&status["schema"], &status["state"]), (&1.into(), &"stopped".into()));
    assert_eq!((&status["warning"], &status["fault"]), (&SAYS_SO.into(), &serde_json::Value::Null));
    assert_eq!((&status["position_counts"], &status["at_rest"]), (&0.into(), &true.into()));
    let faults = json(&["faults", "--json"]);
    assert_eq!(faults["faults"], serde_json::json!([]));
    assert_eq!(
        (&faults["latched"], &faults["since_power_on"]),
        (&serde_json::Value::Null, &0.into())
    );

    // A step of a degree is farther than this error allows at once after its jump.
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("strict.toml").to_str().unwrap().to_owned();
    let joint =
        Command::new(env!("CARGO_BIN_EXE_stiction")).args(["show", "step-response"]).output();
    let strict = text(&joint.unwrap().stdout) + "\n[limits]\noverspeed_deg_per_s = 1.0\n";
    std::fs::write(&file, strict).unwrap();
    let arguments = ["--simulated", "--machine", &file, "move", "5", "--step", "--json"];
    let output = device(&arguments);
    assert_eq!(output.status.code(), Some(2));
    let moved: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let fault = &moved["fault"];
    assert_eq!((&fault["code"], &fault["name"]), (&17.into(), &"overspeed".into()), "{moved}");
    assert_eq!(fault["section"], "17 Overspeed");
    assert!(
        fault["what_to_do"]
            .as_str()
            .unwrap()
            .contains("docs/reference/faults.md, \"17 Overspeed\"")
    );
    assert_eq!(fault["tripped_by"]["unit"], "deg/s");
    assert!(fault["tripped_by"]["value"].as_f64().unwrap().abs() > 1.0);
    assert_eq!((&moved["state"], &moved["ended_by"]), (&"faulted".into(), &"fault".into()));
    // A whole move has none.
    let moved = json(&["move", "1", "--for", "1", "--json"]);
    assert_eq!(
        (&moved["fault"], &moved["ended_by"]),
        (&serde_json::Value::Null, &serde_json::Value::Null)
    );
}

/// The data sheet has no load, and the joint has one: the file of the identified joint has the
/// load, and thresholds under which the joint may rest against it.
#[test]
fn an_identification_that_finds_a_load_raises_the_thresholds_that_it_would_trip() {
    let directory = tempfile::tempdir().unwrap();
    let believed = joint(&directory, "arm.toml", &[]);
    let [truth, found] =
        ["loaded.toml", "found.toml"].map(|name| directory.path().join(name).display().to_string());
    // 40 N m of 540 N m/V; the friction is 216 N m.
    let loaded = std::fs::read_to_string(&believed).unwrap();
    std::fs::write(&truth, loaded.replace("[load]\n", "[load]\nconstant_nm = 40.0\n")).unwrap();
    let own = ["--simulated", "--machine", &believed, "--truth", &truth];
    let output = device(&[&own[..], &["identify", "--into", &found]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let file = std::fs::read_to_string(&found).unwrap();
    let limit = |key: &str| -> f64 {
        let line = file.lines().find(|line| line.starts_with(key)).unwrap();
        line.split(" = ").nth(1).unwrap().parse().unwrap()
    };
    let (rests, derived) = (256.0 / 540.0, 216.0 / 540.0);
    assert!((limit("breakaway_v") / rests - 1.0).abs() < 0.05, "{file}");
    for key in ["stall_v", "stall_impulse_vs", "wind_up_v"] {
        let times = if key == "stall_v" {
            2.0
        } else if key == "wind_up_v" {
            1.0
        } else {
            0.5
        };
        assert!(limit(key) > 1.1 * times * derived, "{key}: {file}");
    }
    assert!(file.contains("`limits.breakaway_v` is raised from 0.4 V"), "{file}");
}

/// An inertia in another unit.
#[test]
fn a_move_repeats_what_is_doubtful_about_the_joint_of_its_file() {
    let directory = tempfile::tempdir().unwrap();
    let joint = joint(&directory, "heavy.toml", &[]);
    let text_of = std::fs::read_to_string(&joint).unwrap();
    let doubtful = text_of.replace("inertia_kg_m2 = 1145.9155902616465", "inertia_kg_m2 = 2e6");
    assert_ne!(doubtful, text_of);
    for (file, doubts) in [(text_of, 0), (doubtful, 1)] {
        std::fs::write(&joint, file).unwrap();
        let moved = device(&["--simulated", "--machine", &joint, "move", "0.01", "--for", "0.1"]);
        let said = text(&moved.stderr);
        assert_eq!(
            said.matches("`load.inertia_kg_m2` is 2000000 kg m^2; usual").count(),
            doubts,
            "{said}"
        );
    }
}
