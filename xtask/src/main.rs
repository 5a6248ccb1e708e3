//! `cargo xtask`: the jobs of the project that need more than one call of cargo.

mod elf;
mod firmware;
mod job;
mod toolchain;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use job::{Job, cargo};

/// The project's jobs. Each does its own set-up.
#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    job: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
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
        Command::Demo => demo(),
        Command::Test => test(),
        Command::Setup => setup(),
        Command::Firmware => firmware::build(),
        Command::Flash => firmware::flash(),
        Command::Params(arguments) => firmware::params(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("xtask: {why}");
            ExitCode::FAILURE
        }
    }
}

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
    Job::new("Seven controllers, three steps and two trajectories on the thesis's robot axis, simulated")
        .run(&mut cargo(&[
            "run",
            "--quiet",
            "--release",
            "--package",
            "host-sim",
            "--bin",
            "stiction",
            "--",
            "benchmark",
            "--plot",
            figures,
        ]))?;
    println!("\nA figure for each controller and kind of motion, as SVG and PNG: {figures}");
    println!("More: `cargo sim list`, then `cargo sim run NAME --plot DIR`.");
    Ok(())
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
