//! A machine's file may have a wrong value, be no TOML, or be no text at all.

use std::fs;

use super::refusal::assert_all_refused;
use super::{shown, stiction};

#[test]
fn a_file_with_a_mistake_is_named_with_the_key() {
    const STEP: &str = "step-response";
    const PATH: &str = "trajectory";
    const CORNERS: &str = "[[reference.trajectories]]";
    const TIMES: &str = "[1.0, 11.0, 13.0, 23.0]";
    const PLACES: &str = "[0.0, 25.0, 25.0, 0.0]";
    // Each case edits a built-in experiment: it names the text that is replaced, and what stands
    // there instead.
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (STEP, "title = \"Steps", "title = 3 # \"", &["`title` is 3; must be a text in quotes"]),
        (
            STEP,
            "kp_v_per_deg = 1.0",
            "kp_v_per_deg = nan",
            &["`controller.pd.kp_v_per_deg` is NaN"],
        ),
        (
            STEP,
            "kp_v_per_deg = 1.0",
            "kp_v_per_deg = -1.0",
            &["`controller.pd.kp_v_per_deg` is -1"],
        ),
        (STEP, "kp_v_per_deg = 1.0\n", "", &["`controller.pd.kp_v_per_deg` is missing"]),
        // All missing keys are reported at once.
        (
            STEP,
            "full_scale_v = 5.0\nlsb_v = 0.00488",
            "",
            &["`drive.full_scale_v` is missing, and so is `drive.lsb_v`"],
        ),
        (
            STEP,
            "sample_time_s = 0.02 ",
            "sample_time_ms = 20 ",
            &["`loop.sample_time_ms`", "`sample_time_s`?"],
        ),
        (
            STEP,
            "sample_time_s = 0.02 ",
            "sample_time_s = 0 ",
            &["`loop.sample_time_s` is 0", "above 0"],
        ),
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
            &["`encoder.counter_bits` is 99999; must be one of 16, 32"],
        ),
        (
            STEP,
            "mode = \"locked-antiphase\"",
            "mode = \"locked\"",
            &["is \"locked\"", "`locked-antiphase`?"],
        ),
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
        (
            STEP,
            "\"joint.gain_deg_per_s2_per_v\"",
            "gain",
            &["variant `literal-si`", "`gain` names no table"],
        ),
        (
            STEP,
            "= 1546.986",
            "= -3",
            &["variant `literal-si`: `joint.gain_deg_per_s2_per_v` is -3", "above 0"],
        ),
        (
            STEP,
            "= 1546.986",
            "= \"x\"",
            &["variant `literal-si`: `joint.gain_deg_per_s2_per_v` is \"x\""],
        ),
        (
            STEP,
            "slug = \"literal-si\"",
            "slugg = \"x\"",
            &["unknown key `variant[1].slugg`", "`slug`?"],
        ),
        (STEP, "slug = \"literal-si\"", "slug = \"a/b\"", &["`slug`", "\"a/b\"", "must be 1 to"]),
        (
            STEP,
            "\"literal-si\"\nset = {",
            "\"\"\nset = { \"run.step\" = 1,",
            &["variant 2: unknown key `run.step`"],
        ),
        (
            STEP,
            "[controller.pd]",
            "[controller.\"../x\"]",
            &["controller", "\"../x\"", "must be 1 to"],
        ),
        (STEP, "[controller.pd]", "[controller.\"\"]", &["controller", "\"\"", "1 to 20 letters"]),
        (STEP, "[controller.pd]", "[controller.abcdefghijklmnopqrstu]", &["1 to 20 letters"]),
        (
            STEP,
            "controller = [\"pd\", ",
            "controller = [\"mine\", ",
            &["`loop.controller` names `mine`"],
        ),
        // Trajectories and sines.
        (
            PATH,
            TIMES,
            "[1.0, 11.0, 23.0]",
            &["trajectories[0].corner_positions_deg` has 4 entries", "(3)"],
        ),
        (
            PATH,
            TIMES,
            "[1.0, 11.0, 9.0, 23.0]",
            &["trajectories[0].corner_times_s[2]` is 9", "from 11.5"],
        ),
        (PATH, TIMES, "[0.1, 11.0, 13.0, 23.0]", &["corner_times_s[0]` is 0.1", "from 0.25"]),
        (PATH, TIMES, "[1.0, nan, 13.0, 23.0]", &["corner_times_s[1]` is NaN", "from 1.5"]),
        (PATH, TIMES, "[1.0, 11.0, 13.0, inf]", &["corner_times_s[3]` is inf", "a finite number"]),
        (PATH, TIMES, "[1.0, 11.0, 13.0, 1e300]", &["corner_times_s[3]` is 1e300", "to 200000"]),
        (PATH, TIMES, "[]", &["corner_times_s` has 0 entries; must have 2 to 16"]),
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
        (
            PATH,
            PLACES,
            "[0.0, 50.0, 50.0, 0.0]",
            &["`pd/trajectory-5.0`", "need different sizes, speeds and slugs"],
        ),
        (
            PATH,
            "half_blend_s = 0.25",
            "half_blend_s = nan",
            &["`reference.trajectories[0].half_blend_s` is NaN", "half a sample"],
        ),
        (
            PATH,
            "half_blend_s = 0.25\n",
            "",
            &["`reference.trajectories[0].half_blend_s` is missing"],
        ),
        (
            PATH,
            CORNERS,
            "[[reference.sines]]\namplitude_deg = 0.0\nfrequency_hz = 1.0\n\
             [[reference.trajectories]]",
            &["amplitude_deg` is 0", "other than 0"],
        ),
        (
            PATH,
            CORNERS,
            "[[reference.sines]]\namplitude_deg = 1e12\nfrequency_hz = 1.0\n\
             [[reference.trajectories]]",
            &["amplitude_deg` is 1000000000000", "2^29"],
        ),
        (
            PATH,
            CORNERS,
            "[[reference.sines]]\namplitude_deg = 1.0\nfrequency_hz = nan\n\
             [[reference.trajectories]]",
            &["frequency_hz` is NaN", "from 5e-6"],
        ),
        (
            PATH,
            CORNERS,
            "[[reference.sines]]\namplitude_deg = 1.0\nfrequency_hz = 13\n\
             [[reference.trajectories]]",
            &["frequency_hz` is 13", "to 12.5 (a qu"],
        ),
    ];
    let directory = tempfile::tempdir().unwrap();
    let files: Vec<String> = (0..cases.len()).map(|i| format!("a joint {i}.toml")).collect();
    assert_all_refused(cases.iter().zip(&files).map(
        |((experiment, from, to, fragments), file)| {
            let text = shown(experiment);
            assert!(text.contains(from), "{experiment} does not hold {from:?}");
            let path = directory.path().join(file);
            fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let name = format!("{experiment} with {to:?} for {from:?}");
            (
                name,
                stiction(&["run", path.to_str().unwrap()]),
                [&[file.as_str()], *fragments].concat(),
            )
        },
    ));
}

#[test]
fn what_is_not_toml_is_named_with_its_line() {
    let cases: &[(&str, &[&str])] = &[
        ("title = \"x\"\n[joint\n", &["line 2: unclosed table, expected `]`"]),
        ("[joint]\na = 1\n\na = 2\n", &["line 4: `a` is set twice"]),
        ("[joint]\n[run]\n[joint]\n", &["line 3: `joint` is set twice"]),
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
