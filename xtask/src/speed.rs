//! `cargo xtask speed` checks the speed of the closed loop by ratios inside one run.

use crate::job::{Job, cargo};

/// Runs the example `speed` of the simulator, which measures and compares with its bounds.
pub fn check() -> Result<(), String> {
    let run = ["run", "--quiet", "--package", "simulator", "--example", "speed"];
    Job::new("Measuring the closed loop against RK4 of 10 us").run(&mut cargo(&run))
}
