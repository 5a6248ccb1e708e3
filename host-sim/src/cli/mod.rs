//! The command line of `stiction`.

mod bar;
mod benchmark;
mod completions;
mod device;
mod ensemble;
mod ensemble_follow;
mod ensemble_options;
mod identify;
mod interrupt;
mod keys;
mod list;
mod new;
mod outputs;
mod own_laws;
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
mod version;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use files::error::Error;

/// Position a joint in spite of stick-slip friction: simulate controllers around the firmware's own
/// control core. Nothing here has been run on a motor yet.
#[derive(Debug, Parser)]
#[command(name = "stiction", version, long_version = version::LONG.as_str())]
#[command(max_term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List the built-in experiments and their sources
    List(list::ListArguments),
    /// Write a first file of your own joint: asks questions, or takes the answers as options
    New(Box<new::NewArguments>),
    /// Print the TOML of a built-in experiment, to copy and change; or a data sheet in both units
    Show(show::ShowArguments),
    /// List the keys of a machine's file: meaning, range, default
    Keys(keys::KeysArguments),
    /// Run an experiment or a machine's own file
    Run(run::RunArguments),
    /// Encode a machine for the parameter sector of the controller board
    Params(params::ParamsArguments),
    /// Operate a device: status, move, parameters, faults, log
    Device(device::DeviceArguments),
    /// Watch a joint live in a browser, move it, and change its parameters
    Studio(studio::StudioArguments),
    /// Rank controllers on one joint: rest, overshoot, settling, tracking, chatter, hunting
    Benchmark(benchmark::BenchmarkArguments),
    /// Rank untuned controllers on random joints: success, settling, rest, tracking, faults
    Ensemble(ensemble::EnsembleArguments),
    /// Tune gains for a joint that is known within bounds, and write them into a new file
    Tune(tune::TuneArguments),
    /// Identify inertia and friction of any machine from a log of time, position and effort
    Identify(identify::IdentifyLogArguments),
    /// Draw what `run --csv` or a device's `log` has written, one over the other
    Plot(plot::PlotArguments),
    /// Write one HTML page on your own joint: laws compared, margins, expected self-test; or,
    /// without a file, every figure and table of the thesis, claims beside measurements
    Report(report::ReportArguments),
    /// Print a shell completion script
    Completions(completions::CompletionsArguments),
}

/// Exit code of a valid request that was not completed, as when a solver failed or no gains were
/// found.
const GIVEN_UP: u8 = 1;

/// Exit code that a shell reports for a program that Ctrl-C ended: 128 and the number of the
/// signal.
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
        // The reader has closed the pipe (`| head`), which is not an error.
        Err(Error::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            // If this cannot be written either, there is no other place to report to.
            let _ = writeln!(io::stderr(), "stiction: {error}");
            match error {
                // The request was valid: a script sees that the user interrupted it.
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

/// Writes warnings to the standard error; the command goes on.
fn warn(sentences: &[String]) {
    for sentence in sentences {
        // If this cannot be written, there is no other place to report to.
        let _ = writeln!(io::stderr(), "stiction: warning: {sentence}");
    }
}
