//! Text tables within 80 columns.

use super::grid::{new, number};
use super::sides::{self, ShownSides};
use crate::experiment::Task;
use crate::run::{RunResult, ServoTrip};

/// Returns the results of an experiment: a table for each kind of motion and each variant, and a
/// line for each failed run. If the encoder cannot see slack, rest and settling are in a table of
/// both sides of the gear.
pub fn render(results: &[RunResult]) -> String {
    type Kind = (fn(&Task) -> bool, &'static [&'static str], fn(&RunResult) -> Vec<String>);
    let kinds: [Kind; 4] = [
        (|task| matches!(task, Task::Step(_)), STEP_COLUMNS, step_cells),
        (|task| matches!(task, Task::Trajectory(_)), TRAJECTORY_COLUMNS, trajectory_cells),
        (|task| matches!(task, Task::Sine(_)), SINE_COLUMNS, sine_cells),
        (|task| matches!(task, Task::Ramp(_)), RAMP_COLUMNS, ramp_cells),
    ];
    let slack = results.iter().find_map(|result| result.unseen_slack.as_ref());
    let goal = results.first().map(|result| result.plan.machine.goal).unwrap_or_default();
    let shown = ShownSides::of(slack, &goal);
    let is_kept = |column: &str| !shown.replaces().contains(&column);
    let mut parts = Vec::new();
    for (is_kind, columns, cells) in kinds {
        let of_kind: Vec<&RunResult> = results.iter().filter(|r| is_kind(&r.plan.task)).collect();
        if of_kind.is_empty() {
            continue;
        }
        let kept: Vec<&str> = columns.iter().copied().filter(|one| is_kept(one)).collect();
        let mut table = new(&kept);
        for group in of_kind.chunk_by(|a, b| a.plan.slugs() == b.plan.slugs()) {
            let slugs =
                group.first().map(|result| result.plan.slugs().join(", ")).unwrap_or_default();
            if !slugs.is_empty() {
                table.add_row([format!("{slugs}:")]);
            }
            for result in group {
                let of_all = [vec![row_name(result)], cells(result)].concat();
                let named = of_all.into_iter().zip(columns);
                table.add_row(named.filter_map(|(cell, one)| is_kept(one).then_some(cell)));
            }
        }
        parts.push(table.trim_fmt() + "\n");
    }
    let is_judged =
        |result: &&RunResult| !matches!(result.plan.task, Task::Ramp(_) | Task::Sine(_));
    if shown != ShownSides::Nothing && results.iter().any(|result| is_judged(&result)) {
        let judged = results.iter().filter(is_judged);
        let rows = judged.map(|one| (one.plan.label.clone(), &one.metrics.sides));
        parts.push(shown.table("run", rows));
        parts.push(sides::legend(slack, &goal));
    }
    let remarks: Vec<String> = results.iter().filter_map(remark).collect();
    if !remarks.is_empty() {
        parts.push(remarks.join("\n") + "\n");
    }
    parts.join("\n")
}

/// Returns the name of a run in its row: controller and motion, such as `pd/step-5.0`. Its variant
/// and its delay are in a line above.
fn row_name(result: &RunResult) -> String {
    let driven_by = result.plan.controller.as_deref().unwrap_or("ramp");
    format!("{driven_by}/{}", result.plan.task.slug())
}

const STEP_COLUMNS: &[&str] = &[
    "step",
    sides::REST,
    "over-\nshoot\ndeg",
    "rise\ns",
    sides::SETTLED,
    "rms\ndeg",
    "chatter\nV/s",
    "hunts\ndeg",
];

fn step_cells(result: &RunResult) -> Vec<String> {
    let m = &result.metrics;
    vec![
        number(m.rest_error_counts, 1),
        number(m.overshoot_deg, 3),
        number(m.rise_time_s, 2),
        number(m.settling_time_s, 2),
        number(m.rms_error_deg, 3),
        number(m.control_total_variation_v_per_s, 2),
        number(m.hunting_peak_to_peak_deg, 4),
    ]
}

const TRAJECTORY_COLUMNS: &[&str] =
    &["trajectory", "rest\ncounts", "cruise\ndeg", "rms\ndeg", "max\ndeg", "chatter\nV/s"];

fn trajectory_cells(result: &RunResult) -> Vec<String> {
    let m = &result.metrics;
    vec![
        number(m.rest_error_counts, 1),
        number(m.cruise_error_deg, 4),
        number(m.rms_error_deg, 4),
        number(m.max_error_deg, 4),
        number(m.control_total_variation_v_per_s, 2),
    ]
}

const SINE_COLUMNS: &[&str] = &["sine", "rms\ndeg", "max\ndeg", "reversal\ndeg", "chatter\nV/s"];

fn sine_cells(result: &RunResult) -> Vec<String> {
    let m = &result.metrics;
    vec![
        number(m.rms_error_deg, 4),
        number(m.max_error_deg, 4),
        number(m.reversal_error_deg, 4),
        number(m.control_total_variation_v_per_s, 2),
    ]
}

const RAMP_COLUMNS: &[&str] = &["ramp (V/s)", "stick\nV", "slip\nV", "slip, lag corrected\nV"];

fn ramp_cells(result: &RunResult) -> Vec<String> {
    let m = &result.metrics;
    vec![number(m.stick_v, 4), number(m.slip_v, 4), number(m.slip_corrected_v, 4)]
}

fn remark(result: &RunResult) -> Option<String> {
    let label = &result.plan.label;
    if let Some(ServoTrip { code, name, time_s, .. }) = result.fault {
        return Some(format!("{label}: fault {code} ({name}) at {time_s} s turned the output off"));
    }
    match result.diverged_at_s {
        Some(time_s) => Some(format!(
            "{label}: the simulation diverged (a state is not finite) at {time_s} s; the run ends \
            there"
        )),
        None if result.unstable => Some(format!("{label}: unstable")),
        None => None,
    }
}
