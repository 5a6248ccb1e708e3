//! Runs, rankings, ensembles and tuning; each returns the JSON of its command.

use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;

use super::arrays::bytes;
use super::error::{exception, refused, word};
use super::interrupt::{Interrupt, interruptible};
use super::law::{NamedLaw, Registered};
use files::document::Document;
use files::error::Error;
use simulator::experiment::Experiment;
use simulator::output::{arrays, json as json_of_runs};
use simulator::progress::Progress as _;
use simulator::rules::rules;
use simulator::run::{RunDriver, RunResult, run_all_driven};
use studies::benchmark::{Weights, benchmark as ranked};
use studies::ensemble::{
    Approach, Bridge, CASES_ALLOWED, CaseResult, Condition, DrawOptions, Ensemble, EnsembleHeader,
    MachineEnsemble, MachineOptions, allowed_rate, families_under, object, run as run_ensemble,
    sort_rows, summaries, written_spreads,
};
use studies::tuning::{
    self, CASES_ALLOWED as TUNING_CASES_ALLOWED, GainSearch, TuningGoal, is_refused, limit,
    rewritten, spreads,
};

/// Columns of a run with their names.
type Columns<'py> = Vec<(&'static str, Bound<'py, PyBytes>)>;

/// Opens a machine's file, and refuses a friction experiment.
fn machine(file: &str) -> Result<Document, Error> {
    let document = Document::open(file)?;
    if document.is_lab() {
        let why = "is a friction experiment, which has no controller";
        return Err(Error::Input(format!("{file} {why}")));
    }
    Ok(document)
}

/// Does work with laws of the user's own, whose names it passes to `does`.
fn beside<T: Send>(
    py: Python<'_>,
    laws: Vec<NamedLaw>,
    does: impl FnOnce(&Interrupt, &[String]) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let own = Registered::by_name(laws).map_err(|error| exception(&error))?;
    let names = own.names();
    let made = interruptible(py, |interrupt| does(interrupt, &names));
    made.map_err(|error| own.raised.cause_of(py, error))
}

/// Runs the experiment of a file.
#[pyfunction]
pub fn run<'py>(
    py: Python<'py>,
    file: &str,
    controllers: Vec<String>,
    set: Vec<String>,
    by_servo: bool,
    laws: Vec<NamedLaw>,
) -> PyResult<(String, Vec<Columns<'py>>)> {
    let driver = if by_servo { RunDriver::ByServo } else { RunDriver::ByLoop };
    let (report, results) = beside(py, laws, |interrupt, own| {
        let mut document = machine(file)?;
        document.set(&set)?;
        let controllers = document.add_controllers(&controllers, own)?;
        let keys = set.iter().filter_map(|one| Some(one.split_once('=')?.0.trim().to_owned()));
        let experiment = Experiment::plan(&document, &controllers, &keys.collect::<Vec<_>>())?;
        let results = run_all_driven(&experiment.runs, driver, interrupt)?;
        let report = json_of_runs::render(&experiment, &results);
        Ok((report.map_err(|error| Error::Run(error.to_string()))?, results))
    })?;
    let columns = |result: &RunResult| {
        let of_one = |(name, numbers): (&'static str, Vec<f64>)| (name, bytes(py, &numbers));
        arrays(result).into_iter().map(of_one).collect()
    };
    Ok((report, results.iter().map(columns).collect()))
}

/// Ranks the controllers of a file.
#[pyfunction]
pub fn benchmark(
    py: Python<'_>,
    file: &str,
    weights: Vec<String>,
    laws: Vec<NamedLaw>,
) -> PyResult<String> {
    beside(py, laws, |interrupt, own| {
        let weights = Weights::read(&weights)?;
        let mut document = machine(file)?;
        document.add_controllers(&[], own)?;
        let ranked = ranked(&[document], &weights, interrupt)?;
        Ok(json!(ranked.scores).to_string())
    })
}

/// Arguments of an ensemble of families.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FamilyArguments {
    families: Vec<String>,
    cases: u64,
    seed: u64,
    controllers: Vec<String>,
    hard: bool,
    rate: f64,
    condition: String,
    bridge: String,
    motion: String,
    moves: u32,
}

/// Rows collected from all cores.
#[derive(Default)]
struct Rows(Mutex<Vec<CaseResult>>);

impl Rows {
    fn take(&self, row: CaseResult) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(row);
    }

    /// Returns header, rows and summary as JSON.
    fn finished(self, header: &EnsembleHeader) -> String {
        let mut rows = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        sort_rows(header, &mut rows);
        let summary = object(header, &summaries(header, &rows));
        json!({ "header": header, "rows": rows, "summary": summary }).to_string()
    }
}

fn checked_cases(cases: u64) -> PyResult<()> {
    let [least, most] = [CASES_ALLOWED.start(), CASES_ALLOWED.end()];
    if CASES_ALLOWED.contains(&cases) {
        return Ok(());
    }
    Err(refused(&format!("--cases {cases}: must be a whole number from {least} to {most}")))
}

/// Runs laws on drawn joints of families.
#[pyfunction]
pub fn ensemble(
    py: Python<'_>,
    arguments: FamilyArguments,
    laws: Vec<NamedLaw>,
) -> PyResult<String> {
    let FamilyArguments { families, cases, seed, controllers, hard, rate, moves, .. } = arguments;
    checked_cases(cases)?;
    let condition: Condition = word("condition", &arguments.condition)?;
    let bridge: Bridge = word("bridge", &arguments.bridge)?;
    let approach: Approach = word("motion", &arguments.motion)?;
    let own = Registered::new(laws).map_err(|error| exception(&error))?;
    let made = interruptible(py, |interrupt| {
        let rules = rules(&controllers)?.into_iter().chain(own.rules.iter().copied()).collect();
        let ensemble = Ensemble {
            seed,
            cases,
            kind: DrawOptions { hard, rate_hz: allowed_rate(rate)?, condition, bridge },
            approach,
            moves,
            families: families_under(&families, condition, bridge)?,
            rules,
        };
        let rows = Rows::default();
        run_ensemble(
            &ensemble,
            interrupt,
            |_, _, _| true,
            |row| {
                rows.take(row);
                Ok(())
            },
        )?;
        Ok(rows.finished(&EnsembleHeader::of(&ensemble)))
    });
    made.map_err(|error| own.raised.cause_of(py, error))
}

/// Runs the controllers of a file on joints around the file's.
#[pyfunction]
pub fn ensemble_of_file(
    py: Python<'_>,
    file: &str,
    cases_and_seed: [u64; 2],
    controllers: Vec<String>,
    spread: Vec<String>,
    rate: Option<f64>,
    laws: Vec<NamedLaw>,
) -> PyResult<String> {
    let [cases, seed] = cases_and_seed;
    checked_cases(cases)?;
    beside(py, laws, |interrupt, guests| {
        let rate_hz = rate.map(allowed_rate).transpose()?;
        let written = written_spreads(&machine(file)?)?;
        let spreads = if spread.is_empty() { &*written } else { &*spread };
        let options = MachineOptions { controllers: &controllers, guests, spreads, rate_hz };
        let ensemble = MachineEnsemble::open(file, options)?;
        let rows = Rows::default();
        ensemble.run_some(
            [seed, cases],
            |_, _| true,
            |row| {
                rows.take(row);
                interrupt.step()
            },
        )?;
        Ok(rows.finished(&EnsembleHeader::of_machine(&ensemble, seed, cases)))
    })
}

/// Arguments of a tuning.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TuneArguments {
    goal: String,
    limits: Vec<String>,
    spread: Vec<String>,
    cases: u64,
    seed: u64,
}

/// Tunes a controller of a file; returns the JSON of `stiction tune`, and the text of the file with
/// the gains if some were found.
#[pyfunction]
pub fn tune(
    py: Python<'_>,
    file: &str,
    controller: &str,
    arguments: TuneArguments,
) -> PyResult<(String, Option<String>)> {
    let TuneArguments { limits, spread, cases, seed, .. } = arguments;
    if !TUNING_CASES_ALLOWED.contains(&cases) {
        let [least, most] = [TUNING_CASES_ALLOWED.start(), TUNING_CASES_ALLOWED.end()];
        let allowed = format!("must be a whole number from {least} to {most}");
        return Err(refused(&format!("--cases {cases}: {allowed}")));
    }
    let goal: TuningGoal = word("goal", &arguments.goal)?;
    let document = machine(file).map_err(|error| exception(&error))?;
    let limits = limits
        .iter()
        .map(|text| limit(text).map_err(|why| refused(&format!("--limit {text}: {why}"))));
    let limits = limits.collect::<PyResult<_>>()?;
    interruptible(py, |interrupt| {
        let spreads = if spread.is_empty() { spreads(&document)? } else { spread };
        let search = GainSearch { file: file.into(), goal, limits, spreads, cases, seed, document };
        let tuned = search.tune_while(controller, &|| {}, &|| interrupt.goes_on())?;
        let tuned: Vec<_> = tuned.into_iter().collect();
        let text = if is_refused(&tuned) {
            None
        } else {
            Some(rewritten(&Document::text(file)?, &tuned)?)
        };
        Ok((tuning::object(file, &tuned).to_string(), text))
    })
}
