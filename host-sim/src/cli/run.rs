//! `stiction run`.

use std::path::PathBuf;

use super::{print, target};
use crate::error::Error;
use crate::experiment::{Document, Experiment};
use crate::figure::figures;
use crate::output::{csv, json, prepare_directory, table, write_figures, write_whole};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A name from `stiction list`, or a machine's own TOML file
    experiment: String,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Write the time series to this file (of several runs: with their labels in the first column)
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the figures into this directory, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Set a key of the file, as in run.duration_s=120
    #[arg(long, value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// Only these controllers
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',')]
    controller: Vec<String>,
    /// How the axis is solved between samples (short for --set run.solver=...)
    #[arg(long, value_name = "exact|rk4")]
    solver: Option<String>,
    /// Samples of computation delay (short for --set run.delay_samples=...)
    #[arg(long, value_name = "0|1", allow_hyphen_values = true)]
    delay: Option<String>,
    #[command(flatten)]
    target: target::TargetArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut document = Document::open(&arguments.experiment)?;
    let assignments = arguments.assignments();
    document.set(&assignments)?;
    let fixed: Vec<String> =
        assignments.iter().filter_map(|a| a.split_once('=')).map(|(key, _)| key.trim().into()).collect();
    let experiment = Experiment::plan(&document, &arguments.controller, &fixed)?;
    if let Some(directory) = &arguments.plot {
        prepare_directory(directory)?;
    }
    let results = arguments.target.run(&experiment.runs)?;
    if let Some(path) = &arguments.csv {
        let text = csv::render(&results).map_err(|error| Error::Input(error.to_string()))?;
        write_whole(path, &text)?;
    }
    if let Some(directory) = &arguments.plot {
        let figures = figures(&experiment.name, &results, &document.machine()?.figures);
        write_figures(directory, &figures)?;
    }
    if arguments.json {
        let text = json::render(&experiment, &results).map_err(|error| Error::Input(error.to_string()))?;
        print(&(text + "\n"))
    } else {
        print(&table::render(&results))
    }
}

impl Arguments {
    /// Every key that is set by hand, in the form of `--set`.
    fn assignments(&self) -> Vec<String> {
        let solver = self.solver.iter().map(|solver| format!("run.solver={solver}"));
        let delay = self.delay.iter().map(|delay| format!("run.delay_samples={delay}"));
        self.set.iter().cloned().chain(solver).chain(delay).collect()
    }
}
