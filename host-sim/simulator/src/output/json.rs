//! The JSON of `stiction run`: one object, keys as documented in docs/command-line.md.

use std::borrow::Cow;

use serde::Serialize;
use serde_json::{Value, json};

use crate::data_sheet::UnseenSlack;
use crate::experiment::{Experiment, RunPlan, Task};
use crate::goal::GoalInBothUnits;
use crate::run::{RunResult, ServoTrip};
use crate::solver::EventKind;

/// Raised when a key changes its meaning or goes away.
const SCHEMA: u32 = 1;

/// The whole object.
#[derive(Serialize)]
struct Report<'a, M> {
    schema: u32,
    experiment: &'a str,
    source: &'a str,
    /// Left out for what has no gear; null if the encoder sees all of the gear.
    #[serde(skip_serializing_if = "Option::is_none")]
    unseen_slack: Option<Option<UnseenSlack>>,
    runs: Vec<RunRecord<'a, M>>,
}

/// A run, of whatever is judged by the metrics `M`.
#[derive(Serialize)]
pub struct RunRecord<'a, M> {
    /// What it is called.
    pub label: &'a str,
    /// What it was made with.
    pub parameters: Cow<'a, Value>,
    /// In the order of time.
    pub events: Vec<EventRecord>,
    /// The goal by which its success is judged; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalInBothUnits>,
    /// What it is judged by.
    pub metrics: &'a M,
    /// What it took.
    pub cost: RunCost,
    /// Whether the loop is unstable.
    pub unstable: bool,
    /// When the motion grew beyond every bound, s.
    pub diverged_at_s: Option<f64>,
    /// Only there if a servo has tripped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<ServoTrip>,
}

/// A change between sticking and slipping; bodies are counted from 1.
#[derive(Serialize)]
pub struct EventRecord {
    /// When, s.
    pub time_s: f64,
    /// Of which body.
    pub body: usize,
    /// Which way.
    pub kind: EventKind,
}

/// What a run took.
#[derive(Serialize)]
pub struct RunCost {
    /// Time on the wall, s.
    pub wall_s: f64,
    /// How often a derivative was evaluated.
    pub derivative_evaluations: u64,
}

/// Runs of an experiment and where it comes from, as one object, indented.
pub fn object<M: Serialize>(
    experiment: &str,
    source: &str,
    runs: Vec<RunRecord<M>>,
) -> serde_json::Result<String> {
    let unseen_slack = None;
    serde_json::to_string_pretty(&Report { schema: SCHEMA, experiment, source, unseen_slack, runs })
}

/// Writes the whole object, indented.
///
/// # Errors
/// If a number cannot be written as JSON.
pub fn render(experiment: &Experiment, results: &[RunResult]) -> serde_json::Result<String> {
    let runs = results.iter().map(|result| RunRecord {
        label: &result.plan.label,
        parameters: Cow::Owned(parameters(&result.plan)),
        events: result
            .events
            .iter()
            .map(|event| EventRecord { time_s: event.time_s, body: 1, kind: event.kind })
            .collect(),
        goal: Some(goal(&result.plan)),
        metrics: &result.metrics,
        cost: RunCost {
            wall_s: result.wall.as_secs_f64(),
            derivative_evaluations: result.derivative_evaluations,
        },
        unstable: result.unstable,
        diverged_at_s: result.diverged_at_s,
        fault: result.fault,
    });
    serde_json::to_string_pretty(&Report {
        schema: SCHEMA,
        experiment: &experiment.name,
        source: &experiment.source,
        unseen_slack: Some(experiment.unseen_slack),
        runs: runs.collect(),
    })
}

/// Returns the goal of a run.
fn goal(plan: &RunPlan) -> GoalInBothUnits {
    plan.machine.goal.in_both_units(plan.machine.encoder.resolution_deg())
}

/// The tables of the machine's file as this run used them, with its own controller only.
fn parameters(plan: &RunPlan) -> Value {
    let machine = &plan.machine;
    let controller = plan.controller.as_ref().and_then(|name| machine.controller.get(name));
    let mut run = machine.run.clone();
    run.duration_s.get_or_insert(plan.duration_s());
    let reference = match &plan.task {
        Task::Step(step_deg) => json!({ "step_deg": step_deg }),
        Task::Trajectory(trajectory) => json!(trajectory),
        Task::Ramp(rate) => {
            let hold_s = machine.identification.as_ref().map(|ramps| ramps.hold_s);
            json!({ "ramp_rate_v_per_s": rate, "hold_s": hold_s })
        }
    };
    json!({
        "joint": machine.joint,
        "encoder": machine.encoder,
        "drive": machine.drive,
        "loop": {
            "sample_time_s": machine.sampling.sample_time_s(),
            "velocity_window": machine.sampling.velocity_window(),
            "controller": plan.controller,
        },
        "controller": controller,
        "reference": reference,
        "run": run,
    })
}
