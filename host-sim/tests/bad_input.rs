//! What the command line answers to input that is wrong, on the built program: one sentence that names where it came
//! from, the key, what was found and what is allowed; exit code 2; nothing on the standard output, nothing
//! half-written. Blind to figures, and to what a directory's permissions forbid (tests may run as root).
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

/// Words of the language that the program is written in, and of a program that has lost its head.
const JARGON: [&str; 14] = [
    "f64",
    "u8",
    "usize",
    "i64",
    "i128",
    "struct",
    "serde",
    "invalid type",
    "invalid value",
    "expected a",
    "unit variant",
    "floating point",
    "os error",
    "panicked",
];

fn stiction(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// What a command printed, which is little; one that takes longer than any mistake may take is stopped.
fn answer(mut command: Command) -> Result<Output, String> {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            return Err("is still running after a minute".into());
        }
        sleep(Duration::from_millis(2));
    }
    Ok(child.wait_with_output().unwrap())
}

/// Why a command was not refused as it should be.
fn complaint(command: Command, fragments: &[&str]) -> Option<String> {
    let output = match answer(command) {
        Ok(output) => output,
        Err(why) => return Some(why),
    };
    let said = String::from_utf8(output.stderr).unwrap();
    let missing: Vec<_> = fragments.iter().filter(|fragment| !said.contains(**fragment)).collect();
    let jargon: Vec<_> = JARGON.iter().filter(|word| said.contains(**word)).collect();
    let why = if output.status.code() != Some(2) {
        format!("ended with {}", output.status)
    } else if !output.stdout.is_empty() {
        "printed on the standard output".into()
    } else if !(said.starts_with("stiction: ") && said.ends_with('\n') && said.lines().count() == 1) {
        "is not answered in one line".into()
    } else if said.matches("stiction: ").count() + said.matches(": --set").count() > 2 {
        "is answered with a prefix twice".into()
    } else if !missing.is_empty() {
        format!("lacks {missing:?}")
    } else if !jargon.is_empty() {
        format!("says {jargon:?}")
    } else {
        return None;
    };
    Some(format!("{why}: {said}"))
}

/// Every case that is not refused as it should be, by its name.
fn assert_all_refused<'a>(cases: impl IntoIterator<Item = (String, Command, Vec<&'a str>)>) {
    let complaints: Vec<String> = cases
        .into_iter()
        .filter_map(|(name, command, fragments)| {
            complaint(command, &fragments).map(|why| format!("{name}: {why}"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// Text of a built-in experiment.
fn shown(name: &str) -> String {
    String::from_utf8(stiction(&["show", name]).output().unwrap().stdout).unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = stiction(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), said.as_str()), (Some(0), ""), "{arguments:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_key_that_is_set_wrongly_is_named_with_what_was_found_and_what_is_allowed() {
    const STEP: &str = "step-response";
    const RAMP: &str = "friction-identification";
    let cases: &[(&str, &str, &[&str])] = &[
        // Not an assignment.
        (STEP, "joint", &["write it as table.key=value"]),
        (STEP, "=3", &["write it as table.key=value"]),
        (STEP, "joint=3", &["`joint` names no table", "table.key=value"]),
        (STEP, "title=3", &["`title` names no table", "table.key=value"]),
        (STEP, "joint..x=1", &["write it as table.key=value"]),
        (STEP, "run.duration_s=", &["no value after the `=`"]),
        (STEP, "run.duration_s=3\nrun.step_s=5", &["neither a number, a word, a quoted text nor a list"]),
        (STEP, "loop.sample_time_s=0.02s", &["\"0.02s\" is neither a number"]),
        (STEP, "run.duration_s.x=1", &["`duration_s` in `run.duration_s.x` is not a table"]),
        // Unknown keys and names.
        (STEP, "a.b.c.d=1", &["unknown key `a`", "allowed are title", "joint", "variant"]),
        (STEP, "loop.sample_time_ms=20", &["unknown key `loop.sample_time_ms`", "`sample_time_s`?"]),
        (STEP, "joint.inertia=3", &["unknown key `joint.inertia`", "gain_deg_per_s2_per_v"]),
        (STEP, "controller.pd.kp=1", &["unknown key `controller.pd.kp`", "`kp_v_per_deg`?"]),
        (STEP, "controller.pdd.kp_v_per_deg=1", &["no controller `pdd`", "did you mean `pd`?"]),
        (STEP, "controller.zzz.kp_v_per_deg=1", &["no controller `zzz`", "allowed are pd, ri, ", "srnf"]),
        (STEP, "loop.controller=nope", &["`loop.controller` names `nope`", "`[controller.nope]`", "srnf"]),
        (STEP, "run.solver=euler", &["`run.solver` is \"euler\"", "allowed are exact, rk4"]),
        (STEP, "encoder.rounding=neares", &["`encoder.rounding` is \"neares\"", "`nearest`?"]),
        (STEP, "controller.pd.laws=[\"foo\"]", &["`controller.pd.laws[0]` is \"foo\"", "srnf"]),
        // Wrong types and units.
        (STEP, "loop.sample_time_s=\"20 ms\"", &["`loop.sample_time_s` is \"20 ms\"", "allowed is a number"]),
        (STEP, "controller.pd.kp_v_per_deg=abc", &["is \"abc\"; allowed is a number"]),
        (STEP, "controller.pd=3", &["`controller.pd` is 3; allowed is a table"]),
        (STEP, "joint.friction=3", &["`joint.friction` is 3; allowed is a table"]),
        (STEP, "reference.steps_deg=5", &["`reference.steps_deg` is 5; allowed is a list"]),
        (STEP, "reference.steps_deg=[\"a\"]", &["`reference.steps_deg[0]` is \"a\"; allowed is a number"]),
        (STEP, "run.solver=3", &["`run.solver` is 3; allowed is a text"]),
        (STEP, "run.duration_s=1979-05-27", &["`run.duration_s` is 1979-05-27; allowed is a number"]),
        (
            STEP,
            "loop.controller=[3]",
            &["`loop.controller` is [3]", "a controller's name or a list of names"],
        ),
        (STEP, "loop.velocity_window=5.0", &["is 5.0; allowed is a whole number from 2 to 16"]),
        (STEP, "encoder.counter_bits=16.0", &["is 16.0; allowed is the whole number 16 or 32"]),
        (STEP, "run.delay_samples=true", &["is true; allowed is the whole number 0 or 1"]),
        // Out of range.
        (STEP, "loop.sample_time_s=0", &["`loop.sample_time_s` is 0; allowed is a number above 0, up to 1"]),
        (STEP, "loop.sample_time_s=-0.02", &["`loop.sample_time_s` is -0.02", "above 0"]),
        (STEP, "loop.sample_time_s=nan", &["`loop.sample_time_s` is NaN", "above 0"]),
        (STEP, "loop.sample_time_s=1e-300", &["is 1e-300, which is 0 in single precision"]),
        (STEP, "loop.velocity_window=0", &["`loop.velocity_window` is 0", "a whole number from 2 to 16"]),
        (STEP, "loop.velocity_window=-3", &["`loop.velocity_window` is -3", "a whole number from 2 to 16"]),
        (STEP, "loop.velocity_window=17", &["`loop.velocity_window` is 17", "a whole number from 2 to 16"]),
        (STEP, "loop.velocity_window=1000000000", &["is 1000000000", "a whole number from 2 to 16"]),
        (STEP, "joint.gain_deg_per_s2_per_v=-27", &["is -27; allowed is a number above 0"]),
        (STEP, "joint.gain_deg_per_s2_per_v=inf", &["is inf; allowed is a finite number above 0"]),
        (STEP, "joint.viscous_v_per_deg_per_s=-1", &["is -1; allowed is a number not below 0"]),
        (STEP, "joint.friction.slip_v=-1", &["`joint.friction.slip_v` is -1", "not below 0"]),
        (STEP, "joint.friction.stick_v=0.1", &["is 0.1; allowed is a number not below `slip_v` (0.38)"]),
        (STEP, "joint.friction.added_v=-1", &["is -1; allowed is a number not below -0.38"]),
        (
            STEP,
            "joint.friction.added_during_s=[[3,1]]",
            &["`joint.friction.added_during_s[0]` is [3, 1]", "later"],
        ),
        (
            STEP,
            "joint.friction.added_during_s=[[0,1],[nan,3]]",
            &["`joint.friction.added_during_s[1]`", "NaN"],
        ),
        (
            STEP,
            "joint.friction.added_during_s=[[3]]",
            &["`joint.friction.added_during_s[0]`", "allowed are 2"],
        ),
        (
            STEP,
            "controller.pd.kp_v_per_deg=nan",
            &["`controller.pd.kp_v_per_deg` is NaN", "from 0 to 1000000"],
        ),
        (STEP, "controller.pd.kp_v_per_deg=-1", &["`controller.pd.kp_v_per_deg` is -1", "from 0 to 1000000"]),
        (STEP, "controller.pd.kp_v_per_deg=1e300", &["`controller.pd.kp_v_per_deg` is 1e300", "from 0"]),
        (STEP, "controller.srnf.alpha_per_deg=nan", &["`controller.srnf.alpha_per_deg` is NaN", "from 0"]),
        (STEP, "controller.pd.v_ms_v=nan", &["`controller.pd.v_ms_v` is NaN", "not below 0"]),
        (STEP, "controller.pd.laws=[\"ri\"]", &["`controller.pd.ki_v_per_deg_s` is missing", "the law ri"]),
        (STEP, "controller.ri.laws=[\"ri\",\"ri\"]", &["`controller.ri.laws[1]`", "second time"]),
        (STEP, "controller.ri.laws=[\"ri\",\"rvi\"]", &["`controller.ri.laws` has ri and rvi", "only one"]),
        (STEP, "encoder.resolution_deg=0", &["`encoder.resolution_deg` is 0; allowed is a number above 0"]),
        (STEP, "encoder.counter_bits=17", &["`encoder.counter_bits` is 17; allowed are 16, 32"]),
        (STEP, "encoder.counter_bits=-1", &["`encoder.counter_bits` is -1; allowed are 16, 32"]),
        (STEP, "encoder.counter_bits=1000", &["`encoder.counter_bits` is 1000; allowed are 16, 32"]),
        (STEP, "encoder.phase=inf", &["`encoder.phase` is inf; allowed is a finite number from -1 to 1"]),
        (STEP, "drive.pwm_hz=0", &["`drive.pwm_hz` is 0; allowed is a number from 1300 to 5250000"]),
        (STEP, "drive.lsb_v=0", &["`drive.lsb_v` is 0; allowed is a number above 0.00015"]),
        (STEP, "drive.full_scale_v=1e300", &["`drive.full_scale_v` is 1e300; allowed is a number above 0"]),
        (STEP, "run.delay_samples=2", &["`run.delay_samples` is 2; allowed is 0 or 1"]),
        (STEP, "run.delay_samples=-1", &["`run.delay_samples` is -1", "0 or 1"]),
        (STEP, "run.step_s=0", &["`run.step_s` is 0; allowed is a number above 0"]),
        (STEP, "run.step_s=nan", &["`run.step_s` is NaN; allowed is a number above 0"]),
        (STEP, "run.duration_s=nan", &["`run.duration_s` is NaN; allowed is a number from 0.02"]),
        (STEP, "run.duration_s=0.001", &["`run.duration_s` is 0.001; allowed is a number from 0.02"]),
        // Steps.
        (STEP, "reference.steps_deg=[]", &["nothing to run", "`reference.steps_deg`", "has an entry"]),
        (STEP, "reference.steps_deg=[5.0, 0.0]", &["`reference.steps_deg[1]` is 0", "other than 0"]),
        (STEP, "reference.steps_deg=[1e12]", &["`reference.steps_deg[0]` is 1000000000000", "2^30 counts"]),
        (STEP, "reference.steps_deg=[nan]", &["`reference.steps_deg[0]` is NaN", "2^30 counts"]),
        (STEP, "reference.steps_deg=[5, 5]", &["`pd/step-5.0`", "its own size, speed or slug"]),
        (STEP, "loop.controller=[]", &["`loop.controller` is empty", "at least one name"]),
        (STEP, "loop.controller=[\"pd\", \"pd\"]", &["`loop.controller` names `pd` twice"]),
        // Ramps.
        (STEP, "identification.hold_s=3", &["`identification.ramp_rates_v_per_s` is missing"]),
        (RAMP, "identification.ramp_rates_v_per_s=[]", &["nothing to run"]),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[0]",
            &["`identification.ramp_rates_v_per_s[0]` is 0", "to 250"],
        ),
        (RAMP, "identification.ramp_rates_v_per_s=[-1]", &["is -1; allowed is a number from", "to 250"]),
        (RAMP, "identification.ramp_rates_v_per_s=[nan]", &["is NaN; allowed is a number from", "to 250"]),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[1e300]",
            &["is 1e300; allowed is a number from", "to 250"],
        ),
        (RAMP, "identification.hold_s=nan", &["`identification.hold_s` is NaN; allowed is a number from 0"]),
        (RAMP, "identification.hold_s=-1", &["`identification.hold_s` is -1; allowed is a number from 0"]),
        (RAMP, "run.duration_s=nan", &["`run.duration_s` is NaN; allowed is a number above 0"]),
        // A variant sets it.
        ("srnf-robustness", "controller.srnf.v_ms_v=0.3", &["cannot be set by hand", "every variant"]),
    ];
    assert_all_refused(cases.iter().map(|(experiment, assignment, fragments)| {
        let typed = ["--set ", assignment.lines().next().unwrap()];
        let command = stiction(&["run", experiment, "--set", assignment]);
        (typed.concat(), command, [&typed, *fragments].concat())
    }));
}

#[test]
fn a_key_that_no_longer_goes_with_one_that_was_set_is_named_with_both() {
    let cases: &[(&str, &[&str])] = &[
        ("joint.friction.slip_v=0.5", &["`joint.friction.stick_v` is 0.4", "`slip_v` (0.5)"]),
        ("loop.sample_time_s=1e-9", &["`run.duration_s` is 10", "1e-9 (one sample) to 0.01"]),
    ];
    assert_all_refused(cases.iter().map(|(assignment, fragments)| {
        let command = stiction(&["run", "step-response", "--set", assignment]);
        let origin = ["step-response with --set ", assignment];
        ((*assignment).to_owned(), command, [&origin, *fragments].concat())
    }));
}

#[test]
fn values_at_the_edge_of_what_is_allowed_are_taken() {
    for assignment in [
        "loop.velocity_window=2",
        "loop.velocity_window=16",
        "loop.sample_time_s=1",
        "encoder.counter_bits=32",
        "encoder.phase=-1",
        "run.delay_samples=1",
        "run.duration_s=0.02",
        "run.step_s=1e300",
        "drive.pwm_hz=1300",
        "drive.lsb_v=5",
        "joint.viscous_v_per_deg_per_s=0",
        "joint.friction.slip_v=0",
        "joint.friction.stick_v=0.38",
        "joint.friction.added_v=-0.38",
        "joint.friction.added_during_s=[]",
        "controller.pd.kp_v_per_deg=0",
        "controller.pd.kp_v_per_deg=1000000",
        "controller.pd.laws=[]",
        "reference.steps_deg=[-5, 0.0001]",
        "run.duration_s = 1 # with a comment",
        "run.solver=\"rk4\"",
        "loop.controller=pd",
    ] {
        let output =
            stiction(&["run", "step-response", "--controller", "pd", "--set", assignment]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.is_empty(), "{assignment}: {said}");
    }
    // Two keys that need each other, one after the other.
    let ramp = ["identification.hold_s=3", "identification.ramp_rates_v_per_s=[0.02]"];
    let both =
        json(&["run", "step-response", "--controller", "pd", "--json", "--set", ramp[0], "--set", ramp[1]]);
    assert!(both["runs"].as_array().unwrap().iter().any(|run| run["label"] == "ramp/rate-0.02"));
}

#[test]
fn a_file_with_a_mistake_is_named_with_the_key() {
    const STEP: &str = "step-response";
    const PATH: &str = "trajectory";
    const TIMES: &str = "[1.0, 11.0, 13.0, 23.0]";
    const PLACES: &str = "[0.0, 25.0, 25.0, 0.0]";
    // Edits of a built-in experiment: what is replaced by what.
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (STEP, "title = \"Steps", "title = 3 # \"", &["`title` is 3; allowed is a text in quotes"]),
        (STEP, "kp_v_per_deg = 1.0", "kp_v_per_deg = nan", &["`controller.pd.kp_v_per_deg` is NaN"]),
        (STEP, "kp_v_per_deg = 1.0", "kp_v_per_deg = -1.0", &["`controller.pd.kp_v_per_deg` is -1"]),
        (STEP, "kp_v_per_deg = 1.0\n", "", &["`controller.pd.kp_v_per_deg` is missing"]),
        (
            STEP,
            "sample_time_s = 0.02 ",
            "sample_time_ms = 20 ",
            &["`loop.sample_time_ms`", "`sample_time_s`?"],
        ),
        (STEP, "sample_time_s = 0.02 ", "sample_time_s = 0 ", &["`loop.sample_time_s` is 0", "above 0"]),
        (
            STEP,
            "resolution_deg = 0.00242",
            "resolution_deg = 0",
            &["`encoder.resolution_deg` is 0", "above 0"],
        ),
        (
            STEP,
            "gain_deg_per_s2_per_v = 27.0",
            "gain_deg_per_s2_per_v = -27.0",
            &["_per_v` is -27", "above 0"],
        ),
        (
            STEP,
            "counter_bits = 16",
            "counter_bits = 99999",
            &["`encoder.counter_bits` is 99999; allowed are 16, 32"],
        ),
        (STEP, "mode = \"locked-antiphase\"", "mode = \"locked\"", &["is \"locked\"", "`locked-antiphase`?"]),
        (STEP, "[run]", "[runn]", &["unknown key `runn`; did you mean `run`?"]),
        (STEP, "[run]", "[run.extra]", &["unknown key `run.extra`", "duration_s"]),
        (STEP, "[drive]", "[drives]", &["unknown key `drives`", "`drive`?"]),
        (STEP, "[loop]", "[lop]", &["unknown key `lop`", "`loop`?"]),
        (
            STEP,
            "{ of = \"pd\", thesis = \"Fig",
            "3, { of = \"pd\", thesis = \"Fig",
            &["`figures[0]` is 3", "a table"],
        ),
        (
            STEP,
            "\"joint.gain_deg",
            "\"joint.gain",
            &["variant `literal-si`", "`joint.gain_per_s2_per_v`", "did you"],
        ),
        (STEP, "\"joint.gain_deg_per_s2_per_v\"", "gain", &["variant `literal-si`", "`gain` names no table"]),
        (
            STEP,
            "= 1546.986",
            "= -3",
            &["variant `literal-si`: `joint.gain_deg_per_s2_per_v` is -3", "above 0"],
        ),
        (STEP, "= 1546.986", "= \"x\"", &["variant `literal-si`: `joint.gain_deg_per_s2_per_v` is \"x\""]),
        (STEP, "slug = \"literal-si\"", "slugg = \"x\"", &["unknown key `variant[1].slugg`", "`slug`?"]),
        (STEP, "slug = \"literal-si\"", "slug = \"a/b\"", &["`slug`", "\"a/b\"", "allowed are"]),
        (
            STEP,
            "\"literal-si\"\nset = {",
            "\"\"\nset = { \"run.step\" = 1,",
            &["variant 2: unknown key `run.step`"],
        ),
        (STEP, "[controller.pd]", "[controller.\"../x\"]", &["controller", "\"../x\"", "allowed are"]),
        (STEP, "[controller.pd]", "[controller.\"\"]", &["controller", "\"\"", "at least one"]),
        (STEP, "[controller.pd]", "[controller.abcdefghijklmnopqrstu]", &["up to 20 letters"]),
        (STEP, "controller = [\"pd\", ", "controller = [\"mine\", ", &["`loop.controller` names `mine`"]),
        // Trajectories.
        (PATH, TIMES, "[1.0, 11.0, 23.0]", &["trajectories[0].corner_positions_deg` has 4 entries", "(3)"]),
        (PATH, TIMES, "[1.0, 11.0, 9.0, 23.0]", &["trajectories[0].corner_times_s[2]` is 9", "from 11.5"]),
        (PATH, TIMES, "[0.1, 11.0, 13.0, 23.0]", &["corner_times_s[0]` is 0.1", "from 0.25"]),
        (PATH, TIMES, "[1.0, nan, 13.0, 23.0]", &["corner_times_s[1]` is NaN", "from 1.5"]),
        (PATH, TIMES, "[1.0, 11.0, 13.0, inf]", &["corner_times_s[3]` is inf", "a finite number"]),
        (PATH, TIMES, "[1.0, 11.0, 13.0, 1e300]", &["corner_times_s[3]` is 1e300", "to 200000"]),
        (PATH, TIMES, "[]", &["corner_times_s` has 0 entries; allowed are 2 to 16"]),
        (
            PATH,
            PLACES,
            "[0.0, nan, 25.0, 0.0]",
            &["`reference.trajectories[1].corner_positions_deg[1]` is NaN"],
        ),
        (
            PATH,
            PLACES,
            "[7.0, 7.0, 7.0, 7.0]",
            &["`reference.trajectories[1].corner_positions_deg` is 7 throughout"],
        ),
        (PATH, PLACES, "[0.0, 50.0, 50.0, 0.0]", &["`pd/trajectory-5.0`", "its own size, speed or slug"]),
        (
            PATH,
            "half_blend_s = 0.25",
            "half_blend_s = nan",
            &["`reference.trajectories[0].half_blend_s` is NaN", "half a sample"],
        ),
        (PATH, "half_blend_s = 0.25\n", "", &["`reference.trajectories[0].half_blend_s` is missing"]),
    ];
    let directory = tempfile::tempdir().unwrap();
    let files: Vec<String> = (0..cases.len()).map(|i| format!("a joint {i}.toml")).collect();
    assert_all_refused(cases.iter().zip(&files).map(|((experiment, from, to, fragments), file)| {
        let text = shown(experiment);
        assert!(text.contains(from), "{experiment} does not hold {from:?}");
        let path = directory.path().join(file);
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let name = format!("{experiment} with {to:?} for {from:?}");
        (name, stiction(&["run", path.to_str().unwrap()]), [&[file.as_str()], *fragments].concat())
    }));
}

#[test]
fn what_is_not_toml_is_named_with_its_line() {
    let cases: &[(&str, &[&str])] = &[
        ("title = \"x\"\n[joint\n", &["line 2: unclosed table, expected `]`"]),
        ("[joint]\na = 1\n\na = 2\n", &["line 4: `a` is there twice"]),
        ("[joint]\n[run]\n[joint]\n", &["line 3: `joint` is there twice"]),
        ("[joint]\na =\n", &["line 2: a value is missing or lacks its quotes"]),
        ("[joint]\na = up\n", &["line 2: a value is missing or lacks its quotes"]),
        ("\n\ntitle = \"x\n", &["line 3: a text lacks its closing quote"]),
        ("a = [1, 2\n[joint]\n", &["line 2: missing comma"]),
        ("\u{feff}a b\n", &["line 1: "]),
        ("a = 1.2.3\n", &["line 1: a number is malformed"]),
        ("a = 99999999999999999999\n", &["line 1: a whole number has too many digits"]),
    ];
    let directory = tempfile::tempdir().unwrap();
    assert_all_refused(cases.iter().enumerate().map(|(i, (text, fragments))| {
        let path = directory.path().join(format!("{i}.toml"));
        fs::write(&path, text).unwrap();
        (format!("{text:?}"), stiction(&["run", path.to_str().unwrap()]), fragments.to_vec())
    }));
}

#[test]
fn what_cannot_be_a_machine_s_file_is_refused_by_its_name() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = directory.path().join(name).to_str().unwrap().to_owned();
        fs::write(&path, bytes).unwrap();
        path
    };
    let absent = directory.path().join("absent.toml").to_str().unwrap().to_owned();
    let nested = format!("x = {}", "[".repeat(100_000));
    let cases: Vec<(String, &[&str])> = vec![
        (file("empty.toml", b""), &["the table `[joint]` is missing"]),
        (file("binary.toml", &[0x7f, 0x45, 0xfe, 0xff, 0x00]), &["cannot read", "not text"]),
        (file("huge.toml", &vec![b'#'; 2 << 20]), &["cannot read", "larger than 1 MiB"]),
        (file("nested.toml", nested.as_bytes()), &["line 1", "nested too deeply"]),
        (directory.path().to_str().unwrap().to_owned(), &["cannot read", "irectory"]),
        (absent, &["cannot read"]),
    ];
    assert_all_refused(cases.iter().map(|(path, fragments)| {
        (path.clone(), stiction(&["run", path]), [&[path.as_str()], *fragments].concat())
    }));
}

#[test]
fn names_that_do_not_exist_are_answered_with_the_nearest_or_with_all() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["run", "stepresponse"], &["no experiment `stepresponse`", "did you mean `step-response`?"]),
        (&["show", "trajektory"], &["no experiment `trajektory`", "did you mean `trajectory`?"]),
        (&["run", "qwerty"], &["no experiment `qwerty`", "`stiction list` shows them"]),
        (&["run", ""], &["no experiment ``", "`stiction list` shows them"]),
        (
            &["run", "step-response", "--controller", "srnff"],
            &["--controller srnff: ", "`srnff` in step-response", "did you mean `srnf`?"],
        ),
        (
            &["run", "high-gain", "--controller", "xyz"],
            &["`xyz` in high-gain", "allowed are dnpf, pd, ri, roi, srnf"],
        ),
        (&["run", "step-response", "--controller", "pd,,ri"], &["--controller pd,,ri: ", "no controller ``"]),
        (
            &["run", "step-response", "--controller", "pd,ri,pd"],
            &["--controller pd,ri,pd: ", "`pd` is there twice"],
        ),
        (&["run", "friction-identification", "--controller", "srnf"], &["`srnf`", "allowed is pd"]),
        (
            &["run", "step-response", "--solver", "euler"],
            &["`run.solver` is \"euler\"", "allowed are exact, rk4"],
        ),
        (&["run", "step-response", "--delay", "2"], &["`run.delay_samples` is 2", "allowed is 0 or 1"]),
    ];
    assert_all_refused(
        cases
            .iter()
            .map(|(arguments, fragments)| (arguments.join(" "), stiction(arguments), fragments.to_vec())),
    );
}

#[test]
fn a_run_that_would_take_for_ever_or_fill_the_memory_is_refused_before_it_begins() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["step-response", "--set", "run.duration_s=1e300"], &["`run.duration_s` is 1e300", "to 200000"]),
        // Allowed for one run, too much for all.
        (
            &["step-response", "--set", "run.duration_s=150000"],
            &["is 150000", "28 runs", "1e7 samples in all"],
        ),
        (
            &["step-response", "--solver", "rk4", "--set", "run.step_s=1e-300"],
            &["`run.step_s` is 1e-300", "1e10 steps"],
        ),
        (
            &["friction-identification", "--solver", "rk4", "--set", "run.step_s=1e-7"],
            &["`run.step_s` is 1e-7", "1e10 steps"],
        ),
        (
            &["friction-identification", "--set", "identification.ramp_rates_v_per_s=[1e-300]"],
            &["`identification.ramp_rates_v_per_s[0]` is 1e-300", "from 7.5e-6"],
        ),
        (
            &["friction-identification", "--set", "identification.ramp_rates_v_per_s=[1e-5, 1.1e-5]"],
            &["`identification.ramp_rates_v_per_s`", "1e8", "raise the rates"],
        ),
    ];
    assert_all_refused(cases.iter().map(|(arguments, fragments)| {
        let command = stiction(&[&["run"], *arguments].concat());
        (arguments.join(" "), command, fragments.to_vec())
    }));
    // The closed form makes no steps: their size is no reason to refuse it.
    let exact = stiction(&["run", "step-response", "--controller", "pd", "--set", "run.step_s=1e-300"]);
    assert!(answer(exact).unwrap().status.success());
}

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
    for arguments in [&["list"][..], &["list", "--json"], &["show", "trajectory"], &["run", "trajectory"]] {
        let mut command = stiction(arguments);
        let output = command.stdout(full()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let expected = "stiction: cannot write the output: No space left on device\n";
        assert_eq!((output.status.code(), said.as_str()), (Some(2), expected), "{arguments:?}");
    }
    let command = stiction(&["run", "step-response", "--controller", "pd", "--csv", "/dev/full"]);
    assert_eq!(complaint(command, &["cannot write /dev/full: No space left on device"]), None);

    // A file that may not grow beyond 4 KiB, as on a disk that fills up while it is written.
    let directory = tempfile::tempdir().unwrap();
    let csv = directory.path().join("run.csv");
    let csv = csv.to_str().unwrap();
    let limited = |blocks: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", "trap '' XFSZ; ulimit -f $1; shift; exec \"$@\"", "sh", blocks]);
        command.args([env!("CARGO_BIN_EXE_stiction"), "run", "step-response", "--controller", "pd"]);
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
        let mut child = stiction(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn an_unstable_run_is_reported_as_such_and_no_other() {
    let report = json(&["run", "step-response", "--controller", "pd", "--json"]);
    let unstable: Vec<&str> = report["runs"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|run| run["unstable"] == true)
        .map(|run| run["label"].as_str().unwrap())
        .collect();
    assert_eq!(unstable, ["pd/step-5.0/literal-si"]);
    assert!(report["runs"].as_array().unwrap().iter().all(|run| run["diverged_at_s"].is_null()));
    let table = stiction(&["run", "step-response", "--controller", "pd"]).output().unwrap();
    let table = String::from_utf8(table.stdout).unwrap();
    let remarks: Vec<&str> = table.lines().filter(|line| line.contains(": ")).collect();
    assert_eq!(remarks, ["pd/step-5.0/literal-si: unstable"]);
}

#[test]
fn a_run_whose_state_is_no_longer_finite_ends_and_says_when() {
    // So much acceleration overflows within the first sample: at once in closed form, after some steps of RK4.
    for (solver, gain) in [("exact", "1e308"), ("rk4", "1e300")] {
        let gain = format!("joint.gain_deg_per_s2_per_v={gain}");
        let directory = tempfile::tempdir().unwrap();
        let csv = directory.path().join("run.csv");
        let mut arguments = vec!["run", "step-response", "--controller", "pd", "--solver", solver];
        arguments.extend(["--set", &gain, "--set", "reference.steps_deg=[5.0]"]);
        let with = |more: &[&'static str]| {
            let all: Vec<&str> = arguments.iter().copied().chain(more.iter().copied()).collect();
            stiction(&all).output().unwrap()
        };
        let table = String::from_utf8(with(&[]).stdout).unwrap();
        assert!(table.contains("pd/step-5.0: diverged") && table.contains("0.02 s"), "{solver}: {table}");
        // Strict JSON has no NaN: this would not be read.
        let report: Value = serde_json::from_slice(&with(&["--json"]).stdout).unwrap();
        let run = &report["runs"][0];
        assert_eq!((run["diverged_at_s"].as_f64(), &run["unstable"]), (Some(0.02), &Value::Bool(true)));
        arguments.extend(["--csv", csv.to_str().unwrap()]);
        assert!(stiction(&arguments).output().unwrap().status.success());
        let csv = fs::read_to_string(&csv).unwrap();
        assert_eq!(csv.lines().count(), 2, "{solver}: the header and the sample before");
        assert!(!csv.contains("NaN") && !csv.contains("inf"), "{solver}: {csv}");
    }
}

/// Neither friction nor viscosity: nothing ends its motion but the bound of the ramp.
#[test]
fn a_ramp_on_a_joint_that_never_stops_ends_without_a_slip_level() {
    let set = [
        "joint.friction.slip_v=0",
        "joint.viscous_v_per_deg_per_s=0",
        "identification.ramp_rates_v_per_s=[0.1]",
    ];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_stiction"));
    command
        .args(["run", "friction-identification", "--json"])
        .args(set.iter().flat_map(|set| ["--set", set]));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let metrics = &report["runs"][0]["metrics"];
    assert!(metrics["stick_v"].is_number() && metrics["slip_v"].is_null(), "{metrics}");
}

#[cfg(not(feature = "emulator"))]
#[test]
fn the_emulator_is_named_with_the_command_that_builds_it_in() {
    let command = stiction(&["run", "step-response", "--target", "emulator"]);
    let complaint = complaint(command, &["--target emulator", "cargo build", "--features emulator"]);
    assert_eq!(complaint, None);
}

#[test]
fn what_is_not_built_in_is_named_with_the_command_that_builds_it_in() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let out = out.to_str().unwrap();
    let cases: [(bool, &str, &[&str]); 4] = [
        (
            cfg!(feature = "figures"),
            "figures",
            &["run", "step-response", "--controller", "pd", "--plot", out],
        ),
        (cfg!(feature = "figures"), "figures", &["benchmark", "--plot", out]),
        (cfg!(feature = "report"), "report", &["report", "--out", out]),
        (cfg!(feature = "watch"), "watch", &["device", "--simulated", "watch"]),
    ];
    assert_all_refused(cases.into_iter().filter(|(is_built_in, ..)| !is_built_in).map(
        |(_, feature, arguments)| {
            (arguments.join(" "), stiction(arguments), vec!["cargo build", "--features", feature])
        },
    ));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
