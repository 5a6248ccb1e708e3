//! Every command that README.md, docs/explanation/architecture.md and the pages of docs/ show
//! works. Commands of `stiction` run here, page by page, in the order of the page; jobs and tests
//! of cargo are looked up. Those of `PARSED_ONLY` are parsed, and run elsewhere if at all.
//! docs/tutorial/commission-a-joint.md and the first run of docs/reference/wiring.md are followed
//! as a whole, on a simulated device for the board, with a look at what the steps that decide
//! print; the former on the emulated board as well. Of all else these tests are blind to what a
//! command prints, and to what needs a board.
#![cfg(unix)]
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const STICTION: &str = env!("CARGO_BIN_EXE_stiction");

/// Commands that only the parser sees, and why.
const PARSED_ONLY: [(&str, &str); 7] = [
    (" --port", "needs a board"),
    (" --emulator", "needs the firmware; tests/image/ runs the same"),
    (" --target emulator", "needs the firmware; tests/image/ runs the same"),
    (" --law", "needs a compiler of C; host-sim/tests/output/own_law.rs has one"),
    (" watch", "needs a terminal; host-sim/tests/port/ has one"),
    ("stiction studio", "serves a page until it is ended; host-sim/tests/studio/ has one"),
    ("stiction report", "takes a quarter of a minute; host-sim/tests/report.rs makes the page"),
];

/// The command that a sentence names without its options, and that takes minutes then: the parser
/// alone sees it. The same with options runs on the same page.
const LONG: &str = "stiction ensemble";

/// Complaints of clap about a command that a sentence names without its arguments.
const INCOMPLETE: [&str; 2] = ["required arguments were not provided", "a value is required for"];

/// Words of the text that stand for something of the reader's.
const PLACEHOLDERS: [(&str, &str); 11] = [
    ("completions SHELL", "completions bash"),
    ("--port ...", "--port /dev/ttyUSB0"),
    ("device ...", "device --simulated"),
    ("--signals NAME,...", "--signals saturated"),
    ("--signals NAME", "--signals saturated"),
    ("--controller NAME[,NAME]", "--controller srnf"),
    (" NAME", " step-response"),
    ("FILE.csv", "run.csv"),
    (" FILE", " file"),
    (" DIR", " figures"),
    ("[TABLE]", "limits"),
];

struct Shown {
    command: String,
    /// Whether the command is in a block, and so is complete.
    whole: bool,
    /// Whether it shall fail: its comment says that it does so on purpose.
    fails: bool,
}

/// The comment of a command that fails.
const FAILS: &str = " # fails on purpose";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// Returns the pages of docs/ and of its parts, and README.md.
fn pages() -> Vec<String> {
    let parts = ["docs", "docs/tutorial", "docs/how-to", "docs/reference", "docs/explanation"];
    let of_part = |part: &&str| {
        let entries = fs::read_dir(root().join(part)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let pages = names.filter(|name| name.ends_with(".md") && name != "SUMMARY.md");
        pages.map(|name| format!("{part}/{name}")).collect::<Vec<_>>()
    };
    let mut pages: Vec<String> = parts.iter().flat_map(of_part).collect();
    pages.push("README.md".into());
    pages.sort();
    pages
}

/// The commands of a page, in its order.
fn shown(page: &str) -> Vec<Shown> {
    let mut all = Vec::new();
    for (i, part) in page.split("\n```").enumerate() {
        if i % 2 == 0 {
            // A code may go on in the next line, but not in the next paragraph.
            for paragraph in part.split("\n\n") {
                let codes = paragraph.split('`').skip(1).step_by(2);
                let joined =
                    codes.map(|code| code.split_whitespace().collect::<Vec<_>>().join(" "));
                all.extend(joined.map(|command| Shown { command, whole: false, fails: false }));
            }
        } else if let Some(block) = part.strip_prefix('\n') {
            let lines = block.replace("\\\n", " ");
            all.extend(lines.lines().map(|line| {
                let command = line.split(" # ").next().unwrap().trim().to_owned();
                Shown { command, whole: true, fails: line.contains(FAILS) }
            }));
        }
    }
    for Shown { command, .. } in &mut all {
        while command.split_once(' ').is_some_and(|(first, _)| first.contains('=')) {
            *command = command.split_once(' ').unwrap().1.to_owned();
        }
    }
    all.retain(|Shown { command, .. }| {
        command.starts_with("stiction ") || command.starts_with("cargo ")
    });
    all
}

/// The arguments that a command of the text gives to `stiction`, if it is one.
fn of_stiction(command: &str) -> Option<String> {
    let arguments = match command.split_once(" -- ") {
        Some((cargo, arguments)) if cargo.starts_with("cargo run ") => arguments,
        _ => command.strip_prefix("stiction ").or_else(|| command.strip_prefix("cargo sim "))?,
    };
    let begin = format!("stiction {arguments}");
    Some(PLACEHOLDERS.iter().fold(begin, |text, (from, to)| text.replace(from, to)))
}

fn shell(directory: &Path, command: &str) -> Output {
    let path = format!("{}:{}", directory.join("bin").display(), std::env::var("PATH").unwrap());
    // This editor changes nothing.
    let surroundings = [("PATH", &*path), ("EDITOR", "true"), ("VISUAL", "true")];
    Command::new("sh")
        .args(["-c", command])
        .current_dir(directory)
        .envs(surroundings)
        .output()
        .unwrap()
}

/// Makes a directory with the files that the pages take for granted.
fn prepared() -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    for name in ["bin", "docs", "docs/reference"] {
        fs::create_dir(directory.path().join(name)).unwrap();
    }
    std::os::unix::fs::symlink(STICTION, directory.path().join("bin/stiction")).unwrap();
    for command in [
        "stiction show step-response > joint.toml",
        "stiction run trajectory --controller srnf --csv run.csv",
        "stiction device --simulated move 5 --for 3 --log move.csv",
    ] {
        assert!(shell(directory.path(), command).status.success(), "{command}");
    }
    directory
}

fn run(directory: &Path, command: &str, whole: bool, fails: bool) -> Result<(), String> {
    let parsed_only = PARSED_ONLY.iter().any(|(part, _)| command.contains(part)) || command == LONG;
    let done = shell(directory, &format!("{command}{}", if parsed_only { " --help" } else { "" }));
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    // Without a subcommand, clap answers with the help.
    let is_named = INCOMPLETE.iter().any(|why| said.contains(why))
        || said.contains("Usage:") && !said.contains("error:");
    let is_right = if fails { done.status.code() == Some(2) } else { done.status.success() };
    if is_right || (!whole && is_named) { Ok(()) } else { Err(said) }
}

/// Checks that cargo has what a command asks of it: a job with its options, an alias, a test, a
/// feature.
fn look_up(command: &str) -> Result<(), String> {
    let words: Vec<&str> =
        command.split_whitespace().skip(1).take_while(|word| *word != "--").collect();
    let manifests = [
        "Cargo.toml",
        "host-sim/Cargo.toml",
        "host-sim/dynamics/Cargo.toml",
        "host-sim/thesis/Cargo.toml",
        "tests/Cargo.toml",
    ];
    let manifests = manifests.map(read).concat();
    let jobs: String = fs::read_dir(root().join("xtask/src"))
        .unwrap()
        .map(|file| file.unwrap().path())
        .filter(|path| path.is_file())
        .map(read)
        .collect();
    let work =
        jobs.split_once("enum Work {").unwrap().1.split("\n}").next().unwrap().to_lowercase();
    for pair in words.windows(2) {
        let found = match *pair {
            ["xtask", job] => {
                ['(', ','].iter().any(|end| work.contains(&format!("\n    {job}{end}")))
            }
            ["--test" | "--bench" | "--bin" | "--package" | "-p", name] => {
                let mut files =
                    [".rs", "/main.rs"].iter().map(|end| format!("host-sim/tests/{name}{end}"));
                manifests.contains(&format!("\nname = \"{name}\""))
                    || files.any(|file| root().join(file).exists())
            }
            ["--features", names] => {
                names.split(',').all(|name| manifests.contains(&format!("\n{name} = [")))
            }
            ["--path", package] => root().join(package).join("Cargo.toml").exists(),
            [_, option] if words[0] == "xtask" && option.starts_with("--") => {
                jobs.contains(&format!("\n    {}: ", option[2..].replace('-', "_")))
            }
            _ => true,
        };
        if !found {
            return Err(format!("cargo does not know `{}`", pair.join(" ")));
        }
    }
    let is_alias = read(".cargo/config.toml").contains(&format!("\n{} = ", words[0]));
    if is_alias || ["test", "bench", "run", "install"].contains(&words[0]) {
        Ok(())
    } else {
        Err("no such alias".into())
    }
}

#[test]
fn every_command_that_a_page_shows_works() {
    // One page after another in each of two threads: most of a command is the work of one core.
    let (count, pages) = (AtomicUsize::new(0), Mutex::new(pages()));
    let wrong = Mutex::new(Vec::new());
    let next = || pages.lock().unwrap().pop();
    let work = || {
        while let Some(page) = next() {
            let directory = prepared();
            for Shown { command, whole, fails } in shown(&read(&page)) {
                count.fetch_add(1, Ordering::Relaxed);
                let mut done = of_stiction(&command)
                    .map_or(Ok(()), |filled| run(directory.path(), &filled, whole, fails));
                if command.starts_with("cargo ") {
                    done = done.and_then(|()| look_up(&command));
                }
                let failed = done.err().map(|why| format!("{page}: `{command}`\n{why}"));
                wrong.lock().unwrap().extend(failed);
            }
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    let (wrong, count) = (wrong.into_inner().unwrap(), count.into_inner());
    assert!(wrong.is_empty(), "{} of {count} commands fail:\n\n{}", wrong.len(), wrong.join("\n"));
    assert!(count > 60, "only {count} commands were found");
}

/// Pages name the program `stiction`, which `cargo install` puts on the path. One sentence names
/// the alias that developers use instead.
#[test]
fn pages_name_the_program_by_one_name() {
    let sum =
        |text: &str| -> usize { pages().iter().map(|page| read(page).matches(text).count()).sum() };
    assert_eq!(sum("cargo sim"), 1);
    assert_eq!(sum("--bin stiction "), 0);
    let readme = read("README.md");
    let start = readme.split_once("\n## Start").unwrap().1;
    let first = &shown(start)[0];
    assert!(first.whole && first.command.starts_with("cargo install --path host-sim"));
}

/// The guide of docs/reference/wiring.md, step by step, with a device that is simulated instead of
/// the board.
#[test]
fn the_first_run_can_be_followed_command_by_command() {
    let page = read("docs/reference/wiring.md");
    let (_, guide) = page.split_once("## The first move").unwrap();
    let guide = guide.split("\n### ").next().unwrap();
    let directory = prepared();
    // The blocks of a numbered step are indented.
    let blocks = guide.replace("\n   ", "\n");
    let commands: Vec<String> = shown(&blocks)
        .into_iter()
        .filter(|shown| shown.whole)
        .map(|shown| shown.command.replace("--port ...", "--simulated"))
        .collect();
    assert_eq!(commands.len(), 8, "{commands:?}");
    for step in ["status", "jog", "identify --travel 20 --speed 10", "move 1"] {
        let is_there = commands.iter().any(|command| command.ends_with(step));
        assert!(is_there, "{step}: {commands:?}");
    }
    for command in commands {
        let done = shell(directory.path(), &command);
        assert!(done.status.success(), "{command}: {}", String::from_utf8_lossy(&done.stderr));
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        if command.ends_with(" jog") {
            assert!(said.contains("in the sense of the effort"), "{said}");
        }
    }
}

/// Follows docs/tutorial/commission-a-joint.md, from a data sheet to a page on the joint that was
/// found, with `device` for the simulated one of the page.
fn commission(device: impl Fn(String) -> String) {
    let page = read("docs/tutorial/commission-a-joint.md");
    let directory = prepared();
    let commands = shown(&page).into_iter().filter(|shown| shown.whole);
    let commands: Vec<(String, bool)> =
        commands.map(|shown| (device(shown.command), shown.fails)).collect();
    let place =
        |part: &str| commands.iter().rposition(|(command, _)| command.contains(part)).unwrap();
    // The self-test fails once on purpose, on a joint that is not that of its file.
    assert_eq!(commands.iter().filter(|(_, fails)| *fails).count(), 1, "{commands:?}");
    assert!(place("benchmark arm.toml") < 3, "{commands:?}");
    let steps = ["jog", "identify --into", "tune found", "params push", "selftest", "report"];
    assert!(steps.windows(2).all(|pair| place(pair[0]) < place(pair[1])), "{commands:?}");
    for (command, fails) in commands {
        let done = shell(directory.path(), &command);
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        if fails {
            assert_eq!(done.status.code(), Some(2), "{command}: {said}");
            assert!(said.contains("selftest   FAIL: "), "{said}");
            let why = String::from_utf8_lossy(&done.stderr);
            assert!(why.contains("the joint does not move as arm.toml predicts"), "{why}");
            continue;
        }
        assert!(done.status.success(), "{command}: {}", String::from_utf8_lossy(&done.stderr));
        for (part, expected) in [
            ("benchmark", "Ranked by the"),
            (" jog", "in the sense of the effort"),
            ("identify", "verdict    good"),
            ("selftest", "selftest   pass"),
            ("report", "found.tuned.html"),
        ] {
            assert!(!command.contains(part) || said.contains(expected), "{command}: {said}");
        }
        // Twenty moves, each in a row of its own.
        let rows = said.lines().take_while(|line| !line.contains("all moves"));
        let moves = rows.filter(|line| line.split_whitespace().count() == 9).count();
        assert!(!command.contains("selftest") || moves == 20, "{command}: {moves} moves: {said}");
    }
    let page = fs::read_to_string(directory.path().join("report/found.tuned.html")).unwrap();
    assert!(page.contains("Nothing has run on a motor") && page.contains("selftest"));
}

#[test]
fn a_joint_is_commissioned_command_by_command() {
    commission(|command| command);
}

/// The same on the flash image. It has no contents of the flash, where a set would be saved.
#[test]
#[cfg_attr(not(feature = "emulator"), ignore = "the flash image in the loop: cargo xtask test")]
fn a_joint_is_commissioned_command_by_command_on_the_emulated_board() {
    let image = std::env::var("STICTION_IMAGE")
        .expect("STICTION_IMAGE does not name a flash image: run `cargo xtask test`");
    let image = fs::canonicalize(image).unwrap();
    let emulated = format!("--emulator --image '{}'", image.display());
    commission(|command| command.replace("--simulated", &emulated).replace(" --save", ""));
}

#[test]
fn the_readme_is_short_and_no_link_is_broken() {
    let words = read("README.md").split_whitespace().count();
    assert!(words <= 800, "README.md has {words} words");
    for page in pages() {
        let text = read(&page);
        for target in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let (file, _) = target.split_once('#').unwrap_or((target, ""));
            let found = root().join(&page).with_file_name(file);
            assert!(
                file.is_empty() || file.starts_with("http") || found.exists(),
                "{page}: {target}"
            );
        }
    }
}

#[test]
fn every_picture_of_the_pages_is_shown() {
    let pages: Vec<String> = pages().iter().map(read).collect();
    let mut pictures = 0;
    for entry in fs::read_dir(root().join("docs/pictures")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if [".png", ".svg"].iter().any(|end| name.ends_with(end)) {
            let link = |page: &String| page.contains(&format!("pictures/{name})"));
            assert!(pages.iter().any(link), "docs/pictures/{name} is on no page");
            pictures += 1;
        }
    }
    assert!(pictures > 5, "{pictures}");
}

#[test]
fn a_shell_completes_every_command() {
    let printed = |arguments: &[&str]| {
        let output = Command::new(STICTION).args(arguments).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let help = printed(&["--help"]);
    let commands = help.split_once("Commands:").unwrap().1.split_once("Options:").unwrap().0;
    let named = commands.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let named: Vec<&str> = named.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(named.len() > 9, "{named:?}");
    for shell in ["bash", "zsh", "fish"] {
        let script = printed(&["completions", shell]);
        assert!(named.iter().all(|name| script.contains(name)), "{shell}");
    }
}
