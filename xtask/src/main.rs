//! `cargo xtask`: the jobs of the project that need more than one call of cargo.

mod cost;
mod demo;
mod dist;
mod elf;
mod examples;
mod firmware;
mod gates;
mod job;
mod library;
mod licences;
mod mutation_list;
mod mutations;
mod packages;
mod playground;
mod python;
mod ranking;
mod reliability;
mod simplefoc;
mod simulator;
mod site;
mod speed;
mod studio;
mod studio_page;
mod test;
mod toolchain;
mod words;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use simulator::EMULATOR;

/// Jobs of the project. Each does its own set-up.
#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    job: Work,
    /// Install missing system packages without asking
    #[arg(long, global = true)]
    yes: bool,
}

#[derive(Debug, Subcommand)]
enum Work {
    /// Rank seven controllers, draw figures into target/demo, and boot the firmware on an emulated
    /// microcontroller against the simulated joint
    Demo(demo::DemoJobArguments),
    /// Run everything that must pass before a change lands: format, lints, the firmware, tests,
    /// documentation
    Test(test::TestArguments),
    /// Build the firmware, and compare every term of its ticks with the core on this machine, bit
    /// for bit
    Image(test::ImageTestArguments),
    /// Find or install the compiler for the microcontroller
    Setup,
    /// Build the firmware for one encoder and for two: target/firmware/stiction-firmware.elf and
    /// stiction-two-encoders.elf, each beside its .bin
    Firmware,
    /// Write the firmware to a board by probe-rs, and show its log
    Flash(firmware::FlashJobArguments),
    /// Count the instructions of a tick, and the bytes of flash, RAM, stack and state; compare with
    /// tests/evidence/cost.md
    Cost(cost::CostJobArguments),
    /// Prove that the control path cannot panic, the stack fits, and no floating point is computed
    /// in software
    Gates,
    /// Build the firmwares in examples/: the library in programs of RTIC and embassy
    Examples,
    /// Build the library for C for four cores, and pack it: target/library/stiction-CORE.tar.gz
    Library(library::LibraryJobArguments),
    /// Compare SimpleFOC's cascade, and `robust` within SimpleFOC, with the built-in laws
    Simplefoc(simplefoc::SimplefocJobArguments),
    /// Build the wheel of the package for Python: target/wheels
    Python(python::PythonJobArguments),
    /// Pack what a release has, for people without a compiler: target/dist/stiction-VERSION.tar.gz
    Dist(dist::DistJobArguments),
    /// Rank untuned laws on random joints, and write README.md's first table
    Ranking,
    /// Measure the figures of tests/evidence/reliability.md, and write the page
    Reliability(reliability::ReliabilityJobArguments),
    /// Put one fault after another into a copy of the sources, and check which of them the tests
    /// find; writes tests/evidence/mutations.md
    Mutations(mutations::MutationsJobArguments),
    /// Check that the closed loop is not slower than it was: ratios inside one run, some seconds
    Speed,
    /// Count the words to avoid in sources and pages; no count may rise
    Words(words::WordsJobArguments),
    /// Build the page of `stiction studio` by npm and the program around it, and start it
    Studio(studio::StudioJobArguments),
    /// Build the pages as one site with search, the documentation of the core and the playground:
    /// target/site/index.html
    Site(site::SiteJobArguments),
    /// Encode a machine's TOML for the parameter sector of the microcontroller
    Params(firmware::ParamsJobArguments),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.yes {
        packages::assume_yes();
    }
    let done = match arguments.job {
        Work::Demo(arguments) => demo::demo(&arguments),
        Work::Test(arguments) => test::test(&arguments),
        Work::Image(arguments) => test::image(&arguments),
        Work::Setup => setup(),
        Work::Firmware => firmware::build_all().map(|_| ()),
        Work::Flash(arguments) => firmware::flash(&arguments),
        Work::Cost(arguments) => cost::measure(&arguments, EMULATOR),
        Work::Gates => gates::pass(EMULATOR),
        Work::Examples => examples::build(),
        Work::Library(arguments) => library::run(&arguments),
        Work::Simplefoc(arguments) => simplefoc::run(&arguments),
        Work::Python(arguments) => python::run(&arguments),
        Work::Dist(arguments) => dist::run(&arguments),
        Work::Ranking => ranking::rank(),
        Work::Reliability(arguments) => reliability::measure(&arguments),
        Work::Mutations(arguments) => mutations::run(&arguments),
        Work::Speed => speed::check(),
        Work::Words(arguments) => words::check(&arguments),
        Work::Studio(arguments) => studio::studio(&arguments),
        Work::Site(arguments) => site::build(&arguments),
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

fn setup() -> Result<(), String> {
    let toolchain = toolchain::Toolchain::ready(&toolchain::MICROCONTROLLER)?;
    println!("The firmware is built by {}.", toolchain.describe());
    Ok(())
}
