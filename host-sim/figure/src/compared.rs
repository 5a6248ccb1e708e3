//! Figure of two or three controllers on the same joints: a panel for each joint, with the errors
//! of all controllers.

use super::of_runs::{COMPARED, NamedFigure, in_words, shown_until, sides_differ};
use super::{Figure, Panel, PlotCurve, Style};
use files::error::shown;
use files::goal::TOLERANCE_COUNTS;
use simulator::closed_loop::LoopSample;
use simulator::experiment::Task;
use simulator::run::{RunResult, RunTrace};

/// Largest number of panels in a figure; more would be taller than a screen.
const PANELS: usize = 4;

/// Time after which the error of a joint determines the range of its panel, s.
const TRANSIENT_S: f64 = 1.0;

/// Returns the time from which a curve determines the range of its panel, s: after the transient,
/// but no later than the middle of the time axis. Otherwise a short run could be completely outside
/// its panel.
pub fn judged_from_s(end_s: f64) -> f64 {
    TRANSIENT_S.min(0.5 * end_s)
}

/// Runs of one joint and step, one per controller.
type Joint<'a> = Vec<&'a RunResult>;

/// Returns a figure for each step of an experiment with two or three controllers; none for other
/// experiments.
pub fn compared(prefix: &str, results: &[RunResult]) -> Vec<NamedFigure> {
    let steps = results
        .iter()
        .filter(|run| run.diverged_at_s.is_none() && matches!(run.plan.task, Task::Step(_)));
    let mut joints: Vec<Joint> = Vec::new();
    for run in steps {
        let same = |other: &&RunResult| {
            other.plan.task == run.plan.task && other.plan.slugs() == run.plan.slugs()
        };
        match joints.iter_mut().find(|joint| joint.first().is_some_and(same)) {
            Some(joint) => joint.push(run),
            None => joints.push(vec![run]),
        }
    }
    joints.retain(|joint| (2..=COMPARED.len()).contains(&joint.len()));
    let figure = |(i, some): (usize, &[Joint])| {
        let part = if i == 0 { String::new() } else { format!("-{}", i + 1) };
        NamedFigure { stem: format!("{prefix}-compared{part}"), figure: page(some) }
    };
    joints.chunks(PANELS).enumerate().map(figure).collect()
}

fn page(joints: &[Joint]) -> Figure {
    let end_s = joints.iter().map(|joint| shown_until(joint)).fold(0.0, f64::max);
    Figure {
        title: "How far the joint is from its target".into(),
        subtitle: "simulated; the start of each step is cut off".into(),
        x_label: "time (s)".into(),
        panels: joints.iter().map(|joint| panel(joint, end_s)).collect(),
    }
}

fn panel(joint: &Joint, end_s: f64) -> Panel {
    // The file's goal.
    let (band, band_name) = joint.first().map_or((TOLERANCE_COUNTS, String::new()), |run| {
        let machine = &run.plan.machine;
        let counts = machine.goal.tolerance_counts(machine.count_deg());
        let in_counts = || format!("{} counts", shown(counts));
        (
            counts,
            machine.goal.tolerance_deg.map_or_else(in_counts, |deg| format!("{} deg", shown(deg))),
        )
    });
    let mut half = (4.0 * TOLERANCE_COUNTS).max(1.5 * band);
    let mut lines = Vec::new();
    for (run, style) in joint.iter().zip(styles(joint.len())) {
        let RunTrace::Loop(moments) = &run.trace else { continue };
        let count_deg = run.plan.machine.count_deg();
        let counts = |of: fn(&LoopSample) -> f64| -> Vec<(f64, f64)> {
            let shown = moments.iter().take_while(|moment| moment.time_s <= end_s + 1e-9);
            shown.map(|moment| (moment.time_s, of(moment) / count_deg)).collect()
        };
        let is_two_sided = sides_differ(run);
        let points = counts(LoopSample::error_deg);
        let settled = points.iter().filter(|(time_s, _)| *time_s >= judged_from_s(end_s));
        half = settled.map(|(_, error)| 1.25 * error.abs()).fold(half, f64::max);
        let rest = run.metrics.rest_error_counts.unwrap_or(f64::NAN);
        let name = run.plan.controller.as_deref().unwrap_or_default();
        let side = if is_two_sided { " at the load" } else { "" };
        lines.push(PlotCurve::new(
            format!("{name}: {:.1} counts off{side}", rest.abs()),
            style,
            points,
        ));
        if is_two_sided {
            let rest = run.metrics.sides.rest_at_encoder_counts.unwrap_or(f64::NAN);
            let name = format!("{name}: {:.1} at the encoder", rest.abs());
            let points = counts(|moment| moment.reference_deg - moment.at_encoder_deg);
            lines.push(PlotCurve::new(name, style.at_encoder(), points));
        }
    }
    for (name, bound) in [(band_name, band), (String::new(), -band)] {
        lines.push(PlotCurve::new(name, Style::Limit, vec![(0.0, bound), (end_s, bound)]));
    }
    let label = format!("{}: error (counts)", name_of(joint));
    Panel { height: 0.9, y_range: Some((-half, half)), ..Panel::new(label, lines) }
}

/// Returns the styles of the controllers. The last one, with which the others are compared, has the
/// primary style.
fn styles(controllers: usize) -> impl Iterator<Item = Style> {
    let [primary, others @ ..] = COMPARED;
    others.into_iter().take(controllers - 1).chain([primary])
}

/// Returns the name of a joint: its variants, such as `light`, or its step if it has none.
fn name_of(joint: &Joint) -> String {
    let Some(run) = joint.first() else { return String::new() };
    let slugs: Vec<String> = run.plan.slugs().into_iter().map(in_words).collect();
    if slugs.is_empty() {
        format!("{} deg", run.plan.task.slug().trim_start_matches("step-"))
    } else {
        slugs.join(", ")
    }
}
