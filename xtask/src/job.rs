//! Runs commands, and prints the purpose of each.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A step that is announced before it runs.
pub struct Job {
    what: &'static str,
}

impl Job {
    pub fn new(what: &'static str) -> Self {
        Self { what }
    }

    pub fn announce(&self) {
        println!("== {}", self.what);
    }

    /// Announces and runs a command; a command that fails prints its own reason.
    pub fn run(&self, command: &mut Command) -> Result<(), String> {
        self.announce();
        self.finish(command)
    }

    /// Runs one of several commands of an announced step, without its output.
    pub fn run_silently(&self, command: &mut Command) -> Result<(), String> {
        self.finish(command.stdout(Stdio::null()))
    }

    /// Runs one of several commands of an announced step.
    pub fn finish(&self, command: &mut Command) -> Result<(), String> {
        match command.status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("\"{}\" failed ({status})", self.what)),
            Err(error) => Err(format!("cannot start {}: {error}", command.get_program().display())),
        }
    }
}

/// Times of the parts of a longer job.
pub struct JobTimes {
    begin: Instant,
    parts: Vec<(&'static str, Duration)>,
}

impl JobTimes {
    pub fn new() -> Self {
        Self { begin: Instant::now(), parts: Vec::new() }
    }

    /// Runs a part of the job, and notes its time.
    pub fn of<T>(
        &mut self,
        part: &'static str,
        work: impl FnOnce() -> Result<T, String>,
    ) -> Result<T, String> {
        let begin = Instant::now();
        let done = work();
        self.parts.push((part, begin.elapsed()));
        done
    }

    /// Prints a line for each part, and one for the whole.
    pub fn print(&self) {
        println!("\nIt took, without the building of xtask itself:");
        let whole = ("all of it", self.begin.elapsed());
        for (part, time) in self.parts.iter().chain([&whole]) {
            println!("{:7.1} s  {part}", time.as_secs_f64());
        }
    }
}

/// The root of the workspace.
pub fn root() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest)
}

/// The directory in which cargo builds.
pub fn target_dir() -> PathBuf {
    // Joining an absolute path replaces the root.
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// Returns a call of cargo in the root of the workspace.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
}
