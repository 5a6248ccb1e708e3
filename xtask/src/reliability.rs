//! `cargo xtask reliability` runs the tests that measure, and writes their figures into
//! tests/evidence/reliability.md.
//!
//! A test prints a figure as `reliability: NAME | key=value | key=value`, on a line of its own, any
//! number of times. The template's text is copied; its lines
//!
//! ```text
//! ... {{NAME.key}} ...          get the value of the only line of that name,
//! {{#NAME}} ... {{key}} ...     are written for every line of that name, in their order,
//! {{*NAME}} ... {{key}} ... the same; there can be none, {{?NAME}} ... are written if there is a
//! line of that name, {{!NAME}} ... are written if there is none.
//! ```
//!
//! A figure that no test prints is an error, so all figures of the page are from the last run. A
//! figure without a place in the template is an error as well.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use crate::firmware::{self, Image};
use crate::job::{Job, cargo, root};
use crate::mutations;
use crate::simulator::EMULATOR;
use crate::toolchain::{MICROCONTROLLER, Toolchain};

const TEMPLATE: &str = "xtask/reliability.md";
const PAGE: &str = "tests/evidence/reliability.md";

/// Start of a figure's line. Libtest's own words precede it if the test is the only one of its
/// thread.
const MARK: &str = "reliability: ";

#[derive(Debug, clap::Args)]
pub struct ReliabilityJobArguments {
    /// Number of random messages through the state machine
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    messages: u64,
    /// Also the matrix of faults in the flash image: takes the emulator, and builds the firmware
    /// before
    #[arg(long)]
    image: bool,
    /// Run nothing, and read the figures from files with the output of these tests; can be repeated
    #[arg(long, value_name = "FILE", conflicts_with_all = ["image", "messages"])]
    from: Vec<std::path::PathBuf>,
}

/// A figure that a test printed: its name and values.
#[derive(Debug, PartialEq)]
struct Figure {
    name: String,
    values: Vec<(String, String)>,
}

/// Runs the tests, or reads their output, and writes the page.
pub fn measure(arguments: &ReliabilityJobArguments) -> Result<(), String> {
    let figures =
        if arguments.from.is_empty() { run(arguments)? } else { read_back(&arguments.from)? };
    let template = root().join(TEMPLATE);
    let text = fs::read_to_string(&template)
        .map_err(|error| format!("cannot read {TEMPLATE}: {error}"))?;
    let text = text.replace("{{commit}}", &mutations::commit()?);
    let page = filled(&text, &figures)?;
    fs::write(root().join(PAGE), page).map_err(|error| format!("cannot write {PAGE}: {error}"))?;
    println!("{PAGE}: {} figures", figures.len());
    if !figures.iter().any(|figure| figure.name == "image") {
        println!("{PAGE}: without those of the flash image, which --image measures");
    }
    Ok(())
}

/// Reads the figures of earlier runs.
fn read_back(files: &[std::path::PathBuf]) -> Result<Vec<Figure>, String> {
    let mut figures = Vec::new();
    for file in files {
        let text = fs::read_to_string(file)
            .map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        if !text.contains("test result: ok") {
            return Err(format!("{} is of no run that has passed", file.display()));
        }
        figures.extend(text.lines().filter_map(figure));
    }
    Ok(figures)
}

/// Runs the tests, and returns their output.
fn run(arguments: &ReliabilityJobArguments) -> Result<Vec<Figure>, String> {
    if arguments.image {
        Toolchain::agree(&MICROCONTROLLER)?;
    }
    // The features are those of all tests.
    let mut test = cargo(&["test", "--package", "loop-tests", "--test", "device"]);
    test.args(EMULATOR);
    let messages = arguments.messages.to_string();
    test.args(["--", "--nocapture", "--test-threads=1"]).env("STICTION_FUZZ", &messages);
    let mut figures =
        printed("Faults, bad encoders, power cuts, a soak and random messages", &mut test)?;
    if arguments.image {
        let image = firmware::build(Image::OneEncoder)?;
        let mut test = cargo(&["test", "--package", "loop-tests", "--test", "image"]);
        test.args(EMULATOR).args([
            "--",
            "matrix",
            "a_tick_that_stops",
            "--nocapture",
            "--test-threads=1",
        ]);
        figures
            .extend(printed("The matrix in the flash image", test.env("STICTION_IMAGE", image))?);
    }
    Ok(figures)
}

fn printed(what: &'static str, command: &mut std::process::Command) -> Result<Vec<Figure>, String> {
    Job::new(what).announce();
    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    let mut figures = Vec::new();
    for line in child
        .stdout
        .take()
        .into_iter()
        .flat_map(|out| BufReader::new(out).lines())
        .map_while(Result::ok)
    {
        println!("{line}");
        figures.extend(figure(&line));
    }
    match child.wait() {
        Ok(status) if status.success() => Ok(figures),
        Ok(status) => Err(format!("\"{what}\" failed ({status}); {PAGE} is as it was")),
        Err(error) => Err(format!("cannot wait for cargo: {error}")),
    }
}

fn figure(line: &str) -> Option<Figure> {
    let (_, row) = line.split_once(MARK)?;
    let mut parts = row.split(" | ");
    let name = parts.next()?.trim().to_owned();
    let pair = |part: &str| {
        part.split_once('=').map(|(key, value)| (key.trim().into(), value.trim().into()))
    };
    Some(Figure { name, values: parts.filter_map(pair).collect() })
}

fn filled(template: &str, figures: &[Figure]) -> Result<String, String> {
    all_have_a_place(template, figures)?;
    let mut page = String::new();
    for line in template.lines() {
        for line in lines(line, figures)? {
            page.push_str(&line);
            page.push('\n');
        }
    }
    Ok(page)
}

/// Refuses a printed value without a place on the page.
fn all_have_a_place(template: &str, figures: &[Figure]) -> Result<(), String> {
    for Figure { name, values } in figures {
        let [each, any] = ["#", "*"].map(|tag| format!("{{{{{tag}{name}}}}}"));
        for (key, _) in values {
            let alone = format!("{{{{{name}.{key}}}}}");
            let of_line = format!("{{{{{key}}}}}");
            let has_place = template.lines().any(|line| {
                let is_of_figure = line.starts_with(&each) || line.starts_with(&any);
                line.contains(&alone) || (is_of_figure && line.contains(&of_line))
            });
            if !has_place {
                return Err(format!("{TEMPLATE} has no place for `{key}` of `{MARK}{name}`"));
            }
        }
    }
    Ok(())
}

/// Fills a line of the template; it may become several, or none.
fn lines(line: &str, figures: &[Figure]) -> Result<Vec<String>, String> {
    let tagged = |tag: &str| {
        let (name, rest) = line.strip_prefix("{{")?.strip_prefix(tag)?.split_once("}}")?;
        Some((name, rest))
    };
    let named =
        |name: &str| figures.iter().filter(|figure| figure.name == name).collect::<Vec<_>>();
    if let Some((name, rest)) = tagged("*") {
        return named(name).into_iter().map(|figure| of_one(rest, figure)).collect();
    }
    if let Some((name, rest)) = tagged("#") {
        return match &named(name)[..] {
            [] => Err(format!("{TEMPLATE}: no test has printed `{MARK}{name}`")),
            all => all.iter().map(|figure| of_one(rest, figure)).collect(),
        };
    }
    let rest = match (tagged("?"), tagged("!")) {
        (Some((name, _)), _) if named(name).is_empty() => return Ok(vec![]),
        (_, Some((name, _))) if !named(name).is_empty() => return Ok(vec![]),
        (Some((_, rest)), _) | (_, Some((_, rest))) => rest,
        _ => line,
    };
    let value = |place: &str| {
        let (name, key) = place
            .split_once('.')
            .ok_or(format!("{TEMPLATE}: `{{{{{place}}}}}` names no figure"))?;
        match &named(name)[..] {
            [only] => of(only, key),
            all => Err(format!(
                "{TEMPLATE}: `{{{{{place}}}}}`: {} tests have printed `{MARK}{name}`",
                all.len()
            )),
        }
    };
    replaced(rest, value).map(|line| vec![line])
}

fn of_one(line: &str, figure: &Figure) -> Result<String, String> {
    replaced(line, |key| of(figure, key))
}

fn of(figure: &Figure, key: &str) -> Result<String, String> {
    let found =
        figure.values.iter().find(|(other, _)| other == key).map(|(_, value)| grouped(value));
    found.ok_or_else(|| format!("{TEMPLATE}: `{MARK}{}` has no `{key}`", figure.name))
}

fn replaced(line: &str, value: impl Fn(&str) -> Result<String, String>) -> Result<String, String> {
    let mut done = String::new();
    let mut rest = line;
    while let Some((before, tail)) = rest.split_once("{{") {
        let (place, after) =
            tail.split_once("}}").ok_or(format!("{TEMPLATE}: a `{{{{` without its end"))?;
        done.push_str(before);
        done.push_str(&value(place)?);
        rest = after;
    }
    Ok(done + rest)
}

/// Writes a large whole number in groups of three digits.
fn grouped(value: &str) -> String {
    if value.len() < 5 || !value.bytes().all(|byte| byte.is_ascii_digit()) {
        return value.into();
    }
    let digits: Vec<char> = value.chars().collect();
    let group = |(i, digit): (usize, &char)| {
        let space = i > 0 && (digits.len() - i).is_multiple_of(3);
        space.then_some(' ').into_iter().chain([*digit]).collect::<String>()
    };
    digits.iter().enumerate().map(group).collect()
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn figures_fill_the_template_and_none_may_be_missing() {
        let lines = [
            "test a ... reliability: soak | moves=12345",
            "reliability: wires | what=cut | s=0.2",
            "other",
            "reliability: wires | what=swapped | s=0.3",
        ];
        let figures: Vec<Figure> = lines.iter().filter_map(|line| figure(line)).collect();
        let template = "{{soak.moves}} moves\n{{#wires}}| {{what}} | {{s}} \
                        |\n{{?image}}with\n{{!image}}without";
        let page = "12 345 moves\n| cut | 0.2 |\n| swapped | 0.3 |\nwithout\n";
        assert_eq!(filled(template, &figures).as_deref(), Ok(page));
        // Every printed value has a place.
        for (line, key) in [("{{#wires}}{{what}} {{s}}", "moves"), ("{{soak.moves}}", "what")] {
            let said = filled(line, &figures).err().unwrap_or_default();
            assert!(said.contains("no place") && said.contains(key), "{said}");
        }
        let said = filled("{{soak.moves}}\n{{*wires}}{{s}}", &figures).err().unwrap_or_default();
        assert!(said.contains("`what` of `reliability: wires`"), "{said}");

        let places = "{{soak.moves}}\n{{#wires}}{{what}}{{s}}\n";
        let missing =
            ["{{soak.days}}", "{{none.x}}", "{{wires.s}}", "{{#none}}| {{x}} |", "{{x", "{{x}}"];
        for line in missing {
            assert!(filled(&format!("{places}{line}"), &figures).is_err(), "{line}");
        }
        assert!(filled(places, &figures).is_ok());
    }

    /// A test that prints what the page has no place for would spoil the run that writes the page.
    #[test]
    fn each_figure_that_a_test_prints_has_a_place() {
        let template = fs::read_to_string(root().join(TEMPLATE)).unwrap_or_default();
        let has_place = |name: &str| {
            ["#", "*"].iter().any(|tag| template.contains(&format!("{{{{{tag}{name}}}}}")))
                || template.contains(&format!("{{{{{name}."))
        };
        let listed = Command::new("git").args(["ls-files", "tests"]).current_dir(root()).output();
        let listed = String::from_utf8(listed.map_or_else(|_| vec![], |out| out.stdout));
        let mut printed = 0;
        for path in listed.unwrap_or_default().lines().filter(|path| path.ends_with(".rs")) {
            let text = fs::read_to_string(root().join(path)).unwrap_or_default();
            for call in text.split("reliability!(").skip(1) {
                let Some(name) = call.trim_start().strip_prefix('"') else { continue };
                let name = name.split('"').next().unwrap_or_default();
                assert!(has_place(name), "{path}: {TEMPLATE} has no place for `{name}`");
                printed += 1;
            }
        }
        assert!(printed > 30, "{printed} figures were found");
    }

    /// Returns the rows under a table's heading, split into cells.
    fn rows(text: &str) -> Vec<Vec<&str>> {
        let (_, after) =
            text.split_once("## Ways to run away that were closed").unwrap_or_default();
        let lines = after.lines().skip_while(|line| !line.starts_with("|---"));
        let rows = lines.skip(1).take_while(|line| line.starts_with('|'));
        rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
    }

    #[test]
    fn each_defect_of_the_safety_issue_has_tests_that_are_there() {
        let [template, page] =
            [TEMPLATE, PAGE].map(|path| fs::read_to_string(root().join(path)).unwrap_or_default());
        let rows_of_template = rows(&template);
        assert_eq!(rows(&page), rows_of_template, "{PAGE} is not what the template gives");
        let numbers: Vec<String> = (1..=13).map(|number| number.to_string()).collect();
        assert_eq!(rows_of_template.iter().map(|row| row[0]).collect::<Vec<_>>(), numbers);
        for row in rows_of_template {
            let [number, _, tests] = row[..] else { panic!("{row:?}") };
            for of_file in tests.split("; ") {
                let (path, names) = of_file.split_once(": ").unwrap_or_default();
                let text = fs::read_to_string(root().join(path.trim_matches('`')));
                let text = text.unwrap_or_else(|error| panic!("{number}: {path}: {error}"));
                for name in names.split(", ").map(|name| name.trim_matches('`')) {
                    // Some are in a macro of random cases, which gives them arguments.
                    assert!(text.contains(&format!("fn {name}(")), "{number}: {path}: {name}");
                }
            }
        }
    }
}
