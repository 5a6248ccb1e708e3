//! Readings of the friction lab's runs.

use super::ratios;
use crate::lab::{LabResult, LabSample};
use crate::report::evidence::Evidence;
use crate::solver::EventKind;

/// F_s or F_d of each body, N or N m.
pub(super) fn levels(result: &LabResult, of: &str) -> Vec<f64> {
    let table = &result.plan.parameters["friction"];
    let levels = table[format!("{of}_n")].as_array().or(table[format!("{of}_nm")].as_array());
    levels.into_iter().flatten().filter_map(|level| level.as_f64()).collect()
}

/// Largest friction of each body less its F_s, N or N m.
pub(super) fn excess(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let peaks = result.metrics.peak_friction.iter().zip(levels(result, "stick"));
    Some(peaks.map(|(peak, stick)| peak - stick).collect())
}

/// Largest friction of each body by its F_s.
pub(super) fn peaks(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let peaks = result.metrics.peak_friction.iter().zip(levels(result, "stick"));
    Some(peaks.map(|(peak, stick)| peak / stick).collect())
}

/// When the events of a kind happen to a body, s.
pub(super) fn times(result: &LabResult, body: usize, kinds: &[EventKind]) -> Vec<f64> {
    let events =
        result.events.iter().filter(|event| event.body == body && kinds.contains(&event.kind));
    events.map(|event| event.time_s).collect()
}

/// The samples from one time to another.
pub(super) fn rows(result: &LabResult, from_s: f64, to_s: f64) -> &[LabSample] {
    let begin = result.rows.partition_point(|row| row.time_s < from_s);
    let end = result.rows.partition_point(|row| row.time_s <= to_s);
    result.rows.get(begin..end).unwrap_or_default()
}

/// Position of a body at a time, straight between samples.
pub(super) fn position(result: &LabResult, body: usize, time_s: f64) -> Option<f64> {
    let after = result.rows.partition_point(|row| row.time_s < time_s).max(1);
    let (a, b) = (result.rows.get(after - 1)?, result.rows.get(after).or(result.rows.last())?);
    let (from, to) = (a.position.get(body)?, b.position.get(body)?);
    let part = if b.time_s > a.time_s { (time_s - a.time_s) / (b.time_s - a.time_s) } else { 0.0 };
    Some(from + part.clamp(0.0, 1.0) * (to - from))
}

/// Largest distance between two runs by the largest excursion of the first, for each body.
pub(super) fn apart(evidence: &Evidence, a: &str, b: &str) -> Option<Vec<f64>> {
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

/// Derivative evaluations of one run by those of another, at each eps.
pub(super) fn work(evidence: &Evidence, of: &str, by: &str) -> Option<Vec<f64>> {
    ratios(evidence.evaluations(of), evidence.evaluations(by))
}

/// Largest friction of a body within `within_s` after each of its stops, by its F_d.
pub(super) fn after_stops(evidence: &Evidence, name: &str, within_s: f64) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let slip = *levels(result, "slip").first()?;
    let stops = times(result, 0, &[EventKind::Stick, EventKind::Reverse]);
    let peak = |stop_s: f64| {
        let peak = rows(result, stop_s, stop_s + within_s).iter().map(|row| row.friction[0].abs());
        peak.fold(0.0, f64::max) / slip
    };
    Some(stops.into_iter().map(peak).collect())
}

/// What static friction has to be at each stop of a body to hold it, by its F_d; F_s at most.
pub(super) fn held_at_stops(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let (stick, slip) = (*levels(result, "stick").first()?, *levels(result, "slip").first()?);
    let stops = times(result, 0, &[EventKind::Stick, EventKind::Reverse]);
    let held = |stop_s: f64| {
        let row = rows(result, stop_s, f64::INFINITY).first()?;
        Some(row.input[0].abs().min(stick) / slip)
    };
    stops.into_iter().map(held).collect()
}

/// Largest acceleration of each body while all are in their bands.
pub(super) fn accelerations_at_rest(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let resting = || result.rows.iter().filter(|row| row.stuck.iter().all(|stuck| *stuck));
    let of = |body: usize| resting().map(|row| row.acceleration[body].abs()).fold(0.0, f64::max);
    Some((0..result.metrics.breaks.len()).map(of).collect())
}

/// How often each friction is found on its other side, of the samples in which all bodies are in
/// their bands and it has the size of a level (`stick` or `slip`) at least.
pub(super) fn changes_of_side(evidence: &Evidence, name: &str, level: &str) -> Option<Vec<f64>> {
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

/// Distance of the final positions from those of another run.
pub(super) fn miss(evidence: &Evidence, name: &str, from: &str) -> Option<f64> {
    let (a, b) = (evidence.lab(name)?, evidence.lab(from)?);
    let pairs = a.metrics.final_position.iter().zip(&b.metrics.final_position);
    Some(pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt())
}

/// How long a body's friction swings after each stop, until it stays within 5 % of F_s of the force
/// that it holds, as a part of the stay at rest; of stays that end within the run.
pub(super) fn swings(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
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

/// How often deflections turn around while their friction sticks, over all bodies.
pub(super) fn reversals_at_rest(evidence: &Evidence, name: &str) -> Option<f64> {
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
