//! `stiction run`.

use std::path::PathBuf;

use super::outputs::{check_standard_output, drew, print_beside, wrote};
use super::own_laws::OwnLawArguments;
use super::{print, target, warn};
use figure::{figure_directory, figures, set_title, write_figures};
use files::error::Error;
use simulator::experiment::{Document, Experiment};
use simulator::output::{OutputDirectory, OutputFile, OverwriteGuard, csv, json, table};
use simulator::supply::SupplyCourse;
use thesis::lab::{self, LabResult};

#[derive(Debug, clap::Args)]
pub struct RunArguments {
    /// A name from `stiction list`, or a machine's own TOML file
    experiment: String,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Write the time series to this file; - for the standard output. Several runs have their
    /// labels in the first column
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the figures into this directory, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
    /// A title for the figures
    #[arg(long, value_name = "TEXT", requires = "plot")]
    title: Option<String>,
    /// Set a key of the file, as in run.duration_s=120
    #[arg(long, value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// Only these controllers
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    controller: Vec<String>,
    #[command(flatten)]
    own: OwnLawArguments,
    /// Friction experiments: only this model (short for --set run.friction=...)
    #[arg(long, value_name = "MODEL", value_delimiter = ',')]
    friction: Vec<String>,
    /// Friction experiments: simultaneous, neglected or previous-step (short for --set
    /// run.coupling=...)
    #[arg(long, value_name = "COUPLING")]
    coupling: Vec<String>,
    /// Solver of the motion (short for --set run.solver=...)
    #[arg(long, value_name = "exact|rk4|rk4-adaptive|nonsmooth")]
    solver: Option<String>,
    /// Samples of computation delay (short for --set run.delay_samples=...)
    #[arg(long, value_name = "0|1", allow_hyphen_values = true)]
    delay: Option<String>,
    /// Supply of the bridge over the nominal one, from 0.1 to 2
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    supply: Option<f64>,
    /// A sag of the supply: the supply in it over that before, its start and its duration, s
    #[arg(
        long,
        value_name = "RATIO,FROM_S,FOR_S",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    sag: Vec<f64>,
    #[command(flatten)]
    target: target::TargetArguments,
}

pub fn run(arguments: &RunArguments) -> Result<(), Error> {
    let outputs = arguments.outputs()?;
    let mut document = Document::open(&arguments.experiment)?;
    if document.is_lab() {
        return arguments.run_lab(document, &outputs);
    }
    for (option, given) in
        [("--friction", &arguments.friction), ("--coupling", &arguments.coupling)]
    {
        if let Some(first) = given.first() {
            let why =
                format!("{} positions a joint, whose file sets its friction", document.origin);
            return Err(Error::Input(format!(
                "{option} {first} is only for friction experiments; {why}"
            )));
        }
    }
    let assignments = arguments.assignments();
    document.set(&assignments)?;
    warn(&document.doubts()?);
    let fixed: Vec<String> = assignments
        .iter()
        .filter_map(|a| a.split_once('='))
        .map(|(key, _)| key.trim().into())
        .collect();
    let own = arguments.own.names()?;
    let controllers = document.add_controllers(&arguments.controller, &own)?;
    let experiment = Experiment::plan(&document, &controllers, &fixed)?;
    warn(&experiment.left_out);
    let mut runs = experiment.runs.clone();
    if let Some(supply) = SupplyCourse::of_options(arguments.supply, &arguments.sag)? {
        if arguments.target.is_emulator() {
            let why = "the emulated board has the supply of the file; use --target host or servo";
            let option = if arguments.supply.is_some() { "--supply" } else { "--sag" };
            return Err(Error::Input(format!("{option} with --target emulator: {why}")));
        }
        runs = runs.into_iter().map(|run| run.with_supply(supply)).collect::<Result<_, _>>()?;
    }
    let results = arguments.target.run(&runs)?;
    if let Some(file) = &outputs.csv {
        let text = csv::render(&results).map_err(|error| Error::Input(error.to_string()))?;
        file.write(&text)?;
        wrote(file)?;
    }
    if let Some(directory) = &outputs.plot {
        let mut figures = figures(&experiment.name, &results, &document.machine()?.figures);
        if let Some(title) = &arguments.title {
            set_title(&mut figures, title);
        }
        write_figures(directory, &figures)?;
        drew(figures.len(), directory)?;
    }
    if arguments.json {
        let text =
            json::render(&experiment, &results).map_err(|error| Error::Input(error.to_string()))?;
        print(&(text + "\n"))
    } else {
        print_beside(outputs.csv.as_ref(), &table::render(&results))
    }
}

/// Output paths that have passed the guard.
struct Outputs {
    csv: Option<OutputFile>,
    plot: Option<OutputDirectory>,
}

impl RunArguments {
    /// Checks the output paths before anything is run.
    fn outputs(&self) -> Result<Outputs, Error> {
        let guard = OverwriteGuard::new(self.force).opens(&self.experiment);
        let guard = self.target.image().into_iter().fold(guard, OverwriteGuard::reads);
        let csv = self.csv.as_ref().map(|path| guard.results("--csv", path)).transpose()?;
        check_standard_output(self.json, csv.as_ref())?;
        let plot = self.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
        Ok(Outputs { csv, plot: plot.transpose()? })
    }

    /// Runs a friction experiment, which has neither a controller nor samples.
    fn run_lab(&self, mut document: Document, outputs: &Outputs) -> Result<(), Error> {
        let foreign = [
            ("--controller", !self.controller.is_empty()),
            ("--law", !self.own.is_empty()),
            ("--delay", self.delay.is_some()),
            ("--supply", self.supply.is_some()),
            ("--sag", !self.sag.is_empty()),
            ("--target emulator", !self.target.is_host()),
        ];
        if let Some((option, _)) = foreign.iter().find(|(_, given)| *given) {
            let name = &document.origin;
            return Err(Error::Input(format!("{option} needs a controller, and {name} has none")));
        }
        for (option, given, what) in [
            ("--friction", &self.friction, "a joint has one friction model"),
            ("--coupling", &self.coupling, "a run has one"),
        ] {
            if given.len() > 1 {
                let names = given.join(",");
                return Err(Error::Input(format!(
                    "{option} {names} names {}; {what}",
                    given.len()
                )));
            }
        }
        let friction = self.friction.iter().map(|model| format!("run.friction=[{model:?}]"));
        let coupling = self.coupling.iter().map(|coupling| format!("run.coupling={coupling}"));
        let assignments: Vec<String> =
            self.assignments().into_iter().chain(friction).chain(coupling).collect();
        document.set(&assignments)?;
        let plans = lab::plan(&document)?;
        let (results, given_up) = split_failed(lab::run_all(&plans));
        if results.is_empty() {
            return given_up;
        }
        if let Some(file) = &outputs.csv {
            let text =
                lab::output::csv(&results).map_err(|error| Error::Input(error.to_string()))?;
            file.write(&text)?;
            wrote(file)?;
        }
        let setup = document.setup()?;
        if let Some(directory) = &outputs.plot {
            let mut figures = lab::figures(&document.origin.name, &setup, &results);
            if let Some(title) = &self.title {
                set_title(&mut figures, title);
            }
            write_figures(directory, &figures)?;
            drew(figures.len(), directory)?;
        }
        if self.json {
            let text = lab::output::json(&document.origin.name, &setup.source, &results);
            print(&(text.map_err(|error| Error::Input(error.to_string()))? + "\n"))?;
        } else {
            print_beside(outputs.csv.as_ref(), &lab::output::table(&results))?;
        }
        given_up
    }

    /// Returns every key set by an option, in the form of `--set`.
    fn assignments(&self) -> Vec<String> {
        let solver = self.solver.iter().map(|solver| format!("run.solver={solver}"));
        let delay = self.delay.iter().map(|delay| format!("run.delay_samples={delay}"));
        self.set.iter().cloned().chain(solver).chain(delay).collect()
    }
}

/// Splits runs into the results and an error that names every run whose solver failed.
fn split_failed(runs: Vec<Result<LabResult, Error>>) -> (Vec<LabResult>, Result<(), Error>) {
    let count = runs.len();
    let (mut results, mut given_up) = (Vec::new(), Vec::new());
    for run in runs {
        match run {
            Ok(result) => results.push(result),
            Err(error) => given_up.push(error.to_string()),
        }
    }
    let why = given_up.join("; ");
    let error = match given_up.len() {
        0 => return (results, Ok(())),
        1 if count == 1 => why,
        1 => format!("1 of {count} runs failed: {why}"),
        some => format!("{some} of {count} runs failed: {why}"),
    };
    (results, Err(Error::Run(error)))
}
