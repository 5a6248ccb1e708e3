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
    /// What there is to doubt about the joint of the file, a sentence each.
    pub doubts: Vec<String>,
    /// In what the device's parameters differ from the file's.
    pub differences: Vec<String>,
}

impl Tested {
    /// Tells whether the joint does what was predicted.
    pub fn passes(&self) -> bool {
        self.ended_by.is_none() && !self.checks.is_empty() && self.checks.iter().all(Check::passes)
    }

    /// Says how many moves do not settle if it is no more than what is predicted of most joints.
    /// Such a test passes, and tells that the law is no good for this joint.
    pub fn misses_as_predicted(&self) -> Option<String> {
        let check = self.checks.iter().find(|check| check.name == "missed_moves")?;
        let [_, median, _] = check.predicted;
        (self.passes() && median > 0.0).then(|| {
            let missed = check.measured.unwrap_or(0.0);
            format!(
                "{missed:.0} of {} moves do not settle; predicted {median:.0}",
                self.moves.len()
            )
        })
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

/// A range in words: both ends, or one if they are written alike; what is infinite never comes.
pub fn ends(ends: [f64; 2], digits: usize, between: &str) -> String {
    let shown = |value: f64| {
        if value.is_finite() { format!("{value:.digits$}") } else { "never".into() }
    };
    let [low, high] = ends.map(shown);
    if low == high { low } else { format!("{low}{between}{high}") }
}

/// When a move settled, s; what never does takes infinitely long.
pub fn late(one: &Measures) -> f64 {
    one.settled_s.unwrap_or(f64::INFINITY)
}

/// Writes moves, figures and verdict within 80 columns.
pub fn words(tested: &Tested) -> String {
    let mut text = String::new();
    let mut moves = table::new(&[
        "move to\ndeg",
        "set-\ntled\ns",
        "pre-\ndicted\ns",
        "rest\ncounts",
        "pre-\ndicted\ncounts",
        "rever-\nsals",
        "stops",
        "sliding\nV",
        "held\nV",
    ]);
    for (place, one) in tested.moves.iter().enumerate() {
        let range = |of: fn(&Measures) -> f64, digits: usize| {
            let range = predicted(&tested.prediction, place, of);
            range.map_or("-".into(), |[low, _, high]| ends([low, high], digits, "-"))
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
            let digits = check.digits();
            let [low, _, high] = check.predicted;
            let allowed = match check.least {
                Some(least) => format!("{least:.digits$}-{:.digits$}", check.most),
                None => format!("up to {:.digits$}", check.most),
            };
            figures.add_row([
                check.words.into(),
                number(check.measured, digits),
                ends([low, high], digits, "-"),
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
    text + &format!("selftest   {}\n", sentence(tested).replace('\n', "\n           "))
}

/// The verdict in words, a line each.
pub fn sentence(tested: &Tested) -> String {
    match &tested.ended_by {
        Some(by) => format!("FAIL: ended by {by}"),
        None if tested.passes() => {
            let also = tested.misses_as_predicted().map_or(String::new(), |missed| {
                format!(
                    ", and that is to MISS:\n{missed}.\n\
                     The law is no good for this joint: tune it, or take another one"
                )
            });
            format!("pass: the joint does what its file says{also}")
        }
        None => format!("FAIL: {}", tested.failed().join("; ")),
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
        "remark": tested.misses_as_predicted(),
        "ended_by": tested.ended_by,
        "range_deg": tested.range_deg,
        "seed": tested.seed,
        "spread": tested.spreads,
        "joints": tested.prediction.figures.len(),
        "joints_ended_before": tested.prediction.ended,
        "doubts": tested.doubts,
        "differences": tested.differences,
        "checks": checks.collect::<Vec<_>>(),
        "moves": moves.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::measures::{Figures, Mean};
    use super::super::verdict::verdict;
    use super::*;

    fn moved(to_deg: f64, settled_s: Option<f64>) -> Measures {
        Measures {
            to_deg,
            settled_s,
            rest_counts: 150.0,
            held_v: 0.123,
            sliding_v: Mean::of(0.456),
            ..Measures::default()
        }
    }

    /// A session of four moves as it was predicted: the second settles on one joint of three, and
    /// the others on none.
    fn tested(settled_s: [Option<f64>; 3]) -> Tested {
        let session = |second| {
            let to = [-123.456, 0.2, 0.4, 0.0];
            to.map(|to| moved(to, if to == 0.2 { second } else { None })).to_vec()
        };
        let moves = settled_s.map(session).to_vec();
        let figures = moves.iter().map(|moves| Figures::of(moves)).collect();
        let prediction = Prediction { figures, moves, ended: vec![] };
        let moves = session(None);
        Tested {
            machine: "joint.toml".into(),
            range_deg: 130.0,
            spreads: vec![],
            seed: 1,
            checks: verdict(&Figures::of(&moves), &prediction),
            prediction,
            moves,
            ended_by: None,
            doubts: vec![],
            differences: vec![],
        }
    }

    #[test]
    fn a_range_with_one_end_is_told_once_and_no_row_of_the_moves_is_broken() {
        assert_eq!(ends([0.101, 0.104], 2, "-"), "0.10");
        assert_eq!(ends([0.1, f64::INFINITY], 2, " to "), "0.10 to never");
        let text = words(&tested([None; 3]));
        let row = text.lines().find(|line| line.trim_start().starts_with("-123.456")).unwrap();
        assert_eq!(row.split_whitespace().nth(2), Some("never"), "{text}");
        let text = words(&tested([Some(12.34), None, None]));
        let row = text.lines().find(|line| line.trim_start().starts_with("0.200")).unwrap();
        assert_eq!(row.split_whitespace().nth(2), Some("12.34-never"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }

    #[test]
    fn a_pass_of_a_law_that_misses_says_so() {
        let missing = tested([None; 3]);
        // Nothing settles on any joint, so the mean time of settling is none that could fail.
        assert!(missing.passes(), "{:?}", missing.checks);
        let text = words(&missing);
        assert!(
            text.contains("that is to MISS:\n           4 of 4 moves do not settle; predicted 4."),
            "{text}"
        );
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let mut settling = missing;
        settling.checks[0].predicted = [0.0, 0.0, 4.0];
        let text = words(&settling);
        assert!(text.ends_with("the joint does what its file says\n"), "{text}");
    }
}
