//! The summary as one JSON object, schema 1. Keys can be added, but are never renamed.
//!
//! A quantile that is infinite, because a joint never settled or a fault ended its motion, is
//! `null`.

use serde_json::{Map, Value, json};

use super::group::Group;
use super::rows::EnsembleHeader;
use super::statistics::SortedValues;
use super::summary::{LawSummary, MovesSummary, SideSummary};
use super::trips::{EndedMotion, FalseTrip};

/// Returns the summary as a JSON object.
pub fn object(header: &EnsembleHeader, families: &[(Group, Vec<LawSummary>)]) -> Value {
    let of_family = |(group, summaries): &(Group, Vec<LawSummary>)| {
        let mut laws = Map::new();
        laws.insert("unit".into(), json!(group.unit));
        let of_law = |summary: &LawSummary| (summary.law.clone(), law(summary, header.seed));
        laws.extend(summaries.iter().map(of_law));
        (group.name.clone(), Value::Object(laws))
    };
    let of_groups = |of: fn(&Group) -> Value| -> Map<String, Value> {
        families.iter().map(|(group, _)| (group.name.clone(), of(group))).collect()
    };
    json!({
        "schema": 1,
        "seed": header.seed,
        "cases": header.cases,
        "hard": header.hard,
        "rate_hz": header.rate_hz,
        "moves": header.moves,
        "motion": header.motion.name(),
        "condition": header.condition.name(),
        "bridge": header.bridge.name(),
        "effort_units": of_groups(|group| json!(group.effort_unit)),
        "settles_within_s": of_groups(|group| json!(group.settles_within_s)),
        "goals": of_groups(|group| json!(group.goal)),
        "unseen_slack": of_groups(|group| json!(group.unseen_slack)),
        "families": families.iter().map(of_family).collect::<Map<_, _>>(),
    })
}

/// Returns the share of cases that succeed, from 0 to 1; `None` without cases.
fn share(successes: usize, cases: usize) -> Option<f64> {
    (cases > 0).then(|| successes as f64 / cases as f64)
}

fn law(summary: &LawSummary, seed: u64) -> Value {
    let quantiles = |sorted: &SortedValues, shares: &[(&str, f64)]| {
        let of =
            |(name, share): &(&str, f64)| ((*name).to_owned(), number(sorted.quantile(*share)));
        Value::Object(shares.iter().map(of).collect())
    };
    let settling: [(&str, f64); 3] = [("p50", 0.5), ("p95", 0.95), ("max", 1.0)];
    let usual: [(&str, f64); 3] = [("p50", 0.5), ("p90", 0.9), ("max", 1.0)];
    let two: [(&str, f64); 2] = [("p50", 0.5), ("max", 1.0)];
    let mut value = json!({
        "cases": summary.cases,
        "success": share(summary.success, summary.cases),
        "successes": summary.success,
        "success_ci": summary.success_ci,
        "settling_s": quantiles(&summary.settling_s, &settling),
        "rest_counts": quantiles(&summary.rest_counts, &usual),
        "hunting_cases": summary.hunting_cases,
        "hunting_counts": quantiles(&summary.hunting_counts, &two),
        "hunting_period_s": quantiles(&summary.hunting_period_s, &two),
        "tracking_rms": quantiles(&summary.tracking_rms, &usual),
        "sticks_in_motion": quantiles(&summary.sticks_in_motion, &two),
        "total_variation_rest_per_s": finite(summary.variation_rest_per_s),
        "total_variation_motion_per_s": finite(summary.variation_motion_per_s),
        "held_effort_rms": quantiles(&summary.held_effort, &usual),
        "false_trips": summary.false_trips,
        "faults": summary.faults,
        "worst": summary.worst,
    });
    let Some(object) = value.as_object_mut() else { return value };
    for (name, side) in [("encoder", &summary.at_encoder), ("load", &summary.at_load)] {
        let SideSummary { success, success_ci, settled_s, rest_counts } = side;
        object.insert(format!("success_at_{name}"), json!(share(*success, summary.cases)));
        object.insert(format!("success_at_{name}_ci"), json!(success_ci));
        object.insert(format!("successes_at_{name}"), json!(success));
        object.insert(format!("settled_at_{name}_s"), quantiles(settled_s, &settling));
        object.insert(format!("rest_at_{name}_counts"), quantiles(rest_counts, &usual));
    }
    let trips: Vec<Value> = summary.trips.iter().map(|one| trip(one, seed)).collect();
    object.insert("trips".into(), trips.into());
    if summary.load_rest_counts.max().is_some() {
        object.insert("load_rest_counts".into(), quantiles(&summary.load_rest_counts, &usual));
    }
    if summary.near_s.max().is_some() {
        object.insert("near_s".into(), quantiles(&summary.near_s, &usual));
    }
    if summary.gave_up_s.max().is_some() {
        object.insert("gave_up_s".into(), quantiles(&summary.gave_up_s, &settling));
        object.insert("gave_up_cases".into(), json!(summary.gave_up_s.finite()));
        object.insert("effort_after".into(), quantiles(&summary.effort_after, &usual));
    }
    if !summary.by_jump.is_empty() {
        let class = |(name, cases, success): &(&str, usize, usize)| {
            let of_class = json!({
                "cases": cases,
                "success": share(*success, *cases),
                "successes": success,
            });
            ((*name).to_owned(), of_class)
        };
        object.insert(
            "by_jump".into(),
            summary.by_jump.iter().map(class).collect::<Map<_, _>>().into(),
        );
    }
    if let Some(MovesSummary { moves, judged, missed, missed_of_all, tracking_rms }) =
        &summary.moves
    {
        let tenth = |missed: u64, rms: &SortedValues| {
            let rms = quantiles(rms, &usual);
            json!({ "moves": judged, "missed": missed, "tracking_rms": rms })
        };
        let [first, last] = [0, 1].map(|i: usize| tenth(missed[i], &tracking_rms[i]));
        let row = json!({ "moves": moves, "missed": missed_of_all, "first": first, "last": last });
        object.insert("moves".into(), row);
    }
    value
}

fn trip(FalseTrip { case, ended, fault, code }: &FalseTrip, seed: u64) -> Value {
    let number = match ended {
        EndedMotion::Move(number) => Some(number),
        EndedMotion::Positioning(_) | EndedMotion::Trajectory => None,
    };
    json!({
        "case": case,
        "seed": seed,
        "motion": ended.name(),
        "move": number,
        "fault": fault,
        "code": code,
    })
}

fn number(value: Option<f64>) -> Value {
    value.map_or(Value::Null, finite)
}

fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}
