//! `stiction benchmark`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::bar::Bar;
use super::outputs::drew;
use super::own_laws::OwnLawArguments;
use super::tune::tune_each;
use super::{print, warn};
use figure::{figure_directory, figures, write_figures};
use files::error::Error;
use files::goal::GoalInBothUnits;
use simulator::experiment::{Document, Experiment};
use simulator::output::OverwriteGuard;
use simulator::output::grid::{self, number};
use simulator::output::sides::{self, REST, SETTLED, ShownSides};
use simulator::rules::TUNING_SEEDS;
use studies::benchmark::{Benchmark, Score, Weights, benchmark, plain_runs};
use studies::tuning::{GainSearch, TuningGoal, TuningResult, spreads};

#[derive(Debug, clap::Args)]
pub struct BenchmarkArguments {
    /// A machine's own TOML file, with several controllers [default: the thesis's robot]
    file: Option<String>,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Draw the figures into this directory, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// With --plot: write over a file that this command reads, or over a machine's file
    #[arg(long, requires = "plot")]
    force: bool,
    /// Weights of columns in the ranking, as in settling=2,chatter=0 [default: 1 each]. The
    /// columns: rest, overshoot, settling, tracking, chatter, hunting, sticks
    #[arg(long, value_name = "COLUMN=WEIGHT", value_delimiter = ',')]
    weights: Vec<String>,
    #[command(flatten)]
    own: OwnLawArguments,
    #[command(flatten)]
    tuning: TuningArguments,
}

/// Options of a command that tunes each law before it compares them.
#[derive(Debug, clap::Args)]
pub struct TuningArguments {
    /// Tune each controller first, as `stiction tune` does, on joints around the file's. No file is
    /// written. Takes as long as `tune --controller all`
    #[arg(long)]
    tuned: bool,
    /// Objective of the gains
    #[arg(long, value_enum, default_value_t = TuningGoal::Balanced, requires = "tuned")]
    goal: TuningGoal,
    /// Number of joints on which gains are tuned
    #[arg(long, default_value_t = 8, requires = "tuned")]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=1000))]
    cases: u64,
    /// Seed of these joints; the gains are judged on the joints of the next seed
    #[arg(long, default_value_t = *TUNING_SEEDS.start(), requires = "tuned")]
    seed: u64,
}

impl TuningArguments {
    /// Returns whether the laws are tuned first.
    #[cfg(feature = "report")]
    pub const fn is_asked(&self) -> bool {
        self.tuned
    }

    /// Returns the options as they were given, with a blank before each; empty without --tuned.
    #[cfg(feature = "report")]
    pub fn options(&self) -> String {
        if !self.tuned {
            return String::new();
        }
        let goal = clap::ValueEnum::to_possible_value(&self.goal);
        let goal = goal.map_or_else(String::new, |goal| format!(" --goal {}", goal.get_name()));
        format!("{goal} --cases {} --seed {}", self.cases, self.seed)
    }

    /// Returns the number of joints, and their seed.
    #[cfg(feature = "report")]
    pub const fn joints(&self) -> (u64, u64) {
        (self.cases, self.seed)
    }

    /// Tunes the controllers of the first document, and sets the gains in all documents, which must
    /// name the same controllers. If any document has trajectories, the first ones are used.
    /// Without `--tuned`, nothing is changed.
    ///
    /// # Errors
    /// Returns the errors of `tune`.
    pub fn applied(&self, documents: &mut [Document]) -> Result<Vec<TuningResult>, Error> {
        const TRAJECTORIES: &str = "reference.trajectories";
        let Some(first) = documents.first().filter(|_| self.tuned) else { return Ok(vec![]) };
        let mut document = first.clone();
        let trajectories = documents.iter().find_map(|one| one.get(TRAJECTORIES));
        if let Some(trajectories) = trajectories {
            document.set(&[format!("{TRAJECTORIES}={trajectories}")])?;
        }
        let mut controllers: Vec<String> = Vec::new();
        for name in plain_runs(&document)?.into_iter().filter_map(|plan| plan.controller) {
            if !controllers.contains(&name) {
                controllers.push(name);
            }
        }
        let request = GainSearch {
            file: document.origin.name.clone(),
            goal: self.goal,
            limits: vec![],
            spreads: spreads(&document)?,
            cases: self.cases,
            seed: self.seed,
            document,
        };
        let tuned = tune_each(&request, &controllers)?;
        let set: Vec<(String, f64)> = tuned.iter().flat_map(TuningResult::set).collect();
        documents.iter_mut().try_for_each(|document| document.set_numbers(&set))?;
        Ok(tuned)
    }
}

pub fn rank(arguments: &BenchmarkArguments) -> Result<(), Error> {
    let weights = Weights::read(&arguments.weights)?;
    let guard = OverwriteGuard::new(arguments.force);
    let guard = arguments.file.iter().fold(guard, |guard, file| guard.opens(file));
    let plot = arguments.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
    let plot = plot.transpose()?;
    let mut documents = match &arguments.file {
        Some(file) => vec![Document::open(file)?],
        None => vec![Document::open("step-response")?, Document::open("trajectory")?],
    };
    for document in &documents {
        warn(&document.doubts()?);
        warn(&Experiment::plan(document, &[], &[])?.left_out);
    }
    let tuned = arguments.tuning.applied(&mut documents)?;
    // The user's own laws have no gains to tune.
    let own = arguments.own.names()?;
    documents.iter_mut().try_for_each(|document| document.add_controllers(&[], &own).map(drop))?;
    let ranked = benchmark(&documents, &weights, &Bar::new())?;
    if let Some(directory) = &plot {
        let mut count = 0;
        for (document, results) in documents.iter().zip(&ranked.results) {
            let figures = figures(&document.origin.name, results, &document.machine()?.figures);
            write_figures(directory, &figures)?;
            count += figures.len();
        }
        drew(count, directory)?;
    }
    if arguments.json {
        let mut object = serde_json::json!({
            "schema": 1,
            "weights": weights.iter().collect::<BTreeMap<_, _>>(),
            "goal": goal(&documents, &ranked)?,
            "unseen_slack": ranked.unseen_slack,
            "controllers": ranked.scores,
        });
        if let (Some(first), false) = (documents.first(), tuned.is_empty()) {
            object["tuned"] = studies::tuning::object(&first.origin.name, &tuned);
        }
        return print(&format!("{object:#}\n"));
    }
    print(&(render(&ranked) + &tuned_sentence(&arguments.tuning, &tuned)))
}

/// Returns the ranking's goal, with its tolerance in both units; `None` without a document.
fn goal(documents: &[Document], ranked: &Benchmark) -> Result<Option<GoalInBothUnits>, Error> {
    let Some(first) = documents.first() else { return Ok(None) };
    Ok(Some(ranked.goal.in_both_units(first.machine()?.count_deg())))
}

/// Returns sentences on the controllers for which tuning has found better gains, and on the others.
fn tuned_sentence(tuning: &TuningArguments, tuned: &[TuningResult]) -> String {
    if tuned.is_empty() {
        return String::new();
    }
    let names = |better: bool| {
        let some = tuned.iter().filter(|one| one.better == better);
        some.map(|one| one.controller.as_str()).collect::<Vec<_>>().join(", ")
    };
    let joints = format!("on {} joints around the file's, seed {}", tuning.cases, tuning.seed);
    let mut text = String::new();
    if !names(true).is_empty() {
        text += &format!("Tuned {joints}: {}.\n", names(true));
    }
    if !names(false).is_empty() {
        text += &format!("Nothing better was found {joints}: {}.\n", names(false));
    }
    text
}

/// Returns the table with its legend, and the reasons why controllers are not ranked. If the
/// encoder cannot measure slack, rest and settling are in a second table, for both sides of the
/// gear. Otherwise, if the file has a goal, only settling is in a second table.
fn render(ranked: &Benchmark) -> String {
    let Benchmark { scores, unseen_slack, goal, .. } = ranked;
    let slack = unseen_slack.as_ref();
    let shown = ShownSides::of(slack, goal);
    let header = [
        "controller",
        "mean\nplace",
        REST,
        "over-\nshoot\ndeg",
        SETTLED,
        "tracking\nrms\ndeg",
        "chatter\nV/s",
        "hunts\n120 s\ncounts",
        "sticks\nin\nmotion",
    ];
    let is_kept = |title: &str| !shown.replaces().contains(&title);
    let kept: Vec<&str> = header.into_iter().filter(|title| is_kept(title)).collect();
    let mut table = grid::new(&kept);
    for score in scores {
        let named = header.into_iter().zip(cells(score));
        table.add_row(named.filter_map(|(title, cell)| is_kept(title).then_some(cell)));
    }
    let mut text = table.trim_fmt() + "\n\n";
    if shown != ShownSides::Nothing {
        let rows = scores.iter().map(|score| (score.controller.clone(), &score.sides));
        text += &shown.table("steps", rows);
        text += "\n";
    }
    text += match shown {
        ShownSides::BothSides => LEGEND_AT_ENCODER,
        ShownSides::OneSide => LEGEND_BY_GOAL,
        ShownSides::Nothing => LEGEND,
    };
    if shown != ShownSides::Nothing {
        text += &sides::legend(slack, goal);
    }
    let remarks = scores.iter().filter_map(|score| {
        let why = score.disqualified?.describe();
        Some(format!("Not ranked: {}, which {why}.\n", score.controller))
    });
    text + &remarks.collect::<String>()
}

/// Legend for a joint whose encoder measures the load, and whose file has no goal.
const LEGEND: &str = "\
Each value is the worst of the controller's runs, all simulated. Settled: within
0.05 deg and staying. Sticks: stops on the way of a trajectory. Ranked by the
weighted mean of the places in the seven columns; \"-\": no run of that kind.
";

/// Legend for a joint whose encoder measures the load, and whose file has a goal.
const LEGEND_BY_GOAL: &str = "\
Each value is the worst of the controller's runs, all simulated. Sticks: stops
on the way of a trajectory. Ranked by the weighted mean of the places in the
columns of the first table, and in the time after which the goal is met. \"-\":
no run of that kind.
";

/// Legend for a joint whose encoder cannot measure slack.
const LEGEND_AT_ENCODER: &str = "\
Each value is the worst of the controller's runs, all simulated. Sticks: stops
on the way of a trajectory. Ranked by the weighted mean of the places in the
columns of the first table, and in rest and settling at the encoder: no law
corrects what its encoder cannot see. \"-\": no run of that kind.
";

/// Returns the cells of a controller's row.
fn cells(score: &Score) -> [String; 9] {
    let settled = match score.settling_time_s {
        None if score.overshoot_deg.is_some() => "never".into(),
        settled => number(settled, 2),
    };
    let hunting = match score.hunting_counts {
        Some(0.0) => "none".into(),
        hunting => number(hunting, 1),
    };
    [
        score.controller.clone(),
        number(score.mean_place, 1),
        number(score.rest_error_counts, 1),
        number(score.overshoot_deg, 3),
        settled,
        number(score.tracking_rms_deg, 3),
        number(score.chatter_v_per_s, 2),
        hunting,
        number(score.sticks_in_motion, 0),
    ]
}
