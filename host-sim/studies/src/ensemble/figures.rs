//! The figures of an ensemble: success with its intervals, settling against rest error as a cloud,
//! and traces of single joints.

use super::case;
use super::case_result::{CaseResult, JudgedMotion};
use super::drawn_case::Case;
use super::group::Group;
use super::measures::{BAND_COUNTS, CaseSample};
use super::motions::{Approach, Motions};
use super::rows::EnsembleHeader;
use super::summary::{LawSummary, SideSummary};
use figure::chart::{Chart, ChartContent, Cloud, LogAxis, Share};
use figure::compared::judged_from_s;
use figure::{Figure, NamedFigure, Panel, PlotCurve, Style};
use files::error::Error;
use simulator::rules::GainRule;

/// Returns the charts of all rows.
pub fn charts(
    header: &EnsembleHeader,
    families: &[(Group, Vec<LawSummary>)],
    rows: &[CaseResult],
) -> Vec<Chart> {
    let of_side = |summary: &LawSummary, side: &SideSummary| Share {
        name: summary.law.clone(),
        share: side.success as f64 / summary.cases.max(1) as f64,
        interval: side.success_ci,
    };
    let judged = families.iter().filter(|(_, laws)| !laws.is_empty());
    let groups = judged.flat_map(|(group, laws)| {
        let at_encoder = laws.iter().map(|law| of_side(law, &law.at_encoder)).collect();
        let at_load = laws.iter().map(|law| of_side(law, &law.at_load)).collect();
        let Group { name, goal, .. } = group;
        let goal = goal.describe();
        if is_two_sided(laws) {
            let title = |side: &str| format!("{name}, at the {side}: {goal}");
            vec![(title("encoder"), at_encoder), (title("load"), at_load)]
        } else {
            vec![(format!("{name}: {goal}"), at_encoder)]
        }
    });
    let success = Chart {
        stem: "success".into(),
        title: "Joints that come to rest at their target in time and stay there".into(),
        subtitle: "simulated; share of the joints and its 95 % interval (Wilson)".into(),
        shown: ChartContent::Shares(groups.collect()),
    };
    let judged = families.iter().filter(|(_, laws)| !laws.is_empty());
    let clouds = judged.map(|(group, laws)| cloud(header, group, rows, is_two_sided(laws)));
    std::iter::once(success).chain(clouds).collect()
}

fn is_two_sided(laws: &[LawSummary]) -> bool {
    laws.iter().any(LawSummary::is_two_sided)
}

fn cloud(header: &EnsembleHeader, group: &Group, rows: &[CaseResult], is_two_sided: bool) -> Chart {
    let of_group: Vec<&CaseResult> = rows.iter().filter(|row| row.family == group.name).collect();
    let of = |law: &String, side: &str, point: fn(&CaseResult) -> (Option<f64>, f64)| {
        let of_law = of_group.iter().filter(|row| row.law == *law).map(|row| point(row));
        let points =
            of_law.map(|(settled_s, rest)| [settled_s.unwrap_or(f64::INFINITY), rest]).collect();
        Cloud { name: format!("{law}{side}"), points }
    };
    let at_encoder = |row: &CaseResult| (row.settled_at_encoder_s, row.rest_at_encoder_counts);
    let at_load = |row: &CaseResult| (row.settled_at_load_s, row.rest_at_load_counts);
    let clouds = header.laws.iter().flat_map(|law| {
        if is_two_sided {
            vec![of(law, ", at the encoder", at_encoder), of(law, ", at the load", at_load)]
        } else {
            vec![of(law, "", at_encoder)]
        }
    });
    // Counts of a family differ, but its goal is in counts.
    let count_deg = of_group.first().map_or(1.0, |row| row.count);
    let settling = LogAxis {
        label: "settling (s)".into(),
        decades: [-2, 2],
        bound: group.settles_within_s,
        beyond: "never".into(),
    };
    let rest = LogAxis {
        label: "rest error (counts)".into(),
        decades: [-2, 4],
        bound: group.goal.tolerance_counts(count_deg),
        beyond: String::new(),
    };
    Chart {
        stem: format!("cloud-{}", group.name),
        title: format!("Settling against rest error: {}", group.name),
        subtitle: "simulated; a point is a joint, and a success lies below and left of the lines"
            .into(),
        shown: ChartContent::Clouds {
            axes: [settling, rest],
            clouds: clouds.collect(),
            columns: if is_two_sided { 2 } else { 3 },
        },
    }
}

/// Runs a joint again under a law, and returns the figures of its step and of its trajectory.
///
/// # Errors
/// If the core refuses gains.
pub fn traces(
    joint: &Case,
    rule: &GainRule,
    approach: Approach,
) -> Result<Vec<NamedFigure>, Error> {
    let mut seen: [Vec<(f64, CaseSample)>; 2] = [Vec::new(), Vec::new()];
    let gains = joint.gains(rule);
    let motions = Motions { approach, ..Motions::default() };
    case::run_and_show(joint, rule.law, &gains, motions, |motion, time_s, sample| {
        seen[motion as usize].push((time_s, *sample));
    })?;
    let of = |motion: JudgedMotion, name: &str| {
        let samples = &seen[motion as usize];
        figure(joint, rule.law, name, samples, motion == JudgedMotion::Positioning)
    };
    let mut drawn = vec![of(JudgedMotion::Positioning, approach.name())];
    if !joint.family.has_wall() {
        drawn.push(of(JudgedMotion::Trajectory, "trajectory"));
    }
    Ok(drawn)
}

fn figure(
    joint: &Case,
    law: &str,
    motion: &str,
    samples: &[(f64, CaseSample)],
    is_step: bool,
) -> NamedFigure {
    let points = |of: fn(&CaseSample) -> f64| -> Vec<(f64, f64)> {
        samples.iter().map(|(time_s, sample)| (*time_s, of(sample))).collect()
    };
    // The errors after a step's first second decide the range.
    let from_s = judged_from_s(samples.last().map_or(0.0, |(time_s, _)| *time_s));
    let settled = samples.iter().filter(|(time_s, _)| !is_step || *time_s >= from_s);
    let far = |error: f64| error.abs().min(1e4);
    // All curves that are drawn count, so that none stays beyond the panel.
    let has_other = joint.family.has_unseen_load() || joint.family.is_arm();
    let farther =
        |s: &CaseSample| far(s.error).max(if has_other { far(s.load_error) } else { 0.0 });
    let half = 1.25 * settled.map(|(_, s)| farther(s)).fold(2.0 * BAND_COUNTS, f64::max);
    let mut errors = vec![PlotCurve::new("at the encoder", Style::Primary, points(|s| s.error))];
    if joint.family.has_unseen_load() {
        errors.push(PlotCurve::new("at the load", Style::Second, points(|s| s.load_error)));
    }
    if joint.family.is_arm() {
        errors.push(PlotCurve::new("of the second joint", Style::Second, points(|s| s.load_error)));
    }
    let ends = [samples.first(), samples.last()].map(|end| end.map_or(0.0, |(time_s, _)| *time_s));
    for (name, bound) in [("2 counts", BAND_COUNTS), ("", -BAND_COUNTS)] {
        let at = ends.iter().map(|time_s| (*time_s, bound)).collect();
        errors.push(PlotCurve::new(name, Style::Limit, at));
    }
    let unit = joint.family.units().effort;
    let effort = PlotCurve::new("effort", Style::Total, points(|s| s.effort)).held();
    let panels = vec![
        Panel::new(
            "position (counts)",
            vec![
                PlotCurve::new("joint", Style::Primary, points(|s| s.position)),
                PlotCurve::new("set point", Style::Reference, points(|s| s.position + s.error)),
            ],
        ),
        Panel { y_range: Some((-half, half)), ..Panel::new("error (counts)", errors) },
        Panel::new(format!("effort ({unit})"), vec![effort]),
    ];
    let (family, number) = (joint.family.name(), joint.number);
    NamedFigure {
        stem: format!("{family}-{law}-case-{number}-{motion}"),
        figure: Figure {
            title: format!("Case {number} of {family} under {law}: {motion}"),
            subtitle: "simulated".into(),
            x_label: "time (s)".into(),
            panels,
        },
    }
}
