//! Running built-in experiments from tests.

use host_sim::experiment::{Document, Experiment};
use host_sim::run::{RunResult, Trace, run_all};
use stiction::compensator::Gains;

/// Every controller by its name: plain PD, and each law by itself.
pub fn controllers() -> impl Iterator<Item = &'static str> {
    std::iter::once("pd").chain(Gains::NAMES.iter().copied())
}

/// The results of an experiment with keys set as on the command line, under one controller.
pub fn run(experiment: &str, controller: &str, set: &[&str]) -> Vec<RunResult> {
    let mut document = Document::open(experiment).unwrap();
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    document.set(&set).unwrap();
    let fixed: Vec<String> = set.iter().map(|s| s.split('=').next().unwrap().to_owned()).collect();
    let plan = Experiment::plan(&document, &[controller.to_owned()], &fixed).unwrap();
    run_all(&plan.runs).unwrap()
}

/// The result with a label.
pub fn labelled<'a>(results: &'a [RunResult], label: &str) -> &'a RunResult {
    results
        .iter()
        .find(|result| result.plan.label == label)
        .unwrap_or_else(|| panic!("no run is called {label}"))
}

/// The samples of a closed loop.
pub fn moments(result: &RunResult) -> &[host_sim::closed_loop::Moment] {
    match &result.trace {
        Trace::Loop(moments) => moments,
        Trace::Ramp(_) => panic!("{} is a ramp", result.plan.label),
    }
}
