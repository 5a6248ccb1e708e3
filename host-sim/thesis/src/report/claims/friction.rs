//! Readings of the friction lab's runs.

use super::ratios;
use crate::lab::{LabResult, LabSample};
use crate::report::evidence::ReportEvidence;
use dynamics::solver::EventKind;

/// Returns F_s or F_d of each body, N or N m.
pub(super) fn levels(result: &LabResult, of: &str) -> Vec<f64> {
    let table = &result.plan.parameters["friction"];
    let levels = table[format!("{of}_n")].as_array().or(table[format!("{of}_nm")].as_array());
    levels.into_iter().flatten().filter_map(|level| level.as_f64()).collect()
}

/// Returns the largest friction of each body less its F_s, N or N m.
pub(super) fn excess(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let peaks = result.metrics.peak_friction.iter().zip(levels(result, "stick"));
    Some(peaks.map(|(peak, stick)| peak - stick).collect())
}

/// Returns the largest friction of each body, relative to its F_s.
pub(super) fn peaks(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let peaks = result.metrics.peak_friction.iter().zip(levels(result, "stick"));
    Some(peaks.map(|(peak, stick)| peak / stick).collect())
}

/// Returns the times of the events of a kind on a body, s.
pub(super) fn times(result: &LabResult, body: usize, kinds: &[EventKind]) -> Vec<f64> {
    let events =
        result.events.iter().filter(|event| event.body == body && kinds.contains(&event.kind));
    events.map(|event| event.time_s).collect()
}

/// Returns the samples from one time to another.
pub(super) fn rows(result: &LabResult, from_s: f64, to_s: f64) -> &[LabSample] {
    let begin = result.rows.partition_point(|row| row.time_s < from_s);
    let end = result.rows.partition_point(|row| row.time_s <= to_s);
    result.rows.get(begin..end).unwrap_or_default()
}

/// Returns the position of a body at a time, interpolated linearly between samples.
pub(super) fn position(result: &LabResult, body: usize, time_s: f64) -> Option<f64> {
    let after = result.rows.partition_point(|row| row.time_s < time_s).max(1);
    let (a, b) = (result.rows.get(after - 1)?, result.rows.get(after).or(result.rows.last())?);
    let (from, to) = (a.position.get(body)?, b.position.get(body)?);
    let part = if b.time_s > a.time_s { (time_s - a.time_s) / (b.time_s - a.time_s) } else { 0.0 };
    Some(from + part.clamp(0.0, 1.0) * (to - from))
}

/// Returns the largest distance between two runs, relative to the largest excursion of the first,
/// for each body.
pub(super) fn apart(evidence: &ReportEvidence, a: &str, b: &str) -> Option<Vec<f64>> {
    let (a, b) = (evidence.lab(a)?, evidence.lab(b)?);
    let of = |body: usize| {
        let (mut distance, mut excursion) = (0.0, 0.0);
        for row in &a.rows {
            let there = row.position.get(body)?;
            distance = f64::max(distance, (there - position(b, body, row.time_s)?).abs());
            excursion = f64::max(excursion, there.abs());
        }
        Some(distance / excursion)
    };
    (0..a.metrics.breaks.len()).map(of).collect()
}

/// Returns the ratio of the derivative evaluations of two runs, at each eps.
pub(super) fn work(evidence: &ReportEvidence, of: &str, by: &str) -> Option<Vec<f64>> {
    ratios(evidence.evaluations(of), evidence.evaluations(by))
}

/// Returns the largest friction of a body within `within_s` after each stop, relative to its F_d.
pub(super) fn after_stops(
    evidence: &ReportEvidence,
    name: &str,
    within_s: f64,
) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let slip = *levels(result, "slip").first()?;
    let stops = times(result, 0, &[EventKind::Stick, EventKind::Reverse]);
    let peak = |stop_s: f64| {
        let peak = rows(result, stop_s, stop_s + within_s).iter().map(|row| row.friction[0].abs());
        peak.fold(0.0, f64::max) / slip
    };
    Some(stops.into_iter().map(peak).collect())
}

/// Returns the static friction that holds a body at each stop, relative to its F_d; at most F_s.
pub(super) fn held_at_stops(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let (stick, slip) = (*levels(result, "stick").first()?, *levels(result, "slip").first()?);
    let stops = times(result, 0, &[EventKind::Stick, EventKind::Reverse]);
    let held = |stop_s: f64| {
        let row = rows(result, stop_s, f64::INFINITY).first()?;
        Some(row.input[0].abs().min(stick) / slip)
    };
    stops.into_iter().map(held).collect()
}

/// Returns the largest acceleration of each body while all are in their bands.
pub(super) fn accelerations_at_rest(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let resting = || result.rows.iter().filter(|row| row.stuck.iter().all(|stuck| *stuck));
    let of = |body: usize| resting().map(|row| row.acceleration[body].abs()).fold(0.0, f64::max);
    Some((0..result.metrics.breaks.len()).map(of).collect())
}

/// Returns how often each friction changes its side, of the samples with all bodies in their bands
/// and a friction of at least a level (`stick` or `slip`).
pub(super) fn changes_of_side(
    evidence: &ReportEvidence,
    name: &str,
    level: &str,
) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let levels = levels(result, level);
    let resting: Vec<&LabSample> =
        result.rows.iter().filter(|row| row.stuck.iter().all(|stuck| *stuck)).collect();
    let changes = |body: usize| {
        let frictions = resting.iter().map(|row| row.friction[body]);
        let large = frictions.filter(|friction| friction.abs() > 0.99 * levels[body]);
        let sides: Vec<f64> = large.map(f64::signum).collect();
        sides.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64
    };
    Some((0..levels.len()).map(changes).collect())
}

/// Returns the distance of the final positions from those of another run.
pub(super) fn miss(evidence: &ReportEvidence, name: &str, from: &str) -> Option<f64> {
    let (a, b) = (evidence.lab(name)?, evidence.lab(from)?);
    let pairs = a.metrics.final_position.iter().zip(&b.metrics.final_position);
    Some(pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt())
}

/// Returns the time after each stop until a body's friction stays within 5 % of F_s of the force
/// that it holds, relative to the stay at rest; for stays that end within the run.
pub(super) fn swings(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let margin = 0.05 * levels(result, "stick").first()?;
    let (stops, breaks) =
        (times(result, 0, &[EventKind::Stick]), times(result, 0, &[EventKind::Break]));
    let swing = |stop_s: &f64| {
        let break_s = *breaks.iter().find(|break_s| *break_s > stop_s)?;
        let swinging = |row: &&LabSample| (row.friction[0] - row.input[0]).abs() > margin;
        // Without the last hundredth, in which the bristle gives way.
        let stay = rows(result, *stop_s, break_s - 0.01 * (break_s - stop_s));
        let last_s = stay.iter().rev().find(swinging).map_or(*stop_s, |row| row.time_s);
        Some((last_s - stop_s) / (break_s - stop_s))
    };
    let swings: Vec<f64> = stops.iter().filter_map(swing).collect();
    (!swings.is_empty()).then_some(swings)
}

/// Returns how often deflections reverse while their friction sticks, over all bodies.
pub(super) fn reversals_at_rest(evidence: &ReportEvidence, name: &str) -> Option<f64> {
    let result = evidence.lab(name)?;
    let of = |body: usize| {
        let steps =
            result.rows.windows(2).filter(|pair| pair[0].stuck[body] && pair[1].stuck[body]);
        let ways = steps.map(|pair| (pair[1].deflection[body] - pair[0].deflection[body]).signum());
        let ways: Vec<f64> = ways.collect();
        ways.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count() as f64
    };
    Some((0..result.metrics.breaks.len()).map(of).sum())
}
