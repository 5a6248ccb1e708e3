//! The command line of `stiction`.

mod benchmark;
mod completions;
mod device;
mod ensemble;
mod identify;
mod interrupt;
mod keys;
mod list;
mod new;
mod outputs;
mod params;
mod plot;
mod report;
mod run;
mod show;
#[cfg(feature = "studio")]
mod studio;
#[cfg(not(feature = "studio"))]
#[path = "no_studio.rs"]
mod studio;
mod target;
mod tune;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::Error;

/// Position a joint in spite of stick-slip friction: simulate controllers around the firmware's own
/// control core. Nothing here has been run on a motor yet.
#[derive(Debug, Parser)]
#[command(name = "stiction", version, max_term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Every built-in experiment and its source
    List(list::Arguments),
    /// A first file of your own joint: puts questions, or takes the answers as options
    New(Box<new::Arguments>),
    /// The TOML of a built-in experiment, to copy and change; or a data sheet in both units
    Show(show::Arguments),
    /// Every key of a machine's file: what it means, what is allowed, what it is if it is left out
    Keys(keys::Arguments),
    /// Run an experiment or a machine's own file
    Run(run::Arguments),
    /// Encode a machine for the parameter sector of the controller board
    Params(params::Arguments),
    /// Talk to a device: status, move, parameters, faults, log
    Device(device::Arguments),
    /// See a joint move live in a browser, drive it, and change its parameters
    Studio(studio::Arguments),
    /// Rank controllers on one joint: rest, overshoot, settling, tracking, chatter, hunting
    Benchmark(benchmark::Arguments),
    /// Rank untuned controllers on random joints: success, settling, rest, tracking, faults
    Ensemble(ensemble::Arguments),
    /// Look for gains of a joint that is known within bounds, and write them into a new file
    Tune(tune::Arguments),
    /// Inertia and friction of any machine from a log of time, position and effort
    Identify(identify::Arguments),
    /// Draw what `run --csv` or a device's `log` has written, one over the other
    Plot(plot::Arguments),
    /// One HTML page on your own joint: laws compared, margins, what a self-test should show; or
    /// without a file, every figure and table of the thesis, claims beside measurements
    Report(report::Arguments),
    /// Print a shell completion script
    Completions(completions::Arguments),
}

/// The exit code for a valid request, if a solver failed.
const GIVEN_UP: u8 = 1;

/// The exit code that a shell reports of a program that was ended by Ctrl-C: 128 and the number of
/// the signal.
const INTERRUPTED: u8 = 130;

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match arguments.command {
        Command::List(arguments) => list::list(&arguments),
        Command::New(arguments) => new::new(&arguments),
        Command::Show(arguments) => show::show(&arguments),
        Command::Keys(arguments) => keys::keys(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Params(arguments) => params::params(&arguments),
        Command::Device(arguments) => device::device(&arguments),
        Command::Studio(arguments) => studio::studio(&arguments),
        Command::Benchmark(arguments) => benchmark::rank(&arguments),
        Command::Ensemble(arguments) => ensemble::ensemble(&arguments),
        Command::Tune(arguments) => tune::tune(&arguments),
        Command::Identify(arguments) => identify::identify_log(&arguments),
        Command::Plot(arguments) => plot::plot(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Completions(arguments) => completions::completions(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        // The reader has seen enough (`| head`): nobody is there to be told, and nothing is wrong.
        Err(Error::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            // If even this cannot be written there is nobody to tell.
            let _ = writeln!(io::stderr(), "stiction: {error}");
            match error {
                // Nothing was wrong with what was asked for: a script should see that its user
                // wants no more.
                Error::Interrupted | Error::CtrlC(_) => ExitCode::from(INTERRUPTED),
                Error::Run(_) => ExitCode::from(GIVEN_UP),
                _ => ExitCode::from(2),
            }
        }
    }
}

/// Writes to the standard output.
fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Tells what a person should know before a run, which is made all the same.
fn warn(sentences: &[String]) {
    for sentence in sentences {
        // If even this cannot be written there is nobody to tell.
        let _ = writeln!(io::stderr(), "stiction: warning: {sentence}");
    }
}
