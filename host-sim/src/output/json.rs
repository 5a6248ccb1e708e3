//! The JSON of `stiction run`: one object, keys as documented in the README.

use serde::Serialize;
use serde_json::{Value, json};

use crate::experiment::{Experiment, Motion, RunPlan};
use crate::metrics::Metrics;
use crate::run::RunResult;
use crate::solver::EventKind;

/// Raised when a key changes its meaning or goes away.
const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    experiment: &'a str,
    source: &'a str,
    runs: Vec<Run<'a>>,
}

#[derive(Serialize)]
struct Run<'a> {
    label: &'a str,
    parameters: Value,
    events: Vec<Event>,
    metrics: &'a Metrics,
    cost: Cost,
    unstable: bool,
    diverged_at_s: Option<f64>,
}

#[derive(Serialize)]
struct Event {
    time_s: f64,
    body: u32,
    kind: EventKind,
}

#[derive(Serialize)]
struct Cost {
    wall_s: f64,
    derivative_evaluations: u64,
}

/// The whole object, indented.
///
/// # Errors
/// If a number cannot be written as JSON.
pub fn render(experiment: &Experiment, results: &[RunResult]) -> serde_json::Result<String> {
    let runs = results.iter().map(|result| Run {
        label: &result.plan.label,
        parameters: parameters(&result.plan),
        events: result
            .events
            .iter()
            .map(|event| Event { time_s: event.time_s, body: 1, kind: event.kind })
            .collect(),
        metrics: &result.metrics,
        cost: Cost {
            wall_s: result.wall.as_secs_f64(),
            derivative_evaluations: result.derivative_evaluations,
        },
        unstable: result.unstable,
        diverged_at_s: result.diverged_at_s,
    });
    let report = Report {
        schema: SCHEMA,
        experiment: &experiment.name,
        source: &experiment.source,
        runs: runs.collect(),
    };
    serde_json::to_string_pretty(&report)
}

/// The tables of the machine's file as this run used them, with its own controller only.
fn parameters(plan: &RunPlan) -> Value {
    let machine = &plan.machine;
    let controller = plan.controller.as_ref().and_then(|name| machine.controller.get(name));
    let mut run = machine.run.clone();
    run.duration_s.get_or_insert(plan.duration_s());
    let reference = match &plan.motion {
        Motion::Step(step_deg) => json!({ "step_deg": step_deg }),
        Motion::Trajectory(trajectory) => json!(trajectory),
        Motion::Ramp(rate) => {
            json!({ "ramp_rate_v_per_s": rate, "hold_s": machine.identification.as_ref().map(|ramps| ramps.hold_s) })
        }
    };
    json!({
        "joint": machine.joint,
        "encoder": machine.encoder,
        "drive": machine.drive,
        "loop": {
            "sample_time_s": machine.sampling.sample_time_s,
            "velocity_window": machine.sampling.velocity_window,
            "controller": plan.controller,
        },
        "controller": controller,
        "reference": reference,
        "run": run,
    })
}
