//! JSON, CSV and table of friction runs.

use std::borrow::Cow;

use super::run::LabResult;
use files::setup::name_of;
use friction_lab::solver::state::BodyEvent;
use simulator::output::json::{EventRecord, RunCost, RunRecord, object};

/// The JSON of `stiction run`, indented.
///
/// # Errors
/// If a number cannot be written as JSON.
pub fn json(experiment: &str, source: &str, results: &[LabResult]) -> serde_json::Result<String> {
    let runs = results.iter().map(|result| RunRecord {
        label: &result.plan.label,
        parameters: Cow::Borrowed(&result.plan.parameters),
        supply: None,
        events: result
            .events
            .iter()
            .map(|event| EventRecord {
                time_s: event.time_s,
                body: event.body + 1,
                kind: event.kind,
            })
            .collect(),
        goal: None,
        metrics: &result.metrics,
        cost: RunCost {
            wall_s: result.wall.as_secs_f64(),
            derivative_evaluations: result.evaluations,
        },
        unstable: result.diverged_at_s.is_some(),
        diverged_at_s: result.diverged_at_s,
        fault: None,
    });
    object(experiment, source, runs.collect())
}

/// The samples of all runs; of several runs, each line begins with its run's label.
///
/// # Errors
/// If a number cannot be written.
pub fn csv(results: &[LabResult]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let labelled = results.len() > 1;
    let Some(first) = results.first() else { return Ok(Vec::new()) };
    let (length, force) =
        if first.plan.setup.mechanism.kind.turns() { ("rad", "nm") } else { ("m", "n") };
    let mut header = if labelled { vec!["label".to_owned()] } else { vec![] };
    header.push("time_s".into());
    for body in 1..=first.plan.bodies() {
        header.extend([
            format!("position_{body}_{length}"),
            format!("velocity_{body}_{length}_per_s"),
            format!("acceleration_{body}_{length}_per_s2"),
            format!("input_{body}_{force}"),
            format!("friction_{body}_{force}"),
            format!("deflection_{body}_{length}"),
            format!("stuck_{body}"),
        ]);
    }
    writer.write_record(&header)?;
    for result in results {
        for row in &result.rows {
            let mut record = if labelled { vec![result.plan.label.clone()] } else { vec![] };
            record.push(row.time_s.to_string());
            for i in 0..row.position.len() {
                let columns = [
                    &row.position,
                    &row.velocity,
                    &row.acceleration,
                    &row.input,
                    &row.friction,
                    &row.deflection,
                ];
                record.extend(columns.map(|column| column[i].to_string()));
                record.push(row.stuck[i].to_string());
            }
            writer.write_record(&record)?;
        }
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// Lines of events that a table has room for, and events in each.
const EVENT_LINES: usize = 5;
const EVENTS_A_LINE: usize = 3;

/// A table for people: a paragraph a run, a line a body, and the first events.
pub fn table(results: &[LabResult]) -> String {
    let mut text = String::new();
    for result in results {
        let turns = result.plan.setup.mechanism.kind.turns();
        let (length, force) = if turns { ("rad", "N m") } else { ("m", "N") };
        let ms = 1e3 * result.wall.as_secs_f64();
        text += &format!("{}: {} evaluations, {ms:.3} ms\n", result.plan.label, result.evaluations);
        let (speed, friction) = (format!("fastest {length}/s"), format!("friction up to {force}"));
        text += &format!(
            "  body {:>14} {speed:>15} {friction:>20}  breakaways\n",
            format!("ends at {length}")
        );
        let metrics = &result.metrics;
        for (i, position) in metrics.final_position.iter().enumerate() {
            let columns = [*position, metrics.max_speed[i], metrics.peak_friction[i]].map(digits);
            let [position, speed, friction] = columns;
            let breaks = metrics.breaks[i];
            text +=
                &format!("  {:4} {position:>14} {speed:>15} {friction:>20}  {breaks:10}\n", i + 1);
        }
        text += &events(&result.events);
        if let Some(time_s) = result.diverged_at_s {
            text += &format!("  diverged, not finite at {time_s} s; the run ends there\n");
        }
        text += "\n";
    }
    text
}

/// Time, body and kind of the first events, several a line.
fn events(events: &[BodyEvent]) -> String {
    let shown = &events[..events.len().min(EVENT_LINES * EVENTS_A_LINE)];
    let mut text = String::new();
    for (line, some) in shown.chunks(EVENTS_A_LINE).enumerate() {
        text += if line == 0 { "  at s  " } else { "        " };
        for event in some {
            let kind = name_of(&event.kind);
            text += &format!("{:>11.6}  {} {kind:<7}", event.time_s, event.body + 1);
        }
        text = text.trim_end().to_owned() + "\n";
    }
    match events.len() - shown.len() {
        0 => text,
        more => text + &format!("        \u{2026} and {more} more, --json has all\n"),
    }
}

/// Six significant digits, whatever the size.
fn digits(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number:.1}");
    }
    if (1e-3..1e5).contains(&number.abs()) {
        let decimals = (5 - number.abs().log10().floor() as i32).max(0) as usize;
        format!("{number:.decimals$}")
    } else {
        format!("{number:.5e}")
    }
}
