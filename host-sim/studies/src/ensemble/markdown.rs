//! The summary as tables in Markdown, for pages: a row for each family, a column for each law. A
//! family whose results differ between encoder and load has a second row.

use super::group::Group;
use super::rows::EnsembleHeader;
use super::summary::LawSummary;

/// Renders success with its interval, then rest and tracking at their 90 % quantiles.
pub fn markdown(header: &EnsembleHeader, families: &[(Group, Vec<LawSummary>)]) -> String {
    let success = |law: &LawSummary, count: usize, interval: [f64; 2]| {
        let percent = |share: f64| format!("{:.0}", 100.0 * share);
        let [low, high] = interval.map(percent);
        let share = count as f64 / law.cases.max(1) as f64;
        // Only a share of all cases is 100: one that is rounded to 100 has a decimal.
        let share = if count == law.cases { "100".into() } else { format!("{:.1}", 100.0 * share) };
        format!("{share} ({low}-{high})")
    };
    let judged = |_: &Group, law: &LawSummary| success(law, law.success, law.success_ci);
    let at_load =
        |_: &Group, law: &LawSummary| success(law, law.at_load.success, law.at_load.success_ci);
    let rest = |_: &Group, law: &LawSummary| quantile(law.rest_counts.quantile(0.9), 1.0);
    let tracking =
        |group: &Group, law: &LawSummary| quantile(law.tracking_rms.quantile(0.9), scale(group));
    let blocks = [
        successes(header, families, &judged, &at_load),
        table(header, families, &|group| format!("`{}`: rest, counts", group.name), &rest),
        table(
            header,
            families,
            &|group| format!("`{}`: tracking, {}", group.name, unit(group)),
            &tracking,
        ),
    ];
    blocks.join("\n")
}

/// Returns the unit of tracking errors: mrad for rad, since these are small numbers.
fn unit(group: &Group) -> String {
    if scale(group) > 1.0 { format!("m{}", group.unit) } else { group.unit.clone() }
}

fn scale(group: &Group) -> f64 {
    if group.unit == "rad" { 1e3 } else { 1.0 }
}

/// Formats a scaled value with about three digits; an infinite one is `fault`.
fn quantile(value: Option<f64>, scale: f64) -> String {
    match value.map(|value| scale * value) {
        None => "-".into(),
        Some(value) if value.is_infinite() => "fault".into(),
        Some(value) if value >= 100.0 => format!("{value:.0}"),
        Some(value) if value >= 10.0 => format!("{value:.1}"),
        Some(value) if value >= 1.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.3}"),
    }
}

type Cell<'a> = &'a dyn Fn(&Group, &LawSummary) -> String;

/// Renders the success of each family; if the results at encoder and load differ, that at the load
/// as well.
fn successes(
    header: &EnsembleHeader,
    families: &[(Group, Vec<LawSummary>)],
    judged: Cell<'_>,
    at_load: Cell<'_>,
) -> String {
    let mut text = titles(header);
    for family in families {
        let (group, summaries) = family;
        // A machine's file is judged at its load.
        let is_two_sided =
            group.is_family && summaries.iter().any(|summary| summary.is_two_sided());
        let side = if is_two_sided { ", at the encoder" } else { "" };
        text += &row(header, family, &format!("`{}`{side}", group.name), judged);
        if is_two_sided {
            text += &row(header, family, &format!("`{}`, at the load", group.name), at_load);
        }
    }
    text
}

fn table(
    header: &EnsembleHeader,
    families: &[(Group, Vec<LawSummary>)],
    name: &dyn Fn(&Group) -> String,
    cell: Cell<'_>,
) -> String {
    let rows = families.iter().map(|family| row(header, family, &name(&family.0), cell));
    titles(header) + &rows.collect::<String>()
}

fn titles(header: &EnsembleHeader) -> String {
    let laws: Vec<String> = header.laws.iter().map(|law| format!("`{law}`")).collect();
    format!("| joints | {} |\n|---|{}\n", laws.join(" | "), "---|".repeat(laws.len()))
}

fn row(
    header: &EnsembleHeader,
    (group, summaries): &(Group, Vec<LawSummary>),
    name: &str,
    cell: Cell<'_>,
) -> String {
    let cells = header.laws.iter().map(|law| {
        let summary = summaries.iter().find(|summary| summary.law == *law);
        summary.map_or_else(|| "-".into(), |summary| cell(group, summary))
    });
    format!("| {name} | {} |\n", cells.collect::<Vec<_>>().join(" | "))
}
