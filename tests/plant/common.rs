//! Running built-in experiments from tests.

use simulator::run::{RunResult, RunTrace, run_all};

/// The results of an experiment with keys set as on the command line, under one controller.
pub fn run(experiment: &str, controller: &str, set: &[&str]) -> Vec<RunResult> {
    run_all(&experiments::experiment(experiment, &[controller], set).runs).unwrap()
}

/// The result with a label.
pub fn labelled<'a>(results: &'a [RunResult], label: &str) -> &'a RunResult {
    results
        .iter()
        .find(|result| result.plan.label == label)
        .unwrap_or_else(|| panic!("no run is called {label}"))
}

/// The samples of a closed loop.
pub fn moments(result: &RunResult) -> &[simulator::closed_loop::LoopSample] {
    match &result.trace {
        RunTrace::Loop(moments) => moments,
        RunTrace::Ramp(_) => panic!("{} is a ramp", result.plan.label),
    }
}
