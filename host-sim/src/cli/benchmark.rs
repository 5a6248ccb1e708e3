//! `stiction benchmark`.

use std::path::PathBuf;

use super::print;
use crate::benchmark::{Score, benchmark};
use crate::error::Error;
use crate::experiment::Document;
use crate::figure::figures;
use crate::output::table::{self, number};
use crate::output::{prepare_directory, write_figures};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A machine's own TOML file, with several controllers; left out: the thesis's robot
    file: Option<String>,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Draw the figures into this directory, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
}

pub fn rank(arguments: &Arguments) -> Result<(), Error> {
    let documents = match &arguments.file {
        Some(file) => vec![Document::open(file)?],
        None => vec![Document::open("step-response")?, Document::open("trajectory")?],
    };
    if let Some(directory) = &arguments.plot {
        prepare_directory(directory)?;
    }
    let ranked = benchmark(&documents)?;
    if let Some(directory) = &arguments.plot {
        let mut all = Vec::new();
        for document in &documents {
            let runs: Vec<_> = ranked
                .results
                .iter()
                .filter(|result| result.plan.origin == document.origin)
                .cloned()
                .collect();
            all.extend(figures(&runs, &document.machine()?.figures));
        }
        write_figures(directory, &all)?;
    }
    if arguments.json {
        let object = serde_json::json!({ "schema": 1, "controllers": ranked.scores });
        return print(&format!("{object:#}\n"));
    }
    print(&render(&ranked.scores))
}

fn render(scores: &[Score]) -> String {
    let header = [
        "controller",
        "mean\nplace",
        "rest\ncounts",
        "over-\nshoot\ndeg",
        "settled\ns",
        "tracking\nrms\ndeg",
        "chatter\nV/s",
        "hunts\n120 s\ncounts",
    ];
    let mut table = table::new(&header);
    for score in scores {
        let hunting = score.hunting_counts.filter(|counts| *counts > 0.0);
        table.add_row([
            score.controller.clone(),
            number(Some(score.mean_place), 1),
            number(score.rest_error_counts, 1),
            number(score.overshoot_deg, 3),
            number(score.settling_time_s, 2),
            number(score.tracking_rms_deg, 3),
            number(score.chatter_v_per_s, 2),
            number(hunting, 1),
        ]);
    }
    let legend =
        "Each value is the worst of the controller's runs, simulated. A dash: it never settles within
0.05 deg, or does not hunt. Ranked by the mean of the places in the six columns.";
    format!("{}\n\n{legend}\n", table.trim_fmt())
}
