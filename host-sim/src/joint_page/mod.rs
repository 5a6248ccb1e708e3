//! One page on a user's own joint: its description and spread, the laws compared on it, the best
//! one, and the expected self-test.
//!
//! `rows.rs` makes the tables; the template is `joint.html`. Everything is
//! simulated when the page is made. Guarantees: the page is self-contained; the same file and seed
//! make the same page. Limit: the page describes the joint of the file with its spread, not the
//! real one.

mod rows;

use std::path::{Path, PathBuf};

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value, context};

use self::rows::{DescriptionRow, ExpectedSelftest, SpreadRow};
use figure::figures;
use figure::page::DrawingView;
use files::document::Document;
use files::error::Error;
use simulator::device::{self, machine_file};
use simulator::experiment::{Experiment, RunPlan};
use simulator::output::OutputDirectory;
use simulator::progress::Progress;
use simulator::run::RunResult;
use studies::benchmark::{Benchmark, Score, Weights, benchmark};
use studies::ensemble::goal_of_steps;
use studies::selftest::{self, MoveRange, targets};
use studies::tuning::{GainSearch, TuningGoal, TuningResult, spreads};

/// Moves, joints and seed of the predicted self-test: the defaults of `device selftest`.
const SELFTEST: (usize, u64, u64) = (20, 24, 2026);

/// Number of laws that are drawn over each other; more cannot be distinguished in print.
const COMPARED: usize = 3;

/// Inputs of the page.
#[derive(Clone, Debug)]
pub struct JointPageRequest {
    /// The file, with the gains of `tuned`.
    pub document: Document,
    /// Results of tuning, if laws were tuned.
    pub tuned: Vec<TuningResult>,
    /// Options of tuning as given, with a blank before each: ` --goal settle ..`.
    pub options: String,
    /// Number of joints on which gains are tuned; each law is judged on three times as many.
    pub cases: u64,
    /// Seed of tuning; laws are judged on the joints of the next seed.
    pub seed: u64,
}

/// Writes the page into a directory, with the name of the machine's file. Returns its path.
///
/// # Errors
/// Reports what is wrong with the file, or what could not be written.
pub fn make(
    asked: &JointPageRequest,
    directory: &OutputDirectory,
    progress: &impl Progress,
) -> Result<PathBuf, Error> {
    directory.write(&page_name(&asked.document.origin.name), rendered(asked, progress)?.as_bytes())
}

/// Returns the file name of the page on a machine's file.
pub fn page_name(machine: &str) -> String {
    let stem = Path::new(machine).file_stem().unwrap_or_default();
    format!("{}.html", stem.to_string_lossy())
}

fn rendered(asked: &JointPageRequest, progress: &impl Progress) -> Result<String, Error> {
    let JointPageRequest { document, tuned, options, cases, seed } = asked;
    let file = &document.origin.name;
    let machine = document.machine()?;
    let ranked = benchmark(std::slice::from_ref(document), &Weights::default(), progress)?;
    let chosen = ranked
        .scores
        .iter()
        .find(|score| score.disqualified.is_none())
        .or(ranked.scores.first())
        .ok_or_else(|| none_to_report_on(document))?;
    let request = GainSearch {
        file: file.clone(),
        document: document.clone(),
        goal: TuningGoal::Balanced,
        limits: vec![],
        spreads: spreads(document)?,
        cases: *cases,
        seed: *seed,
    };
    let laws = rows::laws(&ranked.scores, &request, tuned)?;
    let expected = expected(document, &chosen.controller, &request.spreads)?;
    let described: Vec<DescriptionRow> = rows::described(document)?;
    let off: Vec<SpreadRow> = rows::off(&request.spreads);
    let gains = rows::gains(&machine, &chosen.controller, tuned);
    let drawings = drawings(file, &ranked, &chosen.controller)?;
    let worst = request.standing(&chosen.controller)?.worst;
    let worst = worst.map(|(drawn, delay, row)| rows::worst(&drawn, delay, &row));
    let broken = |error: minijinja::Error| Error::Figure(format!("the joint's page: {error}"));
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let template = environment.template_from_str(include_str!("joint.html")).map_err(broken)?;
    let page = template.render(context! {
        style => Value::from_safe_string(figure::page::STYLE.into()),
        script => Value::from_safe_string(figure::page::SCRIPT.into()),
        version => env!("CARGO_PKG_VERSION"),
        file => file,
        title => if machine.title.is_empty() { file.as_str() } else { machine.title.as_str() },
        source => machine.source,
        doubts => document.doubts()?,
        described => Value::from(Serde(described)),
        has_si => document.data_sheet()?.is_some(),
        off => Value::from(Serde(off)),
        off_is_assumed => machine.spread.is_empty(),
        verdict => machine.identified.map(|identified| identified.verdict),
        laws => Value::from(Serde(laws)),
        slack => ranked.unseen_slack.map(|slack| slack.to_string()),
        goal => ranked.goal.describe(),
        goal_around => goal_of_steps(ranked.goal).describe(),
        has_goal => !ranked.goal.is_default(),
        is_tuned => !tuned.is_empty(),
        options => options,
        has_new_gains =>
            tuned.iter().any(|one| one.better && one.controller == chosen.controller),
        is_first => machine.sampling.extras.list().first() == Some(&chosen.controller),
        chosen => chosen.controller.clone(),
        disqualified => chosen.disqualified.map(|why| why.describe()),
        gains => Value::from(Serde(gains)),
        worst => worst,
        drawings => Value::from(Serde(drawings)),
        expected => Value::from(Serde(expected)),
        cases => request.judges(),
        seed => seed.wrapping_add(1),
    });
    page.map_err(broken)
}

/// Returns the error of a file without a run that the benchmark ranks.
fn none_to_report_on(document: &Document) -> Error {
    Experiment::without_variants(document, &[]).err().unwrap_or_else(|| {
        Error::Input(format!(
            "{}: in every run the output is one sample late, but only runs without delay are \
             ranked; set `run.delay_samples` to 0",
            document.origin.of("run.delay_samples")
        ))
    })
}

/// Returns the expected self-test under a controller; `None` if no device can run the controller,
/// or if the range of the moves is too small.
fn expected(
    document: &Document,
    controller: &str,
    spreads: &[String],
) -> Result<Option<ExpectedSelftest>, Error> {
    let runs = Experiment::without_variants(document, &[controller.to_owned()])?;
    let Some(Ok(parameters)) = runs.first().map(device::parameters) else { return Ok(None) };
    let range = MoveRange::derived(&parameters, 0.0);
    if range.deg < range.least_deg() {
        return Ok(None);
    }
    let (moves, joints, seed) = SELFTEST;
    let request = selftest::PredictionInput {
        document: document.clone(),
        parameters,
        spreads: spreads.to_vec(),
        joints,
        seed,
        targets: targets(range, moves),
    };
    let prediction = request.predict()?;
    let gains = machine_file::tables(&request.parameters)?;
    Ok(Some(rows::expected(range, &request.targets, &prediction, gains)))
}

/// Draws the first laws over each other, then the motions of the chosen law.
fn drawings(file: &str, ranked: &Benchmark, chosen: &str) -> Result<Vec<DrawingView>, Error> {
    let of = |plan: &RunPlan, names: &[&str]| {
        names.iter().any(|name| plan.controller.as_deref() == Some(*name))
    };
    let some = |names: &[&str]| -> Vec<RunResult> {
        ranked.results.iter().flatten().filter(|run| of(&run.plan, names)).cloned().collect()
    };
    let first: Vec<&str> = ranked
        .scores
        .iter()
        .take(COMPARED)
        .map(|score: &Score| score.controller.as_str())
        .collect();
    let mut named = figures(file, &some(&first), &[]);
    named.retain(|one| one.stem.contains("-compared"));
    named.extend(figures(file, &some(&[chosen]), &[]));
    let draw = |(place, one): (usize, &figure::NamedFigure)| {
        let id = format!("drawing-{place}");
        let svg = one
            .figure
            .to_inline_svg(&id)
            .map_err(|error| Error::Figure(format!("`{}`: {error}", one.stem)))?;
        Ok(DrawingView { title: one.figure.title.clone(), svg })
    };
    named.iter().enumerate().map(draw).collect()
}
