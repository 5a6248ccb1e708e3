//! System packages: those that apt would install, their size, and the user's consent.

use std::fmt;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::job::Job;

/// Packages to which the user has agreed. A job that installs late asks at its start, and the
/// installation does not ask again.
static AGREED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Set by `--yes`.
static YES: OnceLock<()> = OnceLock::new();

/// Turns the question off, for `--yes`.
pub fn assume_yes() {
    let _ = YES.set(());
}

/// Packages with their dependencies, as apt would install them.
#[derive(Debug, PartialEq, Eq)]
struct Plan {
    /// Names, dependencies included.
    names: Vec<String>,
    /// Size of the download, as in `73.0 MB`.
    download: String,
    /// Size on the disk, as in `795 MB`; unknown if apt does not print it.
    disk: Option<String>,
}

/// Returns whether this machine can install packages: Debian or its like, as root.
pub fn can_install() -> bool {
    let id = Command::new("id").arg("-u").output();
    Path::new("/etc/debian_version").exists() && id.is_ok_and(|id| id.stdout == b"0\n")
}

/// Prints packages, asks the user, and installs them.
///
/// # Errors
/// Returns an error if the user refuses or apt fails.
pub fn install(packages: &[&str]) -> Result<(), String> {
    if !agreed(packages)? {
        return Err("nothing is installed".into());
    }
    let mut install = apt(&["install", "--quiet", "--yes", "--no-install-recommends"]);
    Job::new("Installing system packages").run(install.args(packages))
}

/// Prints the packages that apt would install, and asks on a terminal. Without a terminal, or with
/// `--yes`, it goes on. Returns whether the user agrees.
///
/// # Errors
/// Returns an error if apt does not know a package.
pub fn agreed(packages: &[&str]) -> Result<bool, String> {
    let mut known = AGREED.lock().unwrap_or_else(PoisonError::into_inner);
    if packages.iter().all(|package| known.iter().any(|known| known == package)) {
        return Ok(true);
    }
    Job::new("Reading Debian's list of packages").run(&mut apt(&["update", "--quiet"]))?;
    println!("{}", planned(packages)?);
    let is_terminal = io::stdin().is_terminal() && io::stdout().is_terminal();
    let (sentence, is_question) = announced(YES.get().is_some(), is_terminal);
    print!("   {sentence}");
    let _ = io::stdout().flush();
    if is_question && !is_yes(&mut io::stdin().lock()) {
        return Ok(false);
    }
    known.extend(packages.iter().map(|package| (*package).to_owned()));
    Ok(true)
}

/// Returns what is printed below the plan, and whether that is a question.
const fn announced(yes: bool, is_terminal: bool) -> (&'static str, bool) {
    match (yes, is_terminal) {
        (true, _) => ("--yes: they are installed without a question\n", false),
        (false, true) => ("Install them? [y/N] ", true),
        (false, false) => ("not on a terminal: they are installed without a question\n", false),
    }
}

/// Reads an answer. The end of the input is a no.
fn is_yes(input: &mut impl BufRead) -> bool {
    let mut answer = String::new();
    let read = input.read_line(&mut answer);
    read.is_ok() && ["y", "yes"].contains(&answer.trim().to_lowercase().as_str())
}

/// Returns a call of apt with the output that [`Plan::read`] parses.
fn apt(arguments: &[&str]) -> Command {
    let mut command = Command::new("apt-get");
    command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive").env("LC_ALL", "C");
    command
}

/// Lets apt simulate an installation.
fn planned(packages: &[&str]) -> Result<Plan, String> {
    let mut ask = apt(&["install", "--assume-no", "--no-install-recommends"]);
    let output =
        ask.args(packages).output().map_err(|error| format!("cannot start apt-get: {error}"))?;
    // The exit code is that of a failure, since nothing was installed.
    Plan::read(&String::from_utf8_lossy(&output.stdout)).ok_or_else(|| {
        let why = String::from_utf8_lossy(&output.stderr);
        format!("apt cannot install {}:\n{}", packages.join(" "), why.trim())
    })
}

impl Plan {
    /// Parses the output of `apt-get install` in the C locale.
    fn read(text: &str) -> Option<Self> {
        let mut names = Vec::new();
        let mut lists_names = false;
        for line in text.lines() {
            if line.starts_with(' ') {
                names.extend(line.split_whitespace().filter(|_| lists_names).map(str::to_owned));
            } else {
                // New packages, and those upgraded for them.
                lists_names = line.ends_with("packages will be installed:")
                    && line.contains(" NEW ")
                    || line.ends_with("packages will be upgraded:");
            }
        }
        let between = |before: &str, after: &str| {
            let rest = text.lines().find_map(|line| line.strip_prefix(before))?;
            Some(rest.split_once(after)?.0.to_owned())
        };
        // `0 B/73.0 MB`: the rest is in apt's cache.
        let download = between("Need to get ", " of archives.");
        let download = download.map(|size| size.split('/').next().unwrap_or(&size).to_owned());
        let disk = between("After this operation, ", " of additional disk space");
        (!names.is_empty()).then(|| Self {
            names,
            download: download.unwrap_or_else(|| "0 B".into()),
            disk,
        })
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.names.len();
        let packages =
            if count == 1 { "system package is missing" } else { "system packages are missing" };
        write!(f, "   {count} {packages}: {} to download", self.download)?;
        if let Some(disk) = &self.disk {
            write!(f, ", {disk} on the disk")?;
        }
        write!(f, "\n   {}", self.names.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Output of apt 2.6 for the compiler on a Debian 12 without it.
    const PRINTED: &str = "\
Reading package lists...
Building dependency tree...
Reading state information...
The following additional packages will be installed:
  libllvm22 libstd-rust-web-1.96 libstd-rust-web-dev llvm-22
  llvm-22-linker-tools llvm-22-runtime
Suggested packages:
  cargo-web-doc llvm-22-doc
Recommended packages:
  llvm-22-dev
The following NEW packages will be installed:
  cargo-web libllvm22 libstd-rust-web-1.96 libstd-rust-web-dev lld-22 llvm-22
  llvm-22-linker-tools llvm-22-runtime rust-web-clippy rust-web-llvm
  rust-web-src rustc-web rustfmt-web
0 upgraded, 13 newly installed, 0 to remove and 132 not upgraded.
Need to get 175 MB of archives.
After this operation, 941 MB of additional disk space will be used.
Do you want to continue? [Y/n] N
Abort.
";

    #[test]
    fn a_plan_has_the_number_of_packages_and_both_sizes() {
        let plan = Plan::read(PRINTED).unwrap();
        assert_eq!(plan.names.len(), 13);
        assert_eq!([&plan.names[0], &plan.names[12]], ["cargo-web", "rustfmt-web"]);
        let text = plan.to_string();
        let first = text.lines().next().unwrap();
        assert_eq!(
            first,
            "   13 system packages are missing: 175 MB to download, 941 MB on the disk"
        );
        // A suggestion is not installed.
        assert!(text.contains("llvm-22-runtime") && !text.contains("llvm-22-doc"));
    }

    #[test]
    fn an_upgrade_counts_and_what_apt_has_in_its_cache_is_not_fetched() {
        let printed = "The following packages will be upgraded:\n  libc6\nThe following NEW \
                       packages will be installed:\n  wasi-libc\n1 upgraded, 1 newly installed, 0 \
                       to remove and 0 not upgraded.\nNeed to get 0 B/2,345 kB of archives.\nAfter \
                       this operation, 12.3 MB of additional disk space will be used.\n";
        let plan = Plan::read(printed).unwrap();
        assert_eq!(plan.names, ["libc6", "wasi-libc"]);
        assert_eq!((&*plan.download, plan.disk.as_deref()), ("0 B", Some("12.3 MB")));
    }

    #[test]
    fn a_package_that_apt_does_not_know_makes_no_plan() {
        let printed = "Reading package lists...\nBuilding dependency tree...\n";
        assert_eq!(Plan::read(printed), None);
    }

    #[test]
    fn only_a_terminal_without_yes_is_asked() {
        for (yes, is_terminal, asks) in
            [(false, true, true), (true, true, false), (false, false, false), (true, false, false)]
        {
            let (sentence, is_question) = announced(yes, is_terminal);
            assert_eq!(is_question, asks, "{yes} {is_terminal}");
            assert_eq!(sentence.contains("without a question\n"), !asks, "{sentence}");
        }
    }

    #[test]
    fn an_installation_needs_a_yes_in_full() {
        for (answer, expected) in
            [("y\n", true), ("Yes\n", true), ("\n", false), ("", false), ("no\n", false)]
        {
            assert_eq!(is_yes(&mut answer.as_bytes()), expected, "{answer:?}");
        }
    }
}
