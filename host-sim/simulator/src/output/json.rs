//! JSON of `stiction run`: one object. docs/reference/command-line.md documents its keys.

use std::borrow::Cow;

use serde::Serialize;
use serde_json::{Value, json};

use crate::experiment::{Experiment, RunPlan, Task};
use crate::run::{RunResult, ServoTrip};
use crate::supply::SupplyCourse;
use dynamics::solver::EventKind;
use files::data_sheet::UnseenSlack;
use files::goal::GoalInBothUnits;

/// Version of the object; raised when a key changes its meaning or is removed.
const SCHEMA: u32 = 1;

/// Whole object of an experiment.
#[derive(Serialize)]
struct Report<'a, M> {
    schema: u32,
    experiment: &'a str,
    source: &'a str,
    /// Left out without a gear; null if the encoder measures the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    unseen_slack: Option<Option<UnseenSlack>>,
    runs: Vec<RunRecord<'a, M>>,
}

/// A run with the metrics `M`.
#[derive(Serialize)]
pub struct RunRecord<'a, M> {
    /// Label.
    pub label: &'a str,
    /// Parameters of the run.
    pub parameters: Cow<'a, Value>,
    /// Supply of the bridge; left out if it is the nominal one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply: Option<SupplyCourse>,
    /// Events, in the order of time.
    pub events: Vec<EventRecord>,
    /// Goal by which success is judged; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<GoalInBothUnits>,
    /// Metrics.
    pub metrics: &'a M,
    /// Computing time.
    pub cost: RunCost,
    /// Whether the loop is unstable.
    pub unstable: bool,
    /// Time at which a state was no longer finite, s.
    pub diverged_at_s: Option<f64>,
    /// Fault of a servo; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<ServoTrip>,
}

/// Change of a body's motion: it breaks away, sticks, or reverses without rest.
#[derive(Serialize)]
pub struct EventRecord {
    /// Time, s.
    pub time_s: f64,
    /// Number of the body, from 1.
    pub body: usize,
    /// Kind of the change.
    pub kind: EventKind,
}

/// Computing time of a run.
#[derive(Serialize)]
pub struct RunCost {
    /// Wall-clock time, s.
    pub wall_s: f64,
    /// Number of evaluations of the derivative.
    pub derivative_evaluations: u64,
}

/// Returns the runs and the source of an experiment as one indented object.
pub fn object<M: Serialize>(
    experiment: &str,
    source: &str,
    runs: Vec<RunRecord<M>>,
) -> serde_json::Result<String> {
    let unseen_slack = None;
    serde_json::to_string_pretty(&Report { schema: SCHEMA, experiment, source, unseen_slack, runs })
}

/// Returns the whole object, indented.
///
/// # Errors
/// Returns an error if a number cannot be written as JSON.
pub fn render(experiment: &Experiment, results: &[RunResult]) -> serde_json::Result<String> {
    let runs = results.iter().map(|result| RunRecord {
        label: &result.plan.label,
        parameters: Cow::Owned(parameters(&result.plan)),
        supply: result.plan.supply,
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
    plan.machine.goal.in_both_units(plan.machine.count_deg())
}

/// Returns the tables of the machine's file for this run, with its own controller only.
fn parameters(plan: &RunPlan) -> Value {
    let machine = &plan.machine;
    let controller = plan.controller.as_ref().and_then(|name| machine.controller.get(name));
    let mut run = machine.run.clone();
    run.duration_s.get_or_insert(plan.duration_s());
    let reference = match &plan.task {
        Task::Step(step_deg) => json!({ "step_deg": step_deg }),
        Task::Trajectory(trajectory) => json!(trajectory),
        Task::Sine(sine) => json!(sine),
        Task::Ramp(rate) => {
            let hold_s = machine.identification.as_ref().map(|ramps| ramps.hold_s);
            json!({ "ramp_rate_v_per_s": rate, "hold_s": hold_s })
        }
    };
    json!({
        "joint": machine.joint,
        "encoder": machine.encoder,
        "load_encoder": machine.load_encoder,
        "drive": machine.drive,
        "loop": {
            "position": machine.sampling.extras.position,
            "sample_time_s": machine.sampling.sample_time_s(),
            "velocity_window": machine.sampling.velocity_window(),
            "controller": plan.controller,
        },
        "controller": controller,
        "reference": reference,
        "run": run,
    })
}
