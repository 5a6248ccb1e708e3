//! Common parts of all figures of runs: the name of the file, the styles of curves, the time axis,
//! and whether both sides of the gear are drawn.

use super::{Figure, Style};
use simulator::closed_loop::LoopSample;
use simulator::run::{RunResult, RunTrace};

/// The roles of the curves that are compared in one panel; no more can be distinguished in print.
pub(super) const COMPARED: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// A motion is over when joint and reference stay within this share of their span.
const STILL: f64 = 0.002;

/// Length of the time axis, as a multiple of the duration of the motion.
const AFTERWARDS: f64 = 1.25;

/// Difference between the sides of a gear, counts. If it is always smaller, they are one line.
const ONE_LINE: f64 = 2.0;

/// A figure and the name of its file, without an ending.
#[derive(Clone, Debug)]
pub struct NamedFigure {
    /// Name of the file, such as `step-response-srnf-steps`.
    pub stem: String,
    /// The figure.
    pub figure: Figure,
}

/// Returns the end of the time axis, s: a little after the last of the motions is over.
pub(super) fn shown_until(results: &[&RunResult]) -> f64 {
    let ends = results.iter().filter_map(|result| {
        let (RunTrace::Loop(moments), Some(last_s)) = (&result.trace, last_time(result)) else {
            return None;
        };
        let last = moments.last()?;
        let span = STILL * moments.iter().map(|m| m.position_deg.abs()).fold(0.0, f64::max);
        let moves = |m: &&LoopSample| {
            (m.position_deg - last.position_deg).abs() > span
                || (m.reference_deg - last.reference_deg).abs() > span
        };
        let over_s = moments.iter().rev().find(moves).map_or(0.0, |m| m.time_s);
        // To the next half of a second, so that the axis has a round end.
        Some(((2.0 * AFTERWARDS * over_s).ceil() / 2.0).max(0.5).min(last_s))
    });
    ends.fold(0.0, f64::max)
}

pub(super) fn last_time(result: &RunResult) -> Option<f64> {
    match &result.trace {
        RunTrace::Loop(moments) | RunTrace::Ramp(moments) => moments.last().map(|m| m.time_s),
    }
}

/// Returns the description of a built-in variant; another variant keeps its name.
pub(super) fn in_words(slug: &str) -> String {
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

/// Returns whether the sides of the gear are ever two counts apart.
pub(super) fn sides_differ(result: &RunResult) -> bool {
    let least_deg = ONE_LINE * result.plan.machine.count_deg();
    let (RunTrace::Loop(moments) | RunTrace::Ramp(moments)) = &result.trace;
    moments.iter().any(|m| (m.at_load_deg - m.at_encoder_deg).abs() >= least_deg)
}
