//! Which figures a set of runs makes, and what is in them.
//!
//! One figure for each result of the thesis's Figs. 26-59 and 63-67: displacements, errors and the
//! breakdown of the control signal under each other. Where the thesis shows one result measured and
//! simulated, this is one figure, and simulated.

use std::path::Path;

use super::{Figure, Line, Panel, Style};
use crate::closed_loop::Moment;
use crate::experiment::Task;
use crate::machine::FigureSource;
use crate::run::{RunResult, Trace};

/// The roles of the curves that are compared in one panel; no more are told apart in print.
const COMPARED: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// After this long a step's transient no longer decides the range of an axis, s.
const TRANSIENT_S: f64 = 1.0;

/// A figure and the name of its file, without an ending.
#[derive(Clone, Debug)]
pub struct NamedFigure {
    /// The name of the file, such as `step-response-srnf-steps`.
    pub stem: String,
    /// The figure.
    pub figure: Figure,
}

/// The figures of an experiment's results. `sources` tells which figures of the thesis they answer
/// to; a run that diverged has none, since its last values fit no axis.
pub fn figures(
    experiment: &str,
    results: &[RunResult],
    sources: &[FigureSource],
) -> Vec<NamedFigure> {
    let mut figures = Vec::new();
    // So that the figures of several experiments can lie in one directory.
    let prefix = Path::new(experiment).file_stem().unwrap_or_default().to_string_lossy();
    for group in groups(results, sources) {
        let (ramps, loops): (Vec<_>, Vec<_>) =
            group.results.iter().partition(|result| matches!(result.plan.task, Task::Ramp(_)));
        figures.extend(ramps.into_iter().filter_map(|result| ramp_figure(result, &prefix)));
        let (steps, trajectories): (Vec<_>, Vec<_>) =
            loops.into_iter().partition(|result| matches!(result.plan.task, Task::Step(_)));
        for (kind, results) in [("steps", steps), ("trajectories", trajectories)] {
            for (i, some) in results.chunks(COMPARED.len()).enumerate() {
                let part = if i == 0 { String::new() } else { format!("-{}", i + 1) };
                let stem = format!("{prefix}-{}-{kind}{part}", group.name.replace('/', "-"));
                figures.push(NamedFigure { stem, figure: loop_figure(some, &group, kind) });
            }
        }
    }
    figures
}

/// Runs that belong into one figure.
struct Group<'a> {
    /// `srnf` or `srnf/test-1`.
    name: String,
    thesis: Option<&'a FigureSource>,
    results: Vec<&'a RunResult>,
}

fn groups<'a>(results: &'a [RunResult], sources: &'a [FigureSource]) -> Vec<Group<'a>> {
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

fn loop_figure(results: &[&RunResult], group: &Group, kind: &str) -> Figure {
    let mut panels = vec![displacements(results), errors(results)];
    let wanted = group.thesis.map(|source| source.breakdown.as_slice()).unwrap_or_default();
    for (i, result) in results.iter().enumerate() {
        if wanted.contains(&result.plan.task.slug()) || (wanted.is_empty() && i == 0) {
            panels.extend(breakdown(result, &curve_name(result, results)));
        }
    }
    let subtitle = match group.thesis {
        Some(source) => format!("simulated; to compare with {} of the thesis", source.thesis),
        None => "simulated".into(),
    };
    Figure { title: title(&group.name, kind), subtitle, x_label: "time (s)".into(), panels }
}

/// `srnf/test-1` and `steps` as a title; a user's own controller keeps its name.
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

/// What a built-in variant is; another one keeps its name.
fn in_words(slug: &str) -> String {
    match slug.split_once('-') {
        Some(("delay", "1")) => "one sample of delay".into(),
        Some(("added", "variable")) => "friction added now and then".into(),
        Some(("added", volts)) if volts.parse::<f64>().is_ok() => {
            format!("{volts} V of friction added")
        }
        Some(("friction", times)) if times.parse::<f64>().is_ok() => {
            format!("{times} times the friction")
        }
        Some(("test", number)) if number.parse::<u32>().is_ok() => format!("test {number}"),
        Some(("literal", "si")) => "gain read in SI".into(),
        _ => slug.into(),
    }
}

fn displacements(results: &[&RunResult]) -> Panel {
    let mut lines = Vec::new();
    for (result, style) in results.iter().zip(COMPARED) {
        lines.push(Line::new(
            curve_name(result, results),
            style,
            points(result, |m| m.position_deg),
        ));
    }
    for (i, result) in results.iter().enumerate() {
        let name = if i == 0 { "reference" } else { "" };
        lines.push(Line::new(name, Style::Reference, points(result, |m| m.reference_deg)));
    }
    Panel::new("displacement (deg)", lines)
}

fn errors(results: &[&RunResult]) -> Panel {
    let curves = results.iter().zip(COMPARED).map(|(result, style)| {
        Line::new(curve_name(result, results), style, points(result, Moment::error_deg))
    });
    let range = results.iter().filter_map(|result| settled_range(result, Moment::error_deg, 0.02));
    Panel { y_range: widest(range), ..Panel::new("error (deg)", curves.collect()) }
}

/// v_PD, v_c and v of one run, each in its own panel: signals that chatter would hide each other in
/// one.
fn breakdown(result: &RunResult, curve: &str) -> Vec<Panel> {
    type Signal = (&'static str, &'static str, Style, fn(&Moment) -> f64);
    let all: [Signal; 3] = [
        ("v_PD", "v_PD (V)", Style::Primary, |m| f64::from(m.tick.v_pd)),
        ("v_c", "v_c (V)", Style::Compensation, |m| f64::from(m.tick.v_c)),
        ("v", "v (V)", Style::Total, |m| f64::from(m.tick.v)),
    ];
    let range = widest(all.iter().filter_map(|(.., of)| settled_range(result, of, 0.5)));
    let plain = is_plain(result);
    let shown = all.into_iter().filter(|(name, ..)| !plain || *name == "v_PD");
    shown
        .map(|(name, label, style, of)| {
            let name = if plain { "v = v_PD".into() } else { name.to_owned() };
            let line = Line::new(format!("{name}, {curve}"), style, points(result, of)).held();
            Panel { height: 0.62, y_range: range, ..Panel::new(label, vec![line]) }
        })
        .collect()
}

fn ramp_figure(result: &RunResult, prefix: &str) -> Option<NamedFigure> {
    let Trace::Ramp(moments) = &result.trace else { return None };
    let series =
        |of: fn(&Moment) -> f64| moments.iter().map(|m| (m.time_s, of(m))).collect::<Vec<_>>();
    let rate = result.plan.task.slug();
    let panels = vec![
        Panel::new(
            "effort (V)",
            vec![Line::new("v", Style::Total, series(|m| m.tick.v.into())).held()],
        ),
        Panel::new(
            "displacement (deg)",
            vec![Line::new("joint", Style::Primary, series(|m| m.position_deg))],
        ),
        Panel::new(
            "velocity (deg/s)",
            vec![Line::new("joint", Style::Primary, series(|m| m.velocity_deg_per_s))],
        ),
    ];
    let title =
        format!("Friction from a ramp of the effort: {} V/s", rate.trim_start_matches("rate-"));
    let figure = Figure { title, subtitle: "simulated".into(), x_label: "time (s)".into(), panels };
    Some(NamedFigure { stem: format!("{prefix}-{rate}"), figure })
}

fn points(result: &RunResult, of: impl Fn(&Moment) -> f64) -> Vec<(f64, f64)> {
    match &result.trace {
        Trace::Loop(moments) => moments.iter().map(|m| (m.time_s, of(m))).collect(),
        Trace::Ramp(_) => Vec::new(),
    }
}

/// For a step: a symmetric range that shows what is left after the transient, at least `least` on
/// either side. A trajectory has no transient that dwarfs the rest.
fn settled_range(
    result: &RunResult,
    of: impl Fn(&Moment) -> f64,
    least: f64,
) -> Option<(f64, f64)> {
    let (Task::Step(_), Trace::Loop(moments)) = (&result.plan.task, &result.trace) else {
        return None;
    };
    let settled = moments.iter().filter(|m| m.time_s >= TRANSIENT_S).map(|m| of(m).abs());
    let half = 1.25 * settled.filter(|value| value.is_finite()).fold(least, f64::max);
    Some((-half, half))
}

fn widest(ranges: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Whether the output is that of PD: nothing is added and nothing cut off.
fn is_plain(result: &RunResult) -> bool {
    points(result, |m| f64::from(m.tick.v - m.tick.v_pd))
        .iter()
        .all(|(_, difference)| *difference == 0.0)
}

/// By its motion, or by its variant where only that differs.
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
        Task::Ramp(_) => format!("{} V/s", slug.trim_start_matches("rate-")),
    }
}
