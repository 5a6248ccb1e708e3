//! `stiction tune`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use super::outputs::{check_standard_output, drew, print_beside, wrote};
use super::{print, warn};
use figure::{figure_directory, write_charts};
use files::error::{Error, suggestion};
use simulator::experiment::Document;
use simulator::output::OverwriteGuard;
use simulator::rules::TUNING_SEEDS;
use studies::ensemble::goal_of_steps;
use studies::tuning::{
    self, CASES, CASES_ALLOWED, GainSearch, TuningGoal, TuningResult, is_refused, object, render,
    rewritten, spreads,
};

#[derive(Debug, clap::Args)]
pub struct TuneArguments {
    /// A machine's file
    #[arg(value_name = "FILE.toml")]
    file: String,
    /// Controllers to tune, or `all` of the file's [default: the first]
    #[arg(long, value_name = "NAME|all", value_delimiter = ',')]
    controller: Vec<String>,
    /// Objective of the gains
    #[arg(long, value_enum, default_value_t = TuningGoal::Balanced)]
    goal: TuningGoal,
    /// Upper limit of a metric: settling_s, tracking_counts, rest_counts, chatter_v_per_s or
    /// held_v; can be repeated
    #[arg(long, value_name = "FIGURE=MOST")]
    limit: Vec<String>,
    /// Range of a key of the joint, instead of the file's [spread]; can be repeated [default
    /// without [spread]: 20 % of the inertia, 25 % of stick and slip friction, 50 % of the viscous
    /// friction]
    #[arg(long, value_name = "KEY=LOW..HIGH")]
    spread: Vec<String>,
    /// Number of joints around the file's; each is run with and without a sample of delay
    #[arg(long, default_value_t = CASES,
          value_parser = clap::value_parser!(u64).range(CASES_ALLOWED))]
    cases: u64,
    /// Seed of the joints; the gains are judged on those of the next seed
    #[arg(long, default_value_t = *TUNING_SEEDS.start())]
    seed: u64,
    /// The new file; - for the standard output [default: FILE.tuned.toml]
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Write over a file that exists
    #[arg(long)]
    force: bool,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Draw the sets of gains into this directory, a panel for each law: settling against tracking
    /// (if the file has a trajectory), settling against chatter, and rest error against held effort
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
}

pub fn tune(arguments: &TuneArguments) -> Result<(), Error> {
    arguments.run()
}

/// Tunes controllers one after the other, each on all cores.
pub(super) fn tune_each(
    request: &GainSearch,
    controllers: &[String],
) -> Result<Vec<TuningResult>, Error> {
    let bar = ProgressBar::new_spinner();
    let style = ProgressStyle::with_template("{spinner} {prefix}: {pos} sets of gains tried");
    let bar = style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style));
    let each = |controller: &String| {
        bar.set_position(0);
        bar.set_prefix(controller.clone());
        let sets = request.about_sets(controller)?;
        let (begin, is_first) = (Instant::now(), AtomicBool::new(true));
        request.tune(controller, &|| {
            // Until now only the file's own gains have run.
            if is_first.swap(false, Ordering::Relaxed) {
                let first_s = begin.elapsed().as_secs_f64();
                let said = tuning::takes_long(controller, first_s, sets, request.cases);
                bar.suspend(|| warn(said.as_slice()));
            }
            bar.inc(1);
        })
    };
    let tuned = controllers.iter().map(each).collect();
    bar.finish_and_clear();
    tuned
}

impl TuneArguments {
    fn run(&self) -> Result<(), Error> {
        let guard = OverwriteGuard::new(self.force).opens(&self.file);
        let out = self.out.clone().unwrap_or_else(|| tuned_name(&self.file));
        let out = guard.new_file("--out", &out)?;
        check_standard_output(self.json, Some(&out))?;
        let plot = self.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
        let plot = plot.transpose()?;
        let document = Document::open(&self.file)?;
        if document.is_lab() {
            let why = "is a friction experiment, which has no controller";
            return Err(Error::Input(format!("{} {why}", self.file)));
        }
        warn(&document.doubts()?);
        let slack = document.unseen_slack()?;
        warn(slack.map(|slack| format!("{}: {slack}", self.file)).as_slice());
        let machine = document.machine()?;
        let count_deg = machine.count_deg();
        let goal = goal_of_steps(machine.goal).in_both_units(count_deg);
        let text = Document::text(&self.file)?;
        let request = GainSearch {
            file: self.file.clone(),
            goal: self.goal,
            limits: self.limit.iter().map(|text| limit(text)).collect::<Result<_, _>>()?,
            spreads: if self.spread.is_empty() { spreads(&document)? } else { self.spread.clone() },
            cases: self.cases,
            seed: self.seed,
            document,
        };
        let controllers = self.controllers(&request.document)?;
        let tuned = tune_each(&request, &controllers)?;
        // The gains are written first, so that they are not lost if a chart fails.
        let is_refused = is_refused(&tuned);
        if !is_refused {
            out.write(rewritten(&text, &tuned)?.as_bytes())?;
            wrote(&out)?;
        }
        if let Some(directory) = &plot {
            let charts = request.charts(&tuned)?;
            write_charts(directory, &charts)?;
            drew(charts.len(), directory)?;
        }
        if self.json {
            let mut object = object(&self.file, &tuned);
            object["goal"] = json!(goal);
            object["unseen_slack"] = json!(slack);
            print(&format!("{object:#}\n"))?;
        } else {
            let text = render(&tuned) + &legend(request.judges(), &request.spreads);
            print_beside(Some(&out), &text)?;
        }
        if is_refused {
            return Err(Error::Run("no gains were found, and no file is written".into()));
        }
        Ok(())
    }

    /// Returns the selected controllers, by their names in the file.
    fn controllers(&self, document: &Document) -> Result<Vec<String>, Error> {
        let machine = document.machine()?;
        let listed = machine.sampling.extras.list();
        if self.controller.iter().any(|name| name == "all") {
            return Ok(listed.to_vec());
        }
        if self.controller.is_empty() {
            return Ok(listed.iter().take(1).cloned().collect());
        }
        for name in &self.controller {
            if !machine.controller.contains_key(name) {
                let near = suggestion(name, machine.controller.keys().map(String::as_str));
                let what = format!("--controller {name}: {} has no such controller", self.file);
                return Err(Error::Input(what + &near));
            }
        }
        Ok(self.controller.clone())
    }
}

/// Returns the default output: `joint.tuned.toml` beside `joint.toml`; for a built-in experiment, a
/// file in the current directory.
fn tuned_name(file: &str) -> PathBuf {
    Path::new(file).with_extension("tuned.toml")
}

fn limit(text: &str) -> Result<(String, f64), Error> {
    tuning::limit(text).map_err(|why| Error::Input(format!("--limit {text}: {why}")))
}

fn legend(cases: u64, spreads: &[String]) -> String {
    let mut text = format!(
        "All simulated. The gains are judged at the encoder. The figures are of {cases} joints\n\
         on which the gains were not tuned, each with and without a sample of delay:\n"
    );
    for spread in spreads {
        text += &format!("  {spread}\n");
    }
    text
}
