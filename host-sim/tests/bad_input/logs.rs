//! Logs that identify no machine are refused: with the column, or the row as a spreadsheet counts
//! it.

use std::fmt::Write as _;
use std::fs;

use super::stiction;

/// A log of t, q, u by a function of the number, with a row that is replaced.
fn log(of: fn(f64) -> [f64; 2], replaced: Option<(u32, &str)>) -> String {
    let mut text = "t,q_rad,u\n".to_owned();
    for i in 0..4000u32 {
        let t = 1e-3 * f64::from(i);
        let [q, u] = of(t);
        match replaced {
            Some((row, line)) if row == i + 2 => text += &format!("{line}\n"),
            _ => {
                let _ = writeln!(text, "{t:.4},{q:.9},{u:.6}");
            }
        }
    }
    text
}

/// A machine of inertia 0.5 with friction of 1, in closed form.
fn machine(t: f64) -> [f64; 2] {
    let v = 2.0 * (4.0 * t).cos() + (9.0 * t).cos();
    let a = -8.0 * (4.0 * t).sin() - 9.0 * (9.0 * t).sin();
    [0.5 * (4.0 * t).sin() + (9.0 * t).sin() / 9.0, 0.5 * a + v.signum() + 0.3 * v]
}

/// Returns the error of a log that must be refused, with nothing on the standard output.
fn refusal(text: &str, options: &[&str]) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, text).unwrap();
    let columns = ["--time", "t", "--position", "q_rad", "--effort", "u"];
    let left = columns.chunks(2).filter(|pair| !options.contains(&pair[0]));
    let columns: Vec<&str> = left.flatten().copied().collect();
    let path = path.to_str().unwrap();
    let output = stiction(&[&["identify", path], &columns[..], options].concat()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), &*output.stdout), (Some(2), &b""[..]), "{said}");
    said
}

#[test]
fn a_log_that_identifies_no_machine_is_refused_with_its_column_or_row() {
    let good = log(machine, None);
    let row = |line| log(machine, Some((1000, line)));
    let again = row("0.5,0,0");
    // The sample of 0.998 s once more says 0.997 s; the times have four digits.
    let [q, u] = machine(0.998);
    let line = format!("0.9970,{q:.9},{u:.6}");
    let twice = log(machine, Some((1000, &line)));
    let word = row("0.9980,0.1,twelve");
    let holes: String = good
        .lines()
        .enumerate()
        .map(|(i, line)| if i % 5 == 4 { ",,\n".into() } else { format!("{line}\n") })
        .collect();
    let short: String = good.lines().take(40).map(|line| format!("{line}\n")).collect();
    let one_way = log(|t| [t + 0.1 * (3.0 * t).sin(), 1.0 + (3.0 * t).sin()], None);
    let still = log(|t| [0.3, t.sin()], None);
    let idle = log(|t| [t.sin(), 0.3], None);
    let cases: &[(&str, &[&str], &[&str])] = &[
        (
            &good,
            &["--position", "q_rd"],
            &["no column `q_rd`", "did you mean `q_rad`?", "t, q_rad, u"],
        ),
        (&good, &["--effort", "t"], &["name the same column"]),
        (&good, &["--motor-position", "q_rad"], &["--motor-position name the same column"]),
        (&good, &["--motor-position", "nothing"], &["no column `nothing`"]),
        (
            &good,
            &["--motor-position", "u", "--motor-position-unit", "mm"],
            &["--motor-position-unit must be rad, deg or count"],
        ),
        (&again, &[], &["row 1000:", "0.5", "increase"]),
        (&twice, &[], &["row 1000:", "that of the row before"]),
        (&word, &[], &["row 1000:", "`twelve`", "column `u`"]),
        (&holes, &[], &["lack a number", "the first is row 5", "a tenth"]),
        (&short, &[], &["39 rows", "at least 100"]),
        (&one_way, &[], &["move the negative way", "both ways"]),
        (&still, &[], &["the position never changes"]),
        (&idle, &[], &["the effort never changes"]),
        (&good, &["--effort-gain", "-1"], &["negative", "opposite directions"]),
        (&good, &["--cut-off", "0"], &["--cut-off is 0", "at most"]),
        (&good, &["--cut-off", "400"], &["--cut-off is 400", "125"]),
        (&good, &["--effort-gain", "0"], &["--effort-gain 0: must be"]),
        (&good, &["--time-unit", "h"], &["--time-unit h: must be", "s, ms, us, ns"]),
        (&good, &["--position-unit", "count"], &["needs --counts-per-turn"]),
        (&good, &["--into", "never.toml"], &["--effort-gain"]),
        (&good, &["--position-unit", "mm", "--into", "never.toml"], &["along a line"]),
        (&good, &["--position-unit", "m", "--gravity"], &["--gravity", "along a line"]),
        ("t,q_rad,u\n", &[], &["0 rows"]),
    ];
    for (text, options, parts) in cases {
        let said = refusal(text, options);
        for part in *parts {
            assert!(said.contains(part), "{options:?}: `{part}` is not in: {said}");
        }
    }
    assert!(!std::path::Path::new("never.toml").exists());
}

/// Blank lines and comments are rows of a spreadsheet, and lines may end in any of three ways. A
/// break inside quotes is none.
#[test]
fn a_refusal_counts_rows_as_a_spreadsheet_does_however_lines_end() {
    let rows = log(machine, None);
    let (_, rows) = rows.split_once('\n').unwrap();
    let header = "t,q_rad,u,\"a note\nin two lines\"";
    for end in ["\n", "\r\n", "\r"] {
        for (header, counted) in [("t,q_rad,u", 5), (header, 5)] {
            let begin = format!("# made by hand\n\n\n# and again\n{header}\n");
            let mut text = begin.replace('\n', end);
            let mut row = counted;
            for (i, line) in rows.lines().enumerate() {
                // A blank line and a comment stand before the row that is no number.
                let more = match i {
                    2000 => vec!["", "# here it comes", "0.5,0.1,twelve"],
                    _ => vec![line],
                };
                for line in more {
                    text += &format!("{line}{end}");
                    row += u32::from(i <= 2000);
                }
            }
            let said = refusal(&text, &[]);
            assert!(said.contains(&format!("row {row}: `twelve`")), "{end:?}, {row}: {said}");
        }
    }
    // The last line needs no end.
    let said = refusal(&(rows.to_owned() + "5,0.1,twelve"), &NUMBERS);
    assert!(said.contains("row 4001: `twelve`"), "{said}");
}

/// The columns of a file without a header.
const NUMBERS: [&str; 6] = ["--time", "1", "--position", "2", "--effort", "3"];

/// Implausible data that can be handled is reported beside the result.
#[test]
fn implausible_units_are_reported() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, log(machine, None)).unwrap();
    let path = path.to_str().unwrap();
    let columns = ["--time", "t", "--position", "q_rad", "--effort", "u"];
    for (options, parts) in [
        (["--time-unit", "us"], ["the sample time is", "--time-unit"]),
        (["--time-unit", "1000"], ["the sample time is", "--time-unit"]),
        (["--time-unit", "1e-6"], ["top speed", "--position-unit"]),
    ] {
        let arguments = [&["identify", path], &columns[..], &options[..]].concat();
        let output = stiction(&arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(parts.iter().all(|part| said.contains(part)), "{options:?}: {said}");
    }
}

/// Returns the warnings about an accepted log, and the result as an object.
fn accepted(text: &str, options: &[&str]) -> (String, serde_json::Value) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let arguments = [&["identify", path, "--json", "--time", "t", "--effort", "u"], options];
    let output = stiction(&arguments.concat()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{options:?}: {said}");
    (said, serde_json::from_slice(&output.stdout).unwrap())
}

/// An axis of 80 kg on guides whose friction is 0.022 of its weight, in closed form.
fn axis(t: f64) -> [f64; 2] {
    let v = 0.4 * (4.0 * t).cos() + 0.2 * (9.0 * t).cos();
    let a = -1.6 * (4.0 * t).sin() - 1.8 * (9.0 * t).sin();
    let q = 0.1 * (4.0 * t).sin() + 0.2 * (9.0 * t).sin() / 9.0;
    [q, 80.0 * a + 17.0 * v.signum() + 150.0 * v]
}

#[test]
fn an_impossible_position_unit_is_reported_and_a_possible_one_is_not() {
    let metres = log(axis, None).replace("q_rad", "q");
    let millimetres = log(|t| axis(t).map(|one| 1e3 * one), None).replace("q_rad", "q");
    let newtons = |gain: &'static str, unit: &'static str| {
        ["--position", "q", "--position-unit", unit, "--effort-gain", gain]
    };
    for (text, options) in [(&metres, newtons("1", "m")), (&millimetres, newtons("1e-3", "mm"))] {
        let (said, found) = accepted(text, &options);
        assert_eq!((said.as_str(), &found["warnings"]), ("", &serde_json::json!([])));
        let mass = found["parameters"]["inertia"]["value"].as_f64().unwrap();
        assert!((mass / 80.0 - 1.0).abs() < 0.01, "{found}");
        // 0.1 sin 4t + 0.022 sin 9t is up to 0.122 m to either side.
        let travel = found["log_read"]["travel"].as_f64().unwrap();
        assert!((0.22..=0.2445).contains(&travel), "{travel}");
    }
    // 80 t on guides with a friction of 17 N; 600 m/s, a travel of 240 m and 80 g.
    let (said, _) = accepted(&metres, &newtons("1", "mm"));
    assert!(said.contains("times the weight") && said.contains("--position-unit"), "{said}");
    let (said, _) = accepted(&millimetres, &newtons("1e-3", "m"));
    assert!(said.contains("top speed") && said.contains("--position-unit"), "{said}");
    // A stroke of 7 um is within the bristles; a gain in the wrong power of ten, too light.
    let crept = log(|t| axis(t).map(|one| 3e-5 * one), None).replace("q_rad", "q");
    let (said, _) = accepted(&crept, &newtons("1", "m"));
    assert!(said.contains("the travel is"), "{said}");
    let (said, _) = accepted(&metres, &newtons("1e-9", "m"));
    assert!(said.contains("the inertia is") && said.contains("kg"), "{said}");
}

#[test]
fn a_name_that_contradicts_the_unit_and_an_effort_without_a_unit_are_reported_as_text_and_json() {
    let text = log(machine, None);
    let degrees = text.replace("q_rad", "q_deg");
    let (said, found) = accepted(&degrees, &["--position", "q_deg", "--position-unit", "rad"]);
    assert!(said.contains("is in deg by its name, but --position-unit is rad"), "{said}");
    assert!(found["warnings"].to_string().contains("is in deg by its name"), "{found}");
    let (said, _) = accepted(&text, &["--position", "q_rad", "--position-unit", "rad"]);
    assert_eq!(said, "");
    // A unit that the log does not name, and no machine excludes.
    let bare = text.replace("q_rad", "q");
    let (_, found) = accepted(&bare, &["--position", "q"]);
    assert!(found["warnings"].to_string().contains("read as rad"), "{found}");
    assert_eq!(found["effort_unit_is_assumed"], false);
    // A line without a gain: kg and N are a guess.
    let line = ["--position", "q", "--position-unit", "m"];
    let (said, found) = accepted(&bare, &line);
    assert!(said.contains("assumed to be 1 N") && said.contains("--effort-gain"), "{said}");
    assert_eq!(
        (&found["effort_unit_is_assumed"], &found["effort_gain"], &found["units"]["inertia"]),
        (&true.into(), &serde_json::Value::Null, &"kg".into())
    );
    let (said, found) = accepted(&bare, &[&line[..], &["--effort-gain", "2"]].concat());
    assert_eq!((said.as_str(), &found["effort_gain"]), ("", &2.0.into()));
    // The table has it, too.
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, &bare).unwrap();
    let columns = ["identify", path.to_str().unwrap(), "--time", "t", "--effort", "u"];
    let output = stiction(&[&columns[..], &line].concat()).output().unwrap();
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("units       assumed: the unit of the effort is 1 N"), "{table}");
}

/// The result of a log, with the columns named by the options.
fn found(text: &[u8], options: &[&str]) -> (String, serde_json::Value) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, text).unwrap();
    let arguments = [&["identify", path.to_str().unwrap(), "--json"], options].concat();
    let output = stiction(&arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{options:?}: {said}");
    (said, serde_json::from_slice(&output.stdout).unwrap())
}

const COLUMNS: [&str; 6] = ["--time", "t", "--position", "q_rad", "--effort", "u"];

fn inertia(found: &serde_json::Value) -> f64 {
    found["parameters"]["inertia"]["value"].as_f64().unwrap()
}

#[test]
fn a_comma_for_columns_and_decimals_alike_is_refused_as_what_it_is() {
    let text = log(machine, None);
    let (header, rows) = text.split_once('\n').unwrap();
    let rows = rows.replace('.', ",");
    for (text, options) in [(format!("{header}\n{rows}"), &[][..]), (rows.clone(), &NUMBERS)] {
        let said = refusal(&text, options);
        for part in ["commas separate both columns and decimals", "semicolons", "row "] {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
    // With semicolons between the columns, the same commas are decimals.
    let text = text.replace(',', ";").replace('.', ",");
    let (said, found) = found(text.as_bytes(), &COLUMNS);
    assert!((inertia(&found) - 0.5).abs() < 0.01 && said.is_empty(), "{said}");
}

#[test]
fn rows_with_more_cells_than_the_header_are_left_out_counted_and_reported() {
    let text = log(machine, None);
    let with = |every: usize| -> String {
        let long = |(i, line): (usize, &str)| {
            // A shifted row, whose numbers would be those of other columns.
            let more = if i > 0 && i % every == 0 { "7.5," } else { "" };
            format!("{more}{line},,\n")
        };
        text.lines().enumerate().map(long).collect()
    };
    // The empty cells at the end are no reason.
    let (said, whole) = found(with(1000).replace("u,,\n", "u\n").as_bytes(), &COLUMNS);
    assert!(said.contains("4 rows have more cells than the first row of the file"), "{said}");
    assert!(said.contains("the first is row 1001 with 4"), "{said}");
    assert_eq!(whole["log_read"]["long_rows"], 4);
    assert!((inertia(&whole) - 0.5).abs() < 0.01, "{whole}");
    let said = refusal(&with(5).replace("u,,\n", "u\n"), &[]);
    for part in ["800 of 4000 rows", "row 6 has 4, the first row 3", "a tenth", "name each column"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn utf_16_is_read_by_its_mark_and_named_without_it() {
    let text = log(machine, None);
    let (_, truth) = found(text.as_bytes(), &COLUMNS);
    let units = || std::iter::once(0xFEFF).chain(text.encode_utf16());
    let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
    for bytes in [&little, &big] {
        let (_, found) = found(bytes, &COLUMNS);
        assert_eq!(found["parameters"], truth["parameters"]);
    }
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    fs::write(&path, &little[2..]).unwrap();
    let arguments = [&["identify", path.to_str().unwrap()], &COLUMNS[..]].concat();
    let output = stiction(&arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains("UTF-16 without a byte order mark"),
        "{said}"
    );
}

#[test]
fn units_in_brackets_behind_the_names_of_columns_are_read() {
    let mut text = "t [ms];q [\u{b0}];u [A]\n".to_owned();
    for i in 0..4000u32 {
        let t = 1e-3 * f64::from(i);
        let [q, u] = machine(t);
        let _ = writeln!(text, "{i};{:.7};{u:.6}", q.to_degrees());
    }
    let columns = ["--time", "t [ms]", "--position", "q [\u{b0}]", "--effort", "u [A]"];
    let (said, whole) = found(text.as_bytes(), &columns);
    assert_eq!(said, "");
    assert!((inertia(&whole) - 0.5).abs() < 0.01, "{whole}");
    // As a spreadsheet of Windows writes it.
    let one_byte: Vec<u8> = text.chars().map(|c| u8::try_from(c).unwrap()).collect();
    let (said, old) = found(&one_byte, &columns);
    assert_eq!((said.as_str(), &old["parameters"]), ("", &whole["parameters"]));
    // An option that says otherwise counts, and is named.
    let (said, _) = found(text.as_bytes(), &[&columns[..], &["--time-unit", "us"]].concat());
    assert!(said.contains("is in ms by its name, but --time-unit is us"), "{said}");
}

/// A useless result is not called good.
#[test]
fn a_value_far_out_of_what_is_built_makes_the_verdict_poor() {
    let text = log(machine, None);
    let quality = |options: &[&str]| {
        let (_, found) = found(text.as_bytes(), &[&COLUMNS[..], options].concat());
        let quality = found["verdict"]["quality"].as_str().unwrap().to_owned();
        (quality, found["verdict"]["doubts"].to_string())
    };
    assert_eq!(quality(&["--effort-gain", "1"]).0, "good");
    // Samples of 1000 s; an inertia of 2.5e10 kg m^2.
    for (options, words) in [
        (["--time-unit", "1e6"], "the sample time is 1000 s"),
        (["--effort-gain", "5e10"], "the inertia is"),
    ] {
        let (quality, doubts) = quality(&options);
        assert!(quality == "poor" && doubts.contains(words), "{options:?}: {quality} {doubts}");
    }
    // Within a factor of ten of the bounds, it is to be used with care: samples of 0.2 s, whose
    // speeds of 0.02 rad/s exist.
    let (quality, doubts) = quality(&["--time-unit", "200"]);
    assert!(quality == "fair" && doubts.contains("sample time is 0.2 s"), "{quality} {doubts}");
}
