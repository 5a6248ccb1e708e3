//! The command line `stiction`, as the demo runs it.

use std::process::Command;

use crate::job::{Job, cargo};

/// Which build of it.
#[derive(Clone, Copy, Debug)]
pub enum Simulator {
    /// As `cargo sim` builds it.
    Host,
    /// With the emulator. The tests use the same one.
    Emulator,
}

/// The emulator declares a newer compiler than it needs.
pub const EMULATOR: [&str; 3] = ["--features", "emulator", "--ignore-rust-version"];

impl Simulator {
    fn options(self) -> &'static [&'static str] {
        match self {
            Self::Host => &[],
            Self::Emulator => &EMULATOR,
        }
    }

    /// Builds it, so that what follows begins at once.
    pub fn build(self) -> Result<(), String> {
        let job = match self {
            Self::Host => Job::new("Building the simulator"),
            Self::Emulator => Job::new("Building the simulator with the emulator"),
        };
        let mut build = cargo(&["build", "--package", "host-sim", "--bin", "stiction"]);
        job.run(build.args(self.options()))
    }

    /// A call of it.
    pub fn command(self, arguments: &[&str]) -> Command {
        let mut command = cargo(&["run", "--quiet", "--package", "host-sim", "--bin", "stiction"]);
        command.args(self.options()).arg("--").args(arguments);
        command
    }
}
