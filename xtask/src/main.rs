//! `cargo xtask`: the jobs of the project that need more than one call of cargo.

mod elf;
mod firmware;
mod job;
mod toolchain;

use std::process::{Command, ExitCode};

use clap::{Parser, Subcommand};

use job::{Job, cargo};

/// The project's jobs. Each does its own set-up.
#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    job: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    /// Let seven controllers position the simulated joint: a table, and figures in target/demo
    Demo,
    /// Everything that must pass before a change lands: format, lints, tests, documentation
    Test,
    /// Find or install the compiler for the microcontroller
    Setup,
    /// Build the firmware: target/firmware/stiction-firmware.elf and .bin
    Firmware,
    /// Write the firmware to a board by probe-rs, and show its log
    Flash,
    /// Encode a machine's TOML for the parameter sector of the microcontroller
    Params(firmware::ParamsArguments),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().job {
        Work::Demo => demo(),
        Work::Test => test(),
        Work::Setup => setup(),
        Work::Firmware => firmware::build(),
        Work::Flash => firmware::flash(),
        Work::Params(arguments) => firmware::params(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("xtask: {why}");
            ExitCode::FAILURE
        }
    }
}

/// The experiments that the benchmark does not run.
const MORE: [&str; 5] =
    ["step-added-friction", "srnf-robustness", "srnf-added-friction", "high-gain", "friction-identification"];

fn setup() -> Result<(), String> {
    let toolchain = toolchain::Toolchain::ready()?;
    println!("The firmware is built by {}.", toolchain.describe());
    Ok(())
}

fn demo() -> Result<(), String> {
    let figures = "target/demo";
    Job::new("Building the simulator (optimised; a minute or two the first time)").run(&mut cargo(&[
        "build",
        "--quiet",
        "--release",
        "--package",
        "host-sim",
        "--bin",
        "stiction",
    ]))?;
    Job::new("Seven controllers on the thesis's robot axis, simulated: three steps, two trajectories")
        .run(&mut simulator(&["benchmark", "--plot", figures]))?;
    let drawing = Job::new("Drawing the other experiments of Chapter 3 and Appendix A.2");
    drawing.announce();
    for experiment in MORE {
        drawing.run_silently(&mut simulator(&["run", experiment, "--plot", figures]))?;
    }
    println!("\nA figure for each result, as SVG and PNG: {figures}");
    println!("The numbers behind them: `cargo sim list`, then `cargo sim run NAME`.");
    Ok(())
}

/// The command line `stiction`.
fn simulator(arguments: &[&str]) -> Command {
    let mut command =
        cargo(&["run", "--quiet", "--release", "--package", "host-sim", "--bin", "stiction", "--"]);
    command.args(arguments);
    command
}

fn test() -> Result<(), String> {
    Job::new("Format").run(&mut cargo(&["fmt", "--all", "--check"]))?;
    Job::new("Lints").run(&mut cargo(&[
        "clippy",
        "--workspace",
        "--all-targets",
        "--",
        "--deny",
        "warnings",
    ]))?;
    Job::new("Tests").run(&mut cargo(&["test", "--workspace"]))?;
    Job::new("Documentation")
        .run(cargo(&["doc", "--workspace", "--no-deps", "--quiet"]).env("RUSTDOCFLAGS", "--deny warnings"))
}
