//! A self-test for a person, and for a script.

use serde_json::{Value, json};

use super::measures::Measures;
use super::prediction::Prediction;
use super::verdict::Check;
use crate::ensemble::Sorted;
use crate::output::table::{self, number};

/// A self-test that is over.
#[derive(Clone, Debug)]
pub struct Tested {
    /// The machine's file.
    pub machine: String,
    /// Range of the moves to either side, deg.
    pub range_deg: f64,
    /// Keys of the joint that varied.
    pub spreads: Vec<String>,
    /// The seed of the joints.
    pub seed: u64,
    /// What was predicted.
    pub prediction: Prediction,
    /// The moves that the device made.
    pub moves: Vec<Measures>,
    /// The figures with their bounds; empty if the device did not make all moves.
    pub checks: Vec<Check>,
    /// What ended the moves before.
    pub ended_by: Option<String>,
    /// In what the device's parameters differ from the file's.
    pub differences: Vec<String>,
}

impl Tested {
    /// Tells whether the joint does what was predicted.
    pub fn passes(&self) -> bool {
        self.ended_by.is_none() && !self.checks.is_empty() && self.checks.iter().all(Check::passes)
    }

    /// The names of the figures that are out of their bounds.
    pub fn failed(&self) -> Vec<&'static str> {
        let failed = self.checks.iter().filter(|check| !check.passes());
        failed.map(|check| check.words).collect()
    }
}

/// The range of a measure of one move over the predicted joints: least, median, largest.
fn predicted(
    prediction: &Prediction,
    number: usize,
    of: impl Fn(&Measures) -> f64,
) -> Option<[f64; 3]> {
    let all = prediction.moves.iter().filter_map(|moves| moves.get(number)).map(of);
    let sorted = Sorted::new(all);
    let [least, median] = [0.0, 0.5].map(|share| sorted.quantile(share));
    Some([least?, median?, sorted.max()?])
}

fn late(one: &Measures) -> f64 {
    one.settled_s.unwrap_or(f64::INFINITY)
}

/// Writes moves, figures and verdict within 80 columns.
pub fn words(tested: &Tested) -> String {
    let mut text = String::new();
    let mut moves = table::new(&[
        "move to\ndeg",
        "settled\ns",
        "predicted\ns",
        "rest\ncounts",
        "predicted\ncounts",
        "rever-\nsals",
        "stops",
        "sliding\nV",
        "held\nV",
    ]);
    for (place, one) in tested.moves.iter().enumerate() {
        let range = |of: fn(&Measures) -> f64, digits: usize| {
            let shown = |value: f64| {
                if value.is_finite() { format!("{value:.digits$}") } else { "never".into() }
            };
            let range = predicted(&tested.prediction, place, of);
            range.map_or("-".into(), |[low, _, high]| format!("{}-{}", shown(low), shown(high)))
        };
        moves.add_row([
            format!("{:.3}", one.to_deg),
            one.settled_s.map_or_else(|| "never".into(), |s| format!("{s:.2}")),
            range(late, 2),
            number(Some(one.rest_counts), 0),
            range(|of| of.rest_counts, 0),
            one.reversals.to_string(),
            one.sticks.to_string(),
            number(one.sliding_v.value(), 3),
            number(Some(one.held_v), 3),
        ]);
    }
    text += &format!("{}\n\n", moves.trim_fmt());
    if !tested.checks.is_empty() {
        let mut figures = table::new(&["all moves", "measured", "predicted", "allowed", ""]);
        for check in &tested.checks {
            let digits =
                if check.name.ends_with("_v") || check.name.ends_with("_s") { 3 } else { 0 };
            let [low, _, high] = check.predicted;
            let allowed = match check.least {
                Some(least) => format!("{least:.digits$}-{:.digits$}", check.most),
                None => format!("up to {:.digits$}", check.most),
            };
            figures.add_row([
                check.words.into(),
                number(check.measured, digits),
                format!("{low:.digits$}-{high:.digits$}"),
                allowed,
                if check.passes() { "pass" } else { "FAIL" }.into(),
            ]);
        }
        text += &format!("{}\n\n", figures.trim_fmt());
    }
    text += &format!(
        "The prediction: {} simulated joints of {}, seed {}, with\n",
        tested.prediction.figures.len(),
        tested.machine,
        tested.seed
    );
    tested.spreads.iter().for_each(|spread| text += &format!("  {spread}\n"));
    text += &remarks(tested);
    text + &match &tested.ended_by {
        Some(by) => format!("selftest   FAIL: ended by {by}\n"),
        None if tested.passes() => "selftest   pass: the joint does what its file says\n".into(),
        None => format!("selftest   FAIL: {}\n", tested.failed().join("; ")),
    }
}

fn remarks(tested: &Tested) -> String {
    let mut text = String::new();
    if let Some(first) = tested.prediction.ended.first() {
        let count = tested.prediction.ended.len();
        text += &format!("{count} more ended before, the first by {first}\n");
    }
    if !tested.differences.is_empty() {
        text +=
            "The device does not run what the file says, and the prediction is of the device's:\n";
        let shown = tested.differences.iter().take(8);
        shown.for_each(|line| text += &format!("  {line}\n"));
        let more = tested.differences.len().saturating_sub(8);
        if more > 0 {
            text += &format!("  and {more} more (`params push FILE.toml` makes them the same)\n");
        }
    }
    text
}

/// The same as one object.
pub fn object(tested: &Tested, warning: Option<&str>) -> Value {
    let three = |[low, median, high]: [f64; 3]| {
        let value = |value: f64| value.is_finite().then_some(value);
        json!({"least": value(low), "median": value(median), "largest": value(high)})
    };
    let moves = tested.moves.iter().enumerate().map(|(place, one)| {
        json!({
            "to_deg": one.to_deg,
            "settled_s": one.settled_s,
            "rest_counts": one.rest_counts,
            "reversals": one.reversals,
            "sticks_in_motion": one.sticks,
            "held_v": one.held_v,
            "sliding_v": one.sliding_v.value(),
            "accelerating_v": one.accelerating_v.value(),
            "predicted_settled_s": predicted(&tested.prediction, place, late).map(three),
            "predicted_rest_counts":
                predicted(&tested.prediction, place, |of| of.rest_counts).map(three),
        })
    });
    let checks = tested.checks.iter().map(|check| {
        json!({
            "name": check.name,
            "measured": check.measured,
            "predicted": three(check.predicted),
            "least": check.least,
            "most": check.most,
            "pass": check.passes(),
        })
    });
    json!({
        "schema": 1,
        "warning": warning,
        "machine": tested.machine,
        "verdict": if tested.passes() { "pass" } else { "fail" },
        "ended_by": tested.ended_by,
        "range_deg": tested.range_deg,
        "seed": tested.seed,
        "spread": tested.spreads,
        "joints": tested.prediction.figures.len(),
        "joints_ended_before": tested.prediction.ended,
        "differences": tested.differences,
        "checks": checks.collect::<Vec<_>>(),
        "moves": moves.collect::<Vec<_>>(),
    })
}
