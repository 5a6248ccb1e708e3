//! `stiction report` as a person runs it makes a page that stands alone, with every figure beside
//! it.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::process::{Command, Stdio};

/// The figures of the thesis that are results.
fn results() -> BTreeSet<u32> {
    [5, 7, 9].into_iter().chain(11..=20).chain(26..=59).chain(61..=67).collect()
}

/// Finds what comes after each `mark`, up to the next quotation mark or bracket.
fn after<'a>(text: &'a str, mark: &'a str) -> impl Iterator<Item = &'a str> {
    text.match_indices(mark).map(move |(at, _)| {
        let rest = &text[at + mark.len()..];
        rest.split(['"', '\'', ')', '>', ' ']).next().unwrap_or_default()
    })
}

/// Finds the references that a browser would follow to load something. None may leave the file.
fn loaded(text: &str) -> Vec<&str> {
    let marks =
        ["src=\"", "srcset=\"", "href=\"", "data=\"", "poster=\"", "url(", "@import ", "fetch("];
    marks.into_iter().flat_map(|mark| after(text, mark)).filter(|to| !to.starts_with('#')).collect()
}

#[test]
fn the_report_stands_alone_and_has_every_figure_and_a_verdict_for_every_claim() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("report");
    let output = Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["report", "--out"])
        .arg(&out)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "no progress bar without a terminal");

    let page = fs::read_to_string(out.join("index.html")).unwrap();
    assert!(page.trim_end().ends_with("</html>"));
    assert_eq!(loaded(&page), Vec::<&str>::new());

    // Each drawing is there twice and whole, and nothing else is: no temporary file is left.
    let mut numbers = BTreeSet::new();
    let (mut svgs, mut pngs) = (BTreeSet::new(), BTreeSet::new());
    for entry in fs::read_dir(&out).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("html") => assert_eq!(stem, "index"),
            Some("svg") => {
                let text = fs::read_to_string(&path).unwrap();
                assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"), "{stem}");
                assert_eq!(loaded(&text), Vec::<&str>::new(), "{stem}");
                numbers.extend(stem.split('-').filter_map(|part| part.parse::<u32>().ok()));
                svgs.insert(stem);
            }
            Some("png") => {
                let bytes = fs::read(&path).unwrap();
                assert!(
                    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82"),
                    "{stem}"
                );
                pngs.insert(stem);
            }
            _ => unreachable!("{}", path.display()),
        }
    }
    assert_eq!(numbers, results());
    assert_eq!(svgs, pngs);

    // There are as many verdicts as the command says, and none without a measurement.
    let rows: Vec<&str> = page.split("<tr class=\"claim\"").skip(1).collect();
    let said_of = |what: &str| {
        let before = said.split(what).next().unwrap();
        let number = before.split_whitespace().next_back().unwrap();
        number.parse::<usize>().unwrap_or_else(|_| unreachable!("{said}"))
    };
    let verdicts = |class: &str| {
        rows.iter()
            .filter(|row| row.split("</tr>").next().unwrap().contains(&format!("verdict {class}")))
            .count()
    };
    let counts = ["holds", "in-part", "fails", "not-measured"].map(verdicts);
    assert_eq!(counts, [" hold,", " hold in", " do not,", " could"].map(said_of), "{said}");
    assert_eq!((counts.iter().sum::<usize>(), counts[3]), (rows.len(), 0));
    assert!(said.contains(&format!("{} figures", svgs.len())), "{said}");
}

fn stiction(arguments: &[&str]) -> std::process::Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// The page on a joint of one's own: it stands alone, has every law of the file, and what a
/// self-test should show is what `device selftest` predicts.
#[test]
fn a_joint_of_one_s_own_has_a_page_with_its_laws_and_what_the_bench_should_show() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    // A name with a point in it keeps all of it.
    let (file, out) = (path("arm.first.toml"), path("report"));
    assert!(stiction(&["new", &file, "--typical", "thesis"]).status.success());
    let made = stiction(&["report", &file, "--out", &out]);
    let said = String::from_utf8(made.stdout).unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(
        said.contains("arm.first.html") && said.contains("nothing has run on a motor"),
        "{said}"
    );
    let page = fs::read_to_string(directory.path().join("report/arm.first.html")).unwrap();
    assert!(page.trim_end().ends_with("</html>") && page.contains("Nothing has run on a motor."));
    assert_eq!(loaded(&page), Vec::<&str>::new());
    for part in
        ["<code>robust</code>", "<code>srnf</code>", "<code>pd</code>", "kg m^2", "load.inertia"]
    {
        assert!(page.contains(part), "{part}");
    }
    // The law that stands first is the one whose self-test is predicted.
    let (_, rest) = page.split_once("<h2>The law ").unwrap();
    let (chosen, _) = rest.split_once("</h2>").unwrap();
    let tested = ["device", "--simulated", "--machine", &file, "--controller", chosen, "selftest"];
    let tested = stiction(&[&tested[..], &["--json"]].concat());
    let tested: serde_json::Value = serde_json::from_slice(&tested.stdout).unwrap();
    let sliding =
        tested["checks"].as_array().unwrap().iter().find(|one| one["name"] == "sliding_v");
    let predicted = &sliding.unwrap()["predicted"];
    let (_, row) = page.split_once("sliding effort, mean (V)</td>").unwrap();
    let row = row.split("</tr>").next().unwrap();
    for name in ["least", "median", "largest"] {
        let value = format!("{:.3}", predicted[name].as_f64().unwrap());
        assert!(row.contains(&value), "{name}: {value}, and {row}");
    }
    // The page has its command, its law, and the parameters that a device needs first.
    let plain = page.replace("&#x2f;", "/");
    assert!(plain.contains(&format!("Made by <code>stiction report {file}</code>.")));
    assert!(page.contains(&format!("those of the law <code>{chosen}</code> with the gains of")));
    // What is asked of a file is not asked of the thesis.
    let refused = stiction(&["report", "--tuned", "--out", &out]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("FILE.toml"));
}

#[test]
fn a_page_of_tuned_laws_says_how_it_was_made_and_that_no_device_has_these_gains() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (file, out) = (path("arm.toml"), path("report"));
    assert!(stiction(&["new", &file, "--typical", "thesis"]).status.success());
    // One law is enough. On these joints tuning finds better gains for it.
    let text = fs::read_to_string(&file).unwrap();
    let names = text.lines().find(|line| line.starts_with("controller = ")).unwrap();
    fs::write(&file, text.replace(names, "controller = \"srnf\"")).unwrap();
    let asked = ["--tuned", "--goal", "settle", "--cases", "2", "--seed", "1000000"];
    let made = stiction(&[&["report", &file, "--out", &out], &asked[..]].concat());
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let page = fs::read_to_string(directory.path().join("report/arm.html")).unwrap();
    let page = page.replace("&#x2f;", "/");
    let made_by = format!("Made by <code>stiction report {file} {}</code>.", asked.join(" "));
    assert!(page.contains(&made_by), "{made_by}");
    let write =
        format!("stiction tune {file} --controller srnf {} --out NEW", asked[1..].join(" "));
    assert!(page.contains(&write), "{write}");
    assert!(page.contains("params push NEW.toml") && page.contains("NEW.toml selftest"));
}
