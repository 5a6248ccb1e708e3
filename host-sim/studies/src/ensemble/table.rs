//! The summary as tables for people, within 80 columns.

use std::fmt::Write as _;

use super::group::Group;
use super::motions::Approach;
use super::rows::EnsembleHeader;
use super::statistics::SortedValues;
use super::summary::{LawSummary, MovesSummary, SideSummary};
use simulator::output::grid::{self, number};
use simulator::rules::{GainRule, RULES, TUNING_SEEDS};

/// Largest number of trips of a law that the text lists.
const TRIPS_NAMED: usize = 10;

/// Renders the families, each with its laws, the best first.
pub fn render(header: &EnsembleHeader, families: &[(Group, Vec<LawSummary>)]) -> String {
    let mut text = String::new();
    for (group, summaries) in families.iter().filter(|(_, summaries)| !summaries.is_empty()) {
        let Group { name, unit, effort_unit, goal, .. } = group;
        let ranked = ranked(group, summaries);
        let is_two_sided = ranked.iter().any(|summary| summary.is_two_sided());
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "{name}{}{}: {} joints; success{}: {}\n\n{}\n\n{}{}\n\n",
            header.condition.suffix(),
            header.bridge.suffix(),
            ranked.first().map_or(0, |summary| summary.cases),
            if is_two_sided { judged_side(group) } else { "" },
            goal.describe(),
            precision(&ranked),
            if is_two_sided { sides(&ranked) + "\n\n" } else { String::new() },
            motion(&ranked, unit, effort_unit),
        );
        for remark in ranked.iter().flat_map(|summary| remarks(summary, group, header.seed)) {
            text += &(remark + "\n");
        }
        text.push('\n');
    }
    let is_unseen = |(group, laws): &(Group, Vec<LawSummary>)| {
        group.is_family && laws.iter().any(LawSummary::is_two_sided)
    };
    if families.iter().any(is_unseen) {
        text += UNSEEN;
    }
    text += &legend(header);
    text
}

/// Remark on what an encoder on the motor cannot see, for families; for a machine's file it is a
/// warning.
const UNSEEN: &str = "\
Where the load differs, the encoder is on the motor and cannot see the slack of the gear:
the load can be off by the backlash and by the wind-up of the shaft.

";

/// Returns the laws by their success, then by their 95 % settling, then by their tracking. If the
/// encoder of a machine's file cannot see slack, success and settling are those at the encoder, as
/// in the benchmark: no law corrects what its encoder cannot see.
fn ranked<'a>(group: &Group, summaries: &'a [LawSummary]) -> Vec<&'a LawSummary> {
    let mut ranked: Vec<&LawSummary> = summaries.iter().collect();
    let p = |sorted: &SortedValues, share| sorted.quantile(share).unwrap_or(f64::INFINITY);
    let judged = |summary: &'a LawSummary| match group.unseen_slack {
        Some(_) => (summary.at_encoder.success, &summary.at_encoder.settled_s),
        None => (summary.success, &summary.settling_s),
    };
    ranked.sort_by(|a, b| {
        let ((a_success, a_settled), (b_success, b_settled)) = (judged(a), judged(b));
        let settling = p(a_settled, 0.95).total_cmp(&p(b_settled, 0.95));
        let tracking = p(&a.tracking_rms, 0.5).total_cmp(&p(&b.tracking_rms, 0.5));
        b_success.cmp(&a_success).then(settling).then(tracking)
    });
    ranked
}

/// Returns the words for the side that the first table judges.
const fn judged_side(group: &Group) -> &'static str {
    if group.unseen_slack.is_some() {
        " at the load, ranked at the encoder"
    } else {
        " at the encoder"
    }
}

/// Renders the results at the encoder and at the load, side by side.
fn sides(ranked: &[&LawSummary]) -> String {
    let mut table = grid::new(&[
        "law",
        "at the\nencoder\n%",
        "95 %\nfrom\n-to",
        "set-\ntled\np50 s",
        "rest\np90\ncnts",
        "at the\nload\n%",
        "95 %\nfrom\n-to",
        "set-\ntled\np50 s",
        "rest\np90\ncnts",
    ]);
    for summary in ranked {
        let cells = |side: &SideSummary| {
            let share = 100.0 * side.success as f64 / summary.cases.max(1) as f64;
            let [low, high] = side.success_ci.map(|share| 100.0 * share);
            [
                number(Some(share), 1),
                format!("{low:.0}-{high:.0}"),
                time(side.settled_s.quantile(0.5)),
                short(side.rest_counts.quantile(0.9)),
            ]
        };
        let both = [cells(&summary.at_encoder), cells(&summary.at_load)].concat();
        table.add_row(std::iter::once(summary.law.clone()).chain(both));
    }
    table.trim_fmt()
}

fn precision(ranked: &[&LawSummary]) -> String {
    let mut table = grid::new(&[
        "law",
        "suc-\ncess\n%",
        "95 %\nfrom\n-to",
        "set-\ntled\np50 s",
        "p95\ns",
        "rest\np50\ncnts",
        "p90\ncnts",
        "hunt\ncases",
        "false\ntrips",
    ]);
    for summary in ranked {
        let share = 100.0 * summary.success as f64 / summary.cases.max(1) as f64;
        let [low, high] = summary.success_ci.map(|share| 100.0 * share);
        let settled = |share| time(summary.settling_s.quantile(share));
        table.add_row([
            summary.law.clone(),
            number(Some(share), 1),
            format!("{low:.0}-{high:.0}"),
            settled(0.5),
            settled(0.95),
            short(summary.rest_counts.quantile(0.5)),
            short(summary.rest_counts.quantile(0.9)),
            summary.hunting_cases.to_string(),
            summary.false_trips.to_string(),
        ]);
    }
    table.trim_fmt()
}

fn motion(ranked: &[&LawSummary], unit: &str, effort_unit: &str) -> String {
    let (scale, unit) = readable(unit);
    let headers = [
        format!("rms p50\n{unit}"),
        format!("p90\n{unit}"),
        format!("variation\n{effort_unit}/s"),
        format!("at rest\n{effort_unit}/s"),
        format!("held p50\n{effort_unit}"),
        format!("p90\n{effort_unit}"),
    ];
    let [p50, p90, moving, resting, held, held_p90] = &headers;
    let mut table =
        grid::new(&["law", p50, p90, "sticks\np50-max", moving, resting, held, held_p90]);
    for summary in ranked {
        let tracking = |share| short(summary.tracking_rms.quantile(share).map(|rms| scale * rms));
        let sticks = |share| number(summary.sticks_in_motion.quantile(share), 0);
        table.add_row([
            summary.law.clone(),
            tracking(0.5),
            tracking(0.9),
            format!("{}-{}", sticks(0.5), sticks(1.0)),
            short(Some(summary.variation_motion_per_s)),
            short(Some(summary.variation_rest_per_s)),
            short(summary.held_effort.quantile(0.5)),
            short(summary.held_effort.quantile(0.9)),
        ]);
    }
    table.trim_fmt()
}

/// Returns the factor from the family's unit to a readable unit of tracking errors, and that unit:
/// 1000 and mrad for rad.
fn readable(unit: &str) -> (f64, &str) {
    if unit == "rad" { (1e3, "mrad") } else { (1.0, unit) }
}

/// Returns the lines below the tables: worst cases, faults, hunting, the load that is not seen,
/// jumps, settling into the wider band, walls, and moves in a row.
fn remarks(summary: &LawSummary, group: &Group, seed: u64) -> Vec<String> {
    let law = &summary.law;
    let Group { unit: whole, effort_unit, near, .. } = group;
    let (scale, unit) = readable(whole);
    let worst: Vec<String> = summary.worst.iter().map(u64::to_string).collect();
    let mut remarks = vec![format!("{law}: the worst cases are {}", worst.join(", "))];
    if !summary.faults.is_empty() {
        let faults = summary.faults.iter().map(|(name, count)| format!("{name} {count}"));
        remarks.push(format!("{law} trips: {}", faults.collect::<Vec<_>>().join(", ")));
        let named = summary.trips.iter().take(TRIPS_NAMED);
        remarks.extend(named.map(|trip| format!("  {trip} (seed {seed})")));
        if let Some(more) = summary.trips.len().checked_sub(TRIPS_NAMED).filter(|more| *more > 0) {
            remarks.push(format!("  and {more} more; --json lists all"));
        }
    }
    if summary.hunting_cases > 0 {
        remarks.push(format!(
            "{law} hunts: {} counts from end to end (most {}), {} s a period",
            short(summary.hunting_counts.quantile(0.5)),
            short(summary.hunting_counts.max()),
            short(summary.hunting_period_s.quantile(0.5)),
        ));
    }
    if summary.load_rest_counts.max().is_some() {
        remarks.push(format!(
            "{law} leaves the load {} counts off (p90 {})",
            short(summary.load_rest_counts.quantile(0.5)),
            short(summary.load_rest_counts.quantile(0.9)),
        ));
    }
    if !summary.by_jump.is_empty() {
        let class =
            |(name, cases, success): &(&str, usize, usize)| format!("{name}: {success}/{cases}");
        let classes: Vec<String> = summary.by_jump.iter().map(class).collect();
        remarks.push(format!("{law} by the load's jump in counts: {}", classes.join(", ")));
    }
    if let Some(near) = near
        && summary.near_s.max().is_some()
    {
        remarks.push(format!(
            "{law} is within {near} {whole}: {} (p50), {} (p90), {} (all)",
            after(summary.near_s.quantile(0.5)),
            after(summary.near_s.quantile(0.9)),
            after(summary.near_s.max()),
        ));
    }
    if summary.gave_up_s.max().is_some() {
        remarks.push(format!(
            "{law} gives up before {} of {} walls: {} (p50), {} (p95), {} (all); then it holds {} \
             {effort_unit} (p50), {} (max)",
            summary.gave_up_s.finite(),
            summary.cases,
            after(summary.gave_up_s.quantile(0.5)),
            after(summary.gave_up_s.quantile(0.95)),
            after(summary.gave_up_s.max()),
            short(summary.effort_after.quantile(0.5)),
            short(summary.effort_after.max()),
        ));
    }
    if let Some(MovesSummary {
        moves,
        judged,
        missed: [first, last],
        missed_of_all,
        tracking_rms,
    }) = &summary.moves
    {
        let [rms_first, rms_last] =
            [0, 1].map(|i: usize| short(tracking_rms[i].quantile(0.5).map(|rms| scale * rms)));
        remarks.push(format!(
            "{law} in {moves} moves in a row: misses {missed_of_all}: {first} of the first \
             {judged}, {last} of the last; tracks to {rms_first}, then {rms_last} {unit}"
        ));
    }
    remarks
}

fn legend(header: &EnsembleHeader) -> String {
    let mut text = String::from(match header.motion {
        Approach::Profiled => {
            "\
All of it is simulated, under a servo with every monitor at its default. The set point
goes to its target within the limits of speed that `new` writes; success is counted from
its end.
"
        }
        Approach::Step => {
            "\
All of it is simulated, under a servo with every monitor at its default. The set point
steps to its target.
"
        }
    });
    text += "\
Rest, in counts, is the largest true error in the last half of the run. The second table
is of a trapezoid of speed: rms error, stops on the way, total variation of the effort;
variation at rest and rms effort are those of the last half at the target.
docs/how-to/ensembles.md has the details.
";
    if TUNING_SEEDS.contains(&header.seed) {
        text += "Seed of the tuning: the rules were made on such joints, so this is no score.\n";
    }
    if !header.families.iter().all(|group| group.is_family) {
        return text + "The gains are those of the file.\n";
    }
    let rules = RULES.iter().filter(|rule| header.laws.iter().any(|law| law == rule.law));
    text += "Rules, and the figures of the joint that each law knows:\n";
    for GainRule { law, knows, text: rule, .. } in rules {
        text += &format!("  {law}: {rule}\n    knows {knows}\n");
    }
    text
}

/// Formats a time with its unit after `after`; `never` if it is infinite.
fn after(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() => format!("after {} s", number(Some(value), 2)),
        value => time(value),
    }
}

/// Formats a time, s; `never` if it is infinite.
fn time(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_infinite() => "never".into(),
        value => number(value, 2),
    }
}

/// Formats a value with two decimals; from 10 on with one, from 100 on with none.
fn short(value: Option<f64>) -> String {
    match value {
        Some(value) if value.abs() >= 100.0 => number(Some(value), 0),
        Some(value) if value.abs() >= 10.0 => number(Some(value), 1),
        value => number(value, 2),
    }
}
