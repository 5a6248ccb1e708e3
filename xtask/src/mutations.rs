//! `cargo xtask mutations` puts one fault after another into a copy of the sources, and runs the
//! tests that should find it. A fault that no test finds is a missing test.
//!
//! The faults are a fixed list (`mutation_list.rs`): each monitor, and each line of the board's
//! part that keeps a motor safe. cargo-mutants generates faults of functions and operators; most of
//! those lines are writes to registers and thresholds, which it does not change, and the image must
//! be built and emulated to find them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::ValueEnum;

use crate::job::{Job, root, target_dir};
use crate::mutation_list::{Mutation, Suite, mutations};

const PAGE: &str = "tests/evidence/mutations.md";

#[derive(Debug, clap::Args)]
pub struct MutationsJobArguments {
    /// Only faults whose file or reason contains this text; can be repeated
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
    /// Only faults that these tests should find
    #[arg(long)]
    suite: Option<Suite>,
    /// Only check that every fault still fits the sources
    #[arg(long)]
    check: bool,
}

/// Result of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Killed,
    Survived,
    /// The compiler refuses it, so it proves nothing.
    NotBuilt,
    NotRun,
}

/// End of a row: the result of a fault, and its commit.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Outcome {
    fate: Fate,
    commit: String,
}

impl Fate {
    const ALL: [Self; 4] = [Self::Killed, Self::Survived, Self::NotBuilt, Self::NotRun];

    const fn describe(self) -> &'static str {
        match self {
            Self::Killed => "found",
            Self::Survived => "**not found**",
            Self::NotBuilt => "not built",
            Self::NotRun => "not run",
        }
    }
}

/// Runs the selected faults, and writes the page.
pub fn run(arguments: &MutationsJobArguments) -> Result<(), String> {
    for mutation in mutations() {
        let path = root().join(mutation.file);
        mutated(&path, mutation)?;
    }
    if arguments.check {
        println!("{} faults, and each fits the sources", mutations().count());
        return Ok(());
    }
    let tree = target_dir().join("mutations").join("tree");
    copy(&tree)?;
    let asked: Vec<bool> = mutations()
        .map(|mutation| {
            let named =
                |text: &String| mutation.file.contains(&**text) || mutation.why.contains(&**text);
            (arguments.only.is_empty() || arguments.only.iter().any(named))
                && arguments.suite.is_none_or(|suite| suite == mutation.suite)
        })
        .collect();
    for &suite in Suite::value_variants() {
        let of_suite = mutations().zip(&asked).filter(|(m, asked)| **asked && m.suite == suite);
        let mut tests: Vec<&str> = of_suite.flat_map(|(m, _)| m.tests).copied().collect();
        if tests.is_empty() {
            continue;
        }
        tests.sort_unstable();
        tests.dedup();
        Job::new("The tests of these faults pass without a fault").announce();
        for test in tests {
            match tested(&tree, suite, &[test])? {
                Fate::Survived => {}
                _ => {
                    return Err(format!(
                        "`{test}` fails without a fault, or does not exist; check its name, and \
                         make it pass"
                    ));
                }
            }
        }
    }
    let (path, commit) = (root().join(PAGE), commit()?);
    let before = fs::read_to_string(&path).unwrap_or_default();
    let mut outcomes: Vec<Outcome> =
        mutations().map(|mutation| earlier_outcome(&before, mutation)).collect();
    let mut survived = 0;
    for ((mutation, asked), outcome) in mutations().zip(asked).zip(0..) {
        if !asked {
            continue;
        }
        let fate = one(&tree, mutation)?;
        println!("{:>13}  {}: {}", fate.describe(), mutation.file, mutation.why);
        survived += usize::from(fate == Fate::Survived);
        outcomes[outcome] = Outcome { fate, commit: commit.clone() };
        // A run takes long: if it is interrupted, the page has the results so far.
        fs::write(&path, page(&outcomes))
            .map_err(|error| format!("cannot write {PAGE}: {error}"))?;
    }
    if survived > 0 {
        Err(format!(
            "no test failed for {survived} of the faults that were put in; add tests for them"
        ))
    } else {
        Ok(())
    }
}

/// Puts a fault into the copy, runs its tests, and restores the copy.
fn one(tree: &Path, mutation: &Mutation) -> Result<Fate, String> {
    let path = tree.join(mutation.file);
    let (sound, faulty) = mutated(&path, mutation)?;
    let write = |text: &str| {
        fs::write(&path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))
    };
    write(&faulty)?;
    let fate = tested(tree, mutation.suite, mutation.tests);
    write(&sound)?;
    fate
}

/// Reads a file, and returns it without and with a fault.
fn mutated(path: &Path, mutation: &Mutation) -> Result<(String, String), String> {
    let Mutation { file, before, after, why, .. } = *mutation;
    let sound = fs::read_to_string(path).map_err(|error| format!("cannot read {file}: {error}"))?;
    match sound.matches(before).count() {
        1 => Ok((sound.clone(), sound.replace(before, after))),
        found => Err(format!(
            "the list of faults is out of date: {file} has {found} times, and not once, the text \
             of \
             \"{why}\": {before}"
        )),
    }
}

/// Copies the files that git tracks, and new ones that are not ignored.
fn copy(tree: &Path) -> Result<(), String> {
    let listed = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"])
        .current_dir(root())
        .output()
        .map_err(|error| format!("cannot start git: {error}"))?;
    let listed = String::from_utf8(listed.stdout).map_err(|error| error.to_string())?;
    let mut copied = BTreeSet::new();
    for name in listed.split_terminator('\0') {
        let (from, to) = (root().join(name), tree.join(name));
        let Ok(bytes) = fs::read(&from) else { continue };
        copied.insert(to.clone());
        // An unchanged file keeps its time, so that it is not built again.
        if fs::read(&to).is_ok_and(|there| there == bytes) {
            continue;
        }
        let made =
            to.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&to, bytes));
        made.map_err(|error| format!("cannot write {}: {error}", to.display()))?;
    }
    remove_others(tree, &copied).map_err(|error| format!("{}: {error}", tree.display()))
}

/// Removes what an earlier copy has left: a module that has moved would be there twice.
fn remove_others(folder: &Path, copied: &BTreeSet<PathBuf>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            remove_others(&path, copied)?;
        } else if !copied.contains(&path) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

/// Runs the tests of a suite in the copy.
fn tested(tree: &Path, suite: Suite, tests: &[&str]) -> Result<Fate, String> {
    let cargo = |arguments: &[&str]| {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(arguments).current_dir(tree).env("CARGO_TARGET_DIR", built(tree));
        if !matches!(suite, Suite::Device | Suite::Image) {
            // A fault is compiled once and runs for a second.
            command.env("CARGO_PROFILE_DEV_OPT_LEVEL", "0").env("CARGO_PROFILE_DEV_DEBUG", "0");
        }
        command
    };
    let output_of = |command: &mut Command| {
        let output = command.stdin(Stdio::null()).output();
        output.map_err(|error| format!("cannot start cargo: {error}"))
    };
    let target = match suite {
        Suite::Core => ["stiction", "--lib"].as_slice(),
        Suite::Contracts => &["stiction", "--test", "contracts"],
        Suite::SignalPath => &["stiction", "--test", "signal_path"],
        Suite::Robust => &["stiction", "--test", "robust"],
        Suite::Device => &["loop-tests", "--test", "device"],
        Suite::Image => &[],
    };
    let [mut build, mut test] = match suite {
        Suite::Image => [["firmware"], ["image"]]
            .map(|job| cargo(&[&["run", "--package", "xtask", "--"], &job[..]].concat())),
        _ => [["test", "--no-run", "--package"].as_slice(), &["test", "--package"]]
            .map(|command| cargo(&[command, target].concat())),
    };
    if !output_of(&mut build)?.status.success() {
        return Ok(Fate::NotBuilt);
    }
    if suite != Suite::Image {
        test.arg("--");
    }
    let output = output_of(test.args(tests))?;
    let text = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Ok(Fate::Killed);
    }
    // A filter that matches no test would let every fault survive.
    let ran = text.lines().any(|line| line.starts_with("test ") && line.ends_with("ok"));
    if ran { Ok(Fate::Survived) } else { Err(format!("no test has a name with one of {tests:?}")) }
}

fn built(tree: &Path) -> PathBuf {
    tree.with_file_name("target")
}

/// Returns the commit that is tested, in the page's form.
pub fn commit() -> Result<String, String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(root()).output();
        let output = output.map_err(|error| format!("cannot start git: {error}"))?;
        Ok::<_, String>(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["log", "-1", "--format=%h"])?;
    let is_clean = git(&["status", "--porcelain", "--", "src", "tests", "host-sim"])?.is_empty();
    Ok(if is_clean { commit } else { format!("{commit}, with changes") })
}

/// Returns the start of a fault's row.
fn row(mutation: &Mutation) -> String {
    let Mutation { file, why, suite, .. } = mutation;
    format!("| `{file}` | {why} | {} |", suite.describe())
}

/// Returns the end of a fault's row on the page.
fn earlier_outcome(page: &str, mutation: &Mutation) -> Outcome {
    let begin = row(mutation);
    let outcome = page.lines().find_map(|line| line.strip_prefix(&*begin)).and_then(|rest| {
        let (fate, commit) = rest.trim().strip_suffix('|')?.split_once('|')?;
        let fate = Fate::ALL.into_iter().find(|known| known.describe() == fate.trim())?;
        Some(Outcome { fate, commit: commit.trim().to_owned() })
    });
    outcome.unwrap_or(Outcome { fate: Fate::NotRun, commit: String::new() })
}

fn page(outcomes: &[Outcome]) -> String {
    let count = |fate: Fate| outcomes.iter().filter(|other| other.fate == fate).count();
    let mut page = format!(
        "# Faults put into the sources\n\n\
         `cargo xtask mutations` writes this file: each of {} faults is put into a copy of the\n\
         sources, and the tests run. A row has the commit of its run. *In one build*: put in by\n\
         hand with others, each found by an assertion of its own. {} found, {} not found, {} not\n\
         built, {} not run.\n\n\
         | file | the fault, and why it matters | tests of | result | on commit |\n\
         |---|---|---|---|---|\n",
        outcomes.len(),
        count(Fate::Killed),
        count(Fate::Survived),
        count(Fate::NotBuilt),
        count(Fate::NotRun),
    );
    for (mutation, Outcome { fate, commit }) in mutations().zip(outcomes) {
        page.push_str(&format!("{} {} | {commit} |\n", row(mutation), fate.describe()));
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_some_faults_keeps_what_the_page_says_of_the_others() {
        let outcomes: Vec<Outcome> = (0..mutations().count())
            .map(|i| match i % 4 {
                0 => Outcome { fate: Fate::NotRun, commit: String::new() },
                kind => {
                    Outcome { fate: Fate::ALL[kind - 1], commit: format!("c{i}, with changes") }
                }
            })
            .collect();
        let page = page(&outcomes);
        let again: Vec<Outcome> = mutations().map(|m| earlier_outcome(&page, m)).collect();
        assert_eq!(again, outcomes);
        // A new fault was not run, nor was any fault without a page.
        let Some(first) = mutations().next() else { panic!("no fault") };
        let new = Mutation { why: "a fault that is not on the page", ..*first };
        assert_eq!(earlier_outcome(&page, &new).fate, Fate::NotRun);
        assert_eq!(earlier_outcome("", first).fate, Fate::NotRun);
    }

    #[test]
    fn each_fault_of_the_list_has_its_row_on_the_page() {
        let page = fs::read_to_string(root().join(PAGE)).unwrap_or_default();
        for mutation in mutations() {
            let begin = row(mutation);
            let rows = page.lines().filter(|line| line.starts_with(&begin)).count();
            assert_eq!(rows, 1, "{begin}");
        }
        let rows = page.lines().filter(|line| line.starts_with("| `")).count();
        assert_eq!(rows, mutations().count(), "rows of faults that are not in the list");
    }

    #[test]
    fn a_fault_fits_the_sources_once_or_the_list_is_out_of_date() {
        let is_out_of_date = |m: &Mutation| mutated(&root().join(m.file), m).err();
        let out_of_date: Vec<String> = mutations().filter_map(is_out_of_date).collect();
        assert!(out_of_date.is_empty(), "{}", out_of_date.join("\n"));
        let sound = root().join("src/safety/monitor/standstill.rs");
        let fault = |before| Mutation {
            file: "src/safety/monitor/standstill.rs",
            before,
            after: "const BAND: u32 = 4;",
            why: "a joint that creeps is at rest",
            suite: Suite::Core,
            tests: &[],
        };
        let (before, after) = mutated(&sound, &fault("const BAND: u32 = 2;")).unwrap_or_default();
        assert!(before != after && before.replace("= 2;", "= 4;") == after);
        for text in ["const BAND: u64", "Standstill"] {
            let said = mutated(&sound, &fault(text)).err().unwrap_or_default();
            assert!(said.contains("out of date") && said.contains("standstill.rs"), "{said}");
        }
    }
}
