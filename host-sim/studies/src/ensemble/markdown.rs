//! The summary as tables in Markdown, for pages: a row for each family, a column for each law.

use super::rows::{Group, Header};
use super::summary::Summary;

/// Renders success with its interval, then rest and tracking at their 90 % quantiles.
pub fn markdown(header: &Header, families: &[(Group, Vec<Summary>)]) -> String {
    let success = |_: &Group, law: &Summary| {
        let percent = |share: f64| format!("{:.0}", 100.0 * share);
        let [low, high] = law.success_ci.map(percent);
        let share = law.success as f64 / law.cases.max(1) as f64;
        // A share that is rounded to the whole is not the whole.
        let share =
            if law.success == law.cases { "100".into() } else { format!("{:.1}", 100.0 * share) };
        format!("{share} ({low}-{high})")
    };
    let rest = |_: &Group, law: &Summary| quantile(law.rest_counts.quantile(0.9), 1.0);
    let tracking =
        |group: &Group, law: &Summary| quantile(law.tracking_rms.quantile(0.9), scale(group));
    let blocks = [
        table(header, families, &|group| format!("`{}`", group.name), &success),
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

/// Tracking errors in rad are small numbers.
fn unit(group: &Group) -> String {
    if scale(group) > 1.0 { format!("m{}", group.unit) } else { group.unit.clone() }
}

fn scale(group: &Group) -> f64 {
    if group.unit == "rad" { 1e3 } else { 1.0 }
}

/// Two digits, and more of what is large.
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

fn table(
    header: &Header,
    families: &[(Group, Vec<Summary>)],
    name: &dyn Fn(&Group) -> String,
    cell: &dyn Fn(&Group, &Summary) -> String,
) -> String {
    let laws: Vec<String> = header.laws.iter().map(|law| format!("`{law}`")).collect();
    let mut text =
        format!("| joints | {} |\n|---|{}\n", laws.join(" | "), "---|".repeat(laws.len()));
    for (group, summaries) in families {
        let cells = header.laws.iter().map(|law| {
            let summary = summaries.iter().find(|summary| summary.law == *law);
            summary.map_or_else(|| "-".into(), |summary| cell(group, summary))
        });
        text += &format!("| {} | {} |\n", name(group), cells.collect::<Vec<_>>().join(" | "));
    }
    text
}
