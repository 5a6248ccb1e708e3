//! `stiction benchmark`.

use std::path::PathBuf;

use super::print;
use crate::benchmark::{Score, benchmark};
use crate::error::Error;
use crate::experiment::Document;
use crate::figure::{figures, prepare_figures, write_figures};
use crate::output::table::{self, number};

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
        prepare_figures(directory)?;
    }
    let ranked = benchmark(&documents)?;
    if let Some(directory) = &arguments.plot {
        for (document, results) in documents.iter().zip(&ranked.results) {
            write_figures(
                directory,
                &figures(&document.origin.name, results, &document.machine()?.figures),
            )?;
        }
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
        let settled = match score.settling_time_s {
            None if score.overshoot_deg.is_some() => "never".into(),
            settled => number(settled, 2),
        };
        let hunting = match score.hunting_counts {
            Some(0.0) => "none".into(),
            hunting => number(hunting, 1),
        };
        table.add_row([
            score.controller.clone(),
            number(Some(score.mean_place), 1),
            number(score.rest_error_counts, 1),
            number(score.overshoot_deg, 3),
            settled,
            number(score.tracking_rms_deg, 3),
            number(score.chatter_v_per_s, 2),
            hunting,
        ]);
    }
    let legend = "\
Each value is the worst of the controller's runs, all simulated. Settled: within
0.05 deg and staying. Ranked by the mean of the places in the six columns, all
of equal weight; \"-\": no run of that kind.";
    let unstable = scores.iter().filter(|score| score.unstable);
    let remarks =
        unstable.map(|score| format!("{}: unstable, and ranked last\n", score.controller));
    format!("{}\n\n{legend}\n{}", table.trim_fmt(), remarks.collect::<String>())
}
