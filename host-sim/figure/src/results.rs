//! Figures of a set of runs.
//!
//! One figure for each result of the thesis's Figs. 26-59 and 63-67: displacements, errors and the
//! breakdown of the control signal under each other. If the thesis shows a result both measured
//! and simulated, there is one figure, simulated.

use std::path::Path;

use super::compared::compared;
use super::of_runs::{COMPARED, NamedFigure, in_words, last_time, shown_until, sides_differ};
use super::{Figure, InsetRange, Panel, PlotCurve, Style};
use files::machine::ThesisFigures;
use simulator::closed_loop::LoopSample;
use simulator::experiment::Task;
use simulator::run::{RunResult, RunTrace};

/// The transient of a step ends when its error stays within this share of the step. An inset is
/// scaled to the motion from 1.5 times that time on.
const TRANSIENT: f64 = 0.1;

/// Time from which an inset is scaled if the error never stays within [`TRANSIENT`], s.
const TRANSIENT_S: f64 = 1.0;

/// Smallest magnification of an inset; below it, there is no inset.
const LEAST_ZOOM: f64 = 2.5;

/// Returns the figures of an experiment's results. `sources` are the figures of the thesis to
/// compare them with. A run that diverged has no figure, since its last values fit no axis.
pub fn figures(
    experiment: &str,
    results: &[RunResult],
    sources: &[ThesisFigures],
) -> Vec<NamedFigure> {
    let mut figures = Vec::new();
    // So that the figures of several experiments can lie in one directory.
    let prefix = Path::new(experiment).file_stem().unwrap_or_default().to_string_lossy();
    for mut group in groups(results, sources) {
        let (ramps, loops): (Vec<_>, Vec<_>) =
            group.results.iter().partition(|result| matches!(result.plan.task, Task::Ramp(_)));
        figures.extend(ramps.into_iter().filter_map(|result| ramp_figure(result, &prefix)));
        let (steps, loops): (Vec<_>, Vec<_>) =
            loops.into_iter().partition(|result| matches!(result.plan.task, Task::Step(_)));
        let (sines, trajectories): (Vec<_>, Vec<_>) =
            loops.into_iter().partition(|result| matches!(result.plan.task, Task::Sine(_)));
        for (kind, results) in [("steps", steps), ("trajectories", trajectories), ("sines", sines)]
        {
            if kind == "sines" {
                // The thesis has no sines to compare with.
                group.thesis = None;
            }
            for (i, some) in results.chunks(COMPARED.len()).enumerate() {
                let part = if i == 0 { String::new() } else { format!("-{}", i + 1) };
                let stem = format!("{prefix}-{}-{kind}{part}", group.name.replace('/', "-"));
                figures.extend(loop_figures(some, &group, kind, &stem));
            }
        }
    }
    figures.extend(compared(&prefix, results));
    figures
}

/// Sets a title of the user; the own title of each figure becomes part of its subtitle.
pub fn set_title(figures: &mut [NamedFigure], title: &str) {
    for NamedFigure { figure, .. } in figures {
        figure.subtitle = format!("{}; {}", figure.title, figure.subtitle);
        figure.title = title.into();
    }
}

/// Runs that are in one figure.
struct Group<'a> {
    /// Name of the group, such as `srnf` or `srnf/test-1`.
    name: String,
    thesis: Option<&'a ThesisFigures>,
    results: Vec<&'a RunResult>,
}

fn groups<'a>(results: &'a [RunResult], sources: &'a [ThesisFigures]) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for result in results.iter().filter(|result| result.diverged_at_s.is_none()) {
        let driven_by = result.plan.controller.as_deref().unwrap_or("ramp");
        let own = [&[driven_by], &result.plan.slugs()[..]].concat().join("/");
        let all = format!("{driven_by}/*");
        let thesis = sources.iter().find(|source| source.of == own || source.of == all);
        let name =
            if thesis.is_some_and(|source| source.of == all) { driven_by.into() } else { own };
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.results.push(result),
            None => groups.push(Group { name, thesis, results: vec![result] }),
        }
    }
    groups
}

/// Returns a figure with the motions of a group and one control signal: the first that the thesis
/// shows, or that of the first motion if it shows none. Each further control signal that the thesis
/// shows has its own figure, since one page would be taller than a screen.
fn loop_figures(results: &[&RunResult], group: &Group, kind: &str, stem: &str) -> Vec<NamedFigure> {
    let wanted = group.thesis.map(|source| source.breakdown.as_slice()).unwrap_or_default();
    let shown = results.iter().enumerate().filter(|(i, result)| {
        wanted.contains(&result.plan.task.slug()) || (wanted.is_empty() && *i == 0)
    });
    let end_s = shown_until(results);
    let mut panels = vec![displacements(results, end_s), errors(results, end_s)];
    panels.extend(twists(results, end_s));
    let mut others = Vec::new();
    for (n, (_, result)) in shown.enumerate() {
        let curve = curve_name(result, results);
        let signal = breakdown(result, &curve, end_s);
        if n == 0 { panels.extend(signal) } else { others.push((result, curve, signal)) }
    }
    panels.retain(|panel| !panel.is_zero());
    for (.., panels) in &mut others {
        panels.retain(|panel| !panel.is_zero());
    }
    others.retain(|(.., panels)| !panels.is_empty());
    let subtitle = subtitle(results, group, end_s);
    let title = title(&group.name, kind);
    let x_label = "time (s)".to_owned();
    let first = NamedFigure {
        stem: stem.into(),
        figure: Figure {
            title: title.clone(),
            subtitle: subtitle.clone(),
            x_label: x_label.clone(),
            panels,
        },
    };
    let others = others.into_iter().map(|(result, curve, panels)| NamedFigure {
        stem: format!("{stem}-signal-{}", result.plan.task.slug()),
        figure: Figure {
            title: format!("{title}, control signal of the run {curve}"),
            subtitle: subtitle.clone(),
            x_label: x_label.clone(),
            panels,
        },
    });
    std::iter::once(first).chain(others).collect()
}

/// Returns the subtitle: the kind of the figure, and the part of the runs that it shows.
fn subtitle(results: &[&RunResult], group: &Group, end_s: f64) -> String {
    let what = match group.thesis {
        Some(source) => format!("simulated; to compare with {} of the thesis", source.thesis),
        None => "simulated".into(),
    };
    let longest = results.iter().filter_map(|result| last_time(result)).fold(0.0, f64::max);
    if end_s < longest {
        format!("{what}; to {} of {} s, when the motion is over", brief(end_s), brief(longest))
    } else {
        what
    }
}

/// Rounds a time to milliseconds, s.
fn brief(seconds: f64) -> f64 {
    (1e3 * seconds).round() / 1e3
}

/// Returns the title of a group such as `srnf/test-1` and a kind such as `steps`. A user's own
/// controller keeps its name.
fn title(group: &str, kind: &str) -> String {
    let (controller, variant) = group.split_once('/').unwrap_or((group, ""));
    let controller = match controller {
        "pd" => "PD",
        "ri" => "PD with reset integral (RI)",
        "rvi" => "PD with rate variable integral (RVI)",
        "roi" => "PD with reset offset integral (ROI)",
        "feedforward" => "PD with slip friction feedforward",
        "dnpf" => "PD with discontinuous nonlinear proportional feedback (DNPF)",
        "srnf" => "PD with smooth robust nonlinear feedback (SRNF)",
        other => other,
    };
    let variants = variant.split('/').filter(|slug| !slug.is_empty()).map(in_words);
    let all: Vec<String> = std::iter::once(controller.to_owned()).chain(variants).collect();
    format!("{}: {kind}", all.join(", "))
}

fn displacements(results: &[&RunResult], end_s: f64) -> Panel {
    let mut lines = Vec::new();
    for (result, style) in results.iter().zip(COMPARED) {
        let name = curve_name(result, results);
        lines.extend(sides(result, &name, style, end_s, |_, position_deg| position_deg));
    }
    for (i, result) in results.iter().enumerate() {
        let name = if i == 0 { "reference" } else { "" };
        lines.push(PlotCurve::new(
            name,
            Style::Reference,
            points(result, end_s, |m| m.reference_deg),
        ));
    }
    Panel { height: 0.75, ..Panel::new("displacement (deg)", lines) }
}

fn errors(results: &[&RunResult], end_s: f64) -> Panel {
    let curves = results.iter().zip(COMPARED).flat_map(|(result, style)| {
        let name = curve_name(result, results);
        sides(result, &name, style, end_s, |m, position_deg| m.reference_deg - position_deg)
    });
    let inset =
        around(results.iter().filter_map(|one| rest(one, end_s, LoopSample::error_deg, 0.02)));
    Panel { height: 0.85, inset, ..Panel::new("error (deg)", curves.collect()) }
}

/// Returns the panel of the twist of the gear, the position at the motor's encoder less that of the
/// load, for runs with an encoder on either side.
fn twists(results: &[&RunResult], end_s: f64) -> Option<Panel> {
    let curves = results.iter().zip(COMPARED).filter_map(|(result, style)| {
        let motor = result.plan.motor_encoder().ok()??;
        let twist_deg = |m: &LoopSample| {
            let motor_deg = f64::from(m.motor_counts.unwrap_or_default()) * motor.resolution;
            motor_deg - m.at_load_deg
        };
        Some(PlotCurve::new(curve_name(result, results), style, points(result, end_s, twist_deg)))
    });
    let curves: Vec<PlotCurve> = curves.collect();
    (!curves.is_empty())
        .then(|| Panel { height: 0.62, ..Panel::new("motor less load (deg)", curves) })
}

/// Returns the curves of a run: one, or one for each side of its gear if the sides differ. `of`
/// computes a value from a sample and the position of a side (deg).
fn sides(
    result: &RunResult,
    name: &str,
    style: Style,
    end_s: f64,
    of: impl Fn(&LoopSample, f64) -> f64,
) -> Vec<PlotCurve> {
    let joint = points(result, end_s, |m| of(m, m.position_deg));
    if !sides_differ(result) {
        return vec![PlotCurve::new(name, style, joint)];
    }
    let load = points(result, end_s, |m| of(m, m.at_load_deg));
    let encoder = points(result, end_s, |m| of(m, m.at_encoder_deg));
    vec![
        PlotCurve::new(format!("{name}, at the load"), style, load),
        PlotCurve::new(format!("{name}, at the encoder"), style.at_encoder(), encoder),
    ]
}

/// Returns v_PD, v_c and v of one run and its measured current, each in its own panel: in one
/// panel, chattering signals would hide each other.
fn breakdown(result: &RunResult, curve: &str, end_s: f64) -> Vec<Panel> {
    type Signal = (&'static str, &'static str, Style, fn(&LoopSample) -> f64);
    let all: [Signal; 3] = [
        ("v_PD", "v_PD (V)", Style::Primary, |m| f64::from(m.tick.v_pd)),
        ("v_c", "v_c (V)", Style::Compensation, |m| f64::from(m.tick.v_c)),
        ("v", "v (V)", Style::Total, |m| f64::from(m.tick.v)),
    ];
    let plain = is_plain(result);
    let shown = all.into_iter().filter(|(name, ..)| !plain || *name == "v_PD");
    let panel = |name: &str, label: &str, style, of: fn(&LoopSample) -> f64| {
        let line = PlotCurve::new(format!("{name}, {curve}"), style, points(result, end_s, of));
        let inset = around(rest(result, end_s, of, 0.5).into_iter());
        Panel { height: 0.62, inset, ..Panel::new(label, vec![line.held()]) }
    };
    // Without a sensor it is zero, and the panel is left out as every panel of zeros is.
    let current = panel("i", "motor current (A)", Style::Total, |m| m.tick.current.into());
    shown
        .map(|(name, label, style, of)| {
            panel(if plain { "v = v_PD" } else { name }, label, style, of)
        })
        .chain([current])
        .collect()
}

fn ramp_figure(result: &RunResult, prefix: &str) -> Option<NamedFigure> {
    let RunTrace::Ramp(moments) = &result.trace else { return None };
    let series =
        |of: fn(&LoopSample) -> f64| moments.iter().map(|m| (m.time_s, of(m))).collect::<Vec<_>>();
    let rate = result.plan.task.slug();
    let mut effort = vec![PlotCurve::new("v", Style::Total, series(|m| m.tick.v.into())).held()];
    let (begin_s, end_s) = (moments.first()?.time_s, moments.last()?.time_s);
    let levels = [
        ("stick", result.metrics.stick_v, Style::Second),
        ("slip, corrected", result.metrics.slip_corrected_v, Style::Third),
        ("slip, as read", result.metrics.slip_v, Style::Limit),
    ];
    for (name, level, style) in levels {
        if let Some(level) = level {
            let ends = vec![(begin_s, level), (end_s, level)];
            effort.push(PlotCurve::new(format!("{name}: {level:.4} V"), style, ends));
        }
    }
    let panels = vec![
        Panel::new("effort (V)", effort),
        Panel::new(
            "displacement (deg)",
            vec![PlotCurve::new("joint", Style::Primary, series(|m| m.position_deg))],
        ),
        Panel::new(
            "velocity (deg/s)",
            vec![PlotCurve::new("joint", Style::Primary, series(|m| m.velocity_deg_per_s))],
        ),
    ];
    let title =
        format!("Friction from a ramp of the effort: {} V/s", rate.trim_start_matches("rate-"));
    let figure = Figure { title, subtitle: "simulated".into(), x_label: "time (s)".into(), panels };
    Some(NamedFigure { stem: format!("{prefix}-{rate}"), figure })
}

fn points(result: &RunResult, end_s: f64, of: impl Fn(&LoopSample) -> f64) -> Vec<(f64, f64)> {
    match &result.trace {
        RunTrace::Loop(moments) => {
            // With a tolerance: the end is a decimal, and the times are products.
            let shown = moments.iter().take_while(|m| m.time_s <= end_s + 1e-9);
            shown.map(|m| (m.time_s, of(m))).collect()
        }
        RunTrace::Ramp(_) => Vec::new(),
    }
}

/// Returns the window of a signal after the transient of a step, in a symmetric range of at least
/// `least` to either side; `None` if a panel of the whole signal shows it as well. Other motions
/// have no window: they have no transient that dwarfs the rest.
fn rest(
    result: &RunResult,
    end_s: f64,
    of: impl Fn(&LoopSample) -> f64,
    least: f64,
) -> Option<InsetRange> {
    let (Task::Step(_), RunTrace::Loop(moments)) = (&result.plan.task, &result.trace) else {
        return None;
    };
    let near = TRANSIENT * moments.first()?.error_deg().abs();
    let far = moments.iter().rposition(|m| m.error_deg().abs() > near);
    let near_s = far.and_then(|far| moments.get(far + 1)).map_or(TRANSIENT_S, |m| 1.5 * m.time_s);
    let size = |from_s: f64| {
        let some = moments.iter().filter(|m| m.time_s >= from_s).map(|m| of(m).abs());
        some.filter(|value| value.is_finite()).fold(0.0, f64::max)
    };
    let half = 1.25 * size(near_s).max(least);
    (size(0.0) > LEAST_ZOOM * half && near_s < end_s)
        .then_some(InsetRange { time: (0.8 * near_s, end_s), values: (-half, half) })
}

/// Returns the smallest window around all given windows.
fn around(windows: impl Iterator<Item = InsetRange>) -> Option<InsetRange> {
    windows.reduce(|a, b| InsetRange {
        time: (a.time.0.min(b.time.0), a.time.1.max(b.time.1)),
        values: (a.values.0.min(b.values.0), a.values.1.max(b.values.1)),
    })
}

/// Returns whether the output is that of PD alone: nothing is added, and nothing is cut off.
fn is_plain(result: &RunResult) -> bool {
    points(result, f64::INFINITY, |m| f64::from(m.tick.v - m.tick.v_pd))
        .iter()
        .all(|(_, difference)| *difference == 0.0)
}

/// Returns the name of a run's curve: its motion, or its variants if all motions are the same.
fn curve_name(result: &RunResult, among: &[&RunResult]) -> String {
    let same_task = among.iter().all(|other| other.plan.task == result.plan.task);
    if same_task && among.len() > 1 {
        result.plan.slugs().into_iter().map(in_words).collect::<Vec<_>>().join(", ")
    } else {
        task_name(result)
    }
}

fn task_name(result: &RunResult) -> String {
    let slug = result.plan.task.slug();
    match &result.plan.task {
        Task::Step(_) => format!("{} deg", slug.trim_start_matches("step-")),
        Task::Trajectory(_) => format!("{} deg/s", slug.trim_start_matches("trajectory-")),
        Task::Sine(sine) => format!("{} deg, {} Hz", sine.amplitude_deg, sine.frequency_hz),
        Task::Ramp(_) => format!("{} V/s", slug.trim_start_matches("rate-")),
    }
}
