//! Runs the command line `stiction` for the demo.

use std::process::Command;

use crate::job::{Job, cargo};

/// A build of `stiction`.
#[derive(Clone, Copy, Debug)]
pub enum Simulator {
    /// The build with the default features.
    Host,
    /// The build with the emulator, which the tests use, too.
    Emulator,
}

/// Cargo's arguments for the emulator, which declares a newer compiler than it needs.
pub const EMULATOR: [&str; 3] = ["--features", "emulator", "--ignore-rust-version"];

/// Cargo's arguments for a build with everything: the studio as well.
pub const EVERYTHING: [&str; 3] =
    ["--features", "emulator,host-sim/studio", "--ignore-rust-version"];

impl Simulator {
    fn options(self) -> &'static [&'static str] {
        match self {
            Self::Host => &[],
            Self::Emulator => &EMULATOR,
        }
    }

    /// Builds it, so that later calls start at once.
    pub fn build(self) -> Result<(), String> {
        let job = match self {
            Self::Host => Job::new("Building the simulator"),
            Self::Emulator => Job::new("Building the simulator with the emulator"),
        };
        let mut build = cargo(&["build", "--package", "host-sim", "--bin", "stiction"]);
        job.run(build.args(self.options()))
    }

    /// Returns a call of `stiction`.
    pub fn command(self, arguments: &[&str]) -> Command {
        let mut command = cargo(&["run", "--quiet", "--package", "host-sim", "--bin", "stiction"]);
        command.args(self.options()).arg("--").args(arguments);
        command
    }
}
