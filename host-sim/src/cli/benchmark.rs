//! `stiction benchmark`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{drawn, print, warn, wrote};
use crate::benchmark::{Score, Weights, benchmark};
use crate::error::Error;
use crate::experiment::{Document, Experiment};
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
    /// Weights of columns in the ranking, as in settling=2,chatter=0; the others have the weight 1.
    /// The columns: rest, overshoot, settling, tracking, chatter, hunting, sticks
    #[arg(long, value_name = "COLUMN=WEIGHT", value_delimiter = ',')]
    weights: Vec<String>,
}

pub fn rank(arguments: &Arguments) -> Result<(), Error> {
    let weights = Weights::read(&arguments.weights)?;
    let documents = match &arguments.file {
        Some(file) => vec![Document::open(file)?],
        None => vec![Document::open("step-response")?, Document::open("trajectory")?],
    };
    for document in &documents {
        warn(&document.doubts()?);
        warn(&Experiment::plan(document, &[], &[])?.left_out);
    }
    if let Some(directory) = &arguments.plot {
        prepare_figures(directory)?;
    }
    let ranked = benchmark(&documents, &weights)?;
    if let Some(directory) = &arguments.plot {
        let mut count = 0;
        for (document, results) in documents.iter().zip(&ranked.results) {
            let figures = figures(&document.origin.name, results, &document.machine()?.figures);
            write_figures(directory, &figures)?;
            count += figures.len();
        }
        wrote(&drawn(count, directory))?;
    }
    if arguments.json {
        let object = serde_json::json!({
            "schema": 1,
            "weights": weights.iter().collect::<BTreeMap<_, _>>(),
            "controllers": ranked.scores,
        });
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
        "sticks\nin\nmotion",
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
            number(score.mean_place, 1),
            number(score.rest_error_counts, 1),
            number(score.overshoot_deg, 3),
            settled,
            number(score.tracking_rms_deg, 3),
            number(score.chatter_v_per_s, 2),
            hunting,
            number(score.sticks_in_motion, 0),
        ]);
    }
    let legend = "\
Each value is the worst of the controller's runs, all simulated. Settled: within
0.05 deg and staying. Sticks: stops on the way of a trajectory. Ranked by the
weighted mean of the places in the seven columns; \"-\": no run of that kind.";
    let remarks = scores.iter().filter_map(|score| {
        let why = score.disqualified?.describe();
        Some(format!("Not ranked: {}, which {why}.\n", score.controller))
    });
    format!("{}\n\n{legend}\n{}", table.trim_fmt(), remarks.collect::<String>())
}
