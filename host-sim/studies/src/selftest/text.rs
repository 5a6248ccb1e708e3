//! Result of a self-test, as text and as JSON.

use serde_json::{Value, json};

use super::measures::{AtLoad, MoveMeasures, SessionFigures};
use super::prediction::Prediction;
use super::verdict::SelfTestCheck;
use crate::ensemble::SortedValues;
use files::data_sheet::UnseenSlack;
use files::goal::PositionGoal;
use files::lines::wrapped;
use simulator::output::grid::{self, number};
use simulator::output::sides;

/// Result of a self-test.
#[derive(Clone, Debug)]
pub struct SelfTestResult {
    /// Name of the machine's file.
    pub machine: String,
    /// Range of the moves to either side, deg.
    pub range_deg: f64,
    /// Keys of the joint that varied.
    pub spreads: Vec<String>,
    /// Seed of the joints.
    pub seed: u64,
    /// Prediction.
    pub prediction: Prediction,
    /// Moves of the device.
    pub moves: Vec<MoveMeasures>,
    /// Figures with their bounds; empty if the device did not complete all moves.
    pub checks: Vec<SelfTestCheck>,
    /// Reason of an early end; `None` if the device completed all moves.
    pub ended_by: Option<String>,
    /// Doubts about the joint of the file, one sentence each.
    pub doubts: Vec<String>,
    /// Differences between the parameters of device and file.
    pub differences: Vec<String>,
    /// Goal by which each move is judged.
    pub goal: PositionGoal,
    /// Slack of the gear that the encoder cannot measure.
    pub unseen_slack: Option<UnseenSlack>,
    /// Angle of a count, deg.
    pub count_deg: f64,
}

impl SelfTestResult {
    /// Returns whether all figures are within their bounds.
    pub fn passes(&self) -> bool {
        self.ended_by.is_none()
            && !self.checks.is_empty()
            && self.checks.iter().all(SelfTestCheck::passes)
    }

    /// Returns a remark on moves that miss the goal if most of the predicted joints miss some. Such
    /// a test passes, although the law does not bring this joint to its targets.
    pub fn misses_as_predicted(&self) -> Option<String> {
        let check = self.checks.iter().find(|check| check.name == "missed_moves")?;
        let [_, median, _] = check.predicted;
        (self.passes() && median > 0.0).then(|| {
            let (missed, moves) = (check.measured.unwrap_or(0.0), self.moves.len());
            if missed > 0.0 {
                format!("{missed:.0} of {moves} moves miss the goal; predicted {median:.0}")
            } else {
                format!("all {moves} moves meet the goal, although {median:.0} were predicted to miss it")
            }
        })
    }

    /// Returns whether every move met the goal at the encoder; `None` without moves.
    pub fn success_at_encoder(&self) -> Option<bool> {
        let all = self.ended_by.is_none() && self.moves.iter().all(MoveMeasures::success);
        (!self.moves.is_empty()).then_some(all)
    }

    /// Returns whether every move met the goal at the load; `None` without moves, or if the device
    /// does not report its load.
    pub fn success_at_load(&self) -> Option<bool> {
        let met = |all: bool, one: &MoveMeasures| one.at_load.map(|load| all && load.success());
        let all = self.moves.iter().try_fold(self.ended_by.is_none(), met)?;
        (!self.moves.is_empty()).then_some(all)
    }

    /// Returns the number of moves that missed the goal, at the encoder and at the load.
    fn missed(&self) -> [Option<u32>; 2] {
        let figures = SessionFigures::of(&self.moves);
        [Some(figures.missed), figures.missed_at_load]
    }

    /// Returns the names of the figures outside their bounds.
    pub fn failed(&self) -> Vec<&'static str> {
        let failed = self.checks.iter().filter(|check| !check.passes());
        failed.map(|check| check.words).collect()
    }
}

/// Returns least, median and largest value of a measure of one move over the predicted joints.
fn predicted(
    prediction: &Prediction,
    number: usize,
    of: impl Fn(&MoveMeasures) -> f64,
) -> Option<[f64; 3]> {
    let all = prediction.moves.iter().filter_map(|moves| moves.get(number)).map(of);
    let sorted = SortedValues::new(all);
    let [least, median] = [0.0, 0.5].map(|share| sorted.quantile(share));
    Some([least?, median?, sorted.max()?])
}

/// Formats a range: both ends, or one if they are written alike. An infinite end is "never".
pub fn ends(ends: [f64; 2], digits: usize, between: &str) -> String {
    let shown = |value: f64| {
        if value.is_finite() { format!("{value:.digits$}") } else { "never".into() }
    };
    let [low, high] = ends.map(shown);
    if low == high { low } else { format!("{low}{between}{high}") }
}

/// Returns the settling time of a move, s; infinite if it does not settle.
pub fn late(one: &MoveMeasures) -> f64 {
    one.settled_s.unwrap_or(f64::INFINITY)
}

/// Returns the settling time of a move at the load, s; infinite if it does not settle or is
/// unknown.
pub fn late_at_load(one: &MoveMeasures) -> f64 {
    one.at_load.and_then(|load| load.settled_s).unwrap_or(f64::INFINITY)
}

/// Returns the largest distance of the load from its target, counts; infinite if unknown.
pub fn rest_at_load(one: &MoveMeasures) -> f64 {
    one.at_load.map_or(f64::INFINITY, |load| load.rest_counts)
}

/// Returns moves, figures and verdict as text within 80 columns.
pub fn words(tested: &SelfTestResult) -> String {
    let mut text = String::new();
    if tested.unseen_slack.is_some() {
        text += "At the encoder:\n";
    }
    let mut moves = grid::new(&[
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
        let range = |of: fn(&MoveMeasures) -> f64, digits: usize| {
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
    if tested.unseen_slack.is_some() {
        text += &format!("At the load:\n{}\n\n", table_at_load(tested));
    }
    if !tested.checks.is_empty() {
        let all = match tested.unseen_slack {
            Some(_) => "all moves, at the encoder",
            None => "all moves",
        };
        let mut figures = grid::new(&[all, "measured", "predicted", "allowed", ""]);
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
    let joints = tested.prediction.figures.len();
    let SelfTestResult { machine, seed, .. } = tested;
    let of = format!("The prediction: {joints} simulated joints of {machine}, seed {seed}, with");
    text += &wrapped(&of, 0);
    tested.spreads.iter().for_each(|spread| text += &format!("  {spread}\n"));
    text += &remarks(tested);
    if tested.unseen_slack.is_some() || !tested.goal.is_default() {
        text += &sides::legend(tested.unseen_slack.as_ref(), &tested.goal);
    }
    text + &format!("selftest   {}\n", sentence(tested).replace('\n', "\n           "))
}

/// Returns the table of settling and rest at the load: predicted, and measured if the device
/// reports its load.
fn table_at_load(tested: &SelfTestResult) -> String {
    let mut moves = grid::new(&[
        "move to\ndeg",
        "settled\ns",
        "predicted\ns",
        "rest\ncounts",
        "predicted\ncounts",
    ]);
    for (place, one) in tested.moves.iter().enumerate() {
        let range = |of: fn(&MoveMeasures) -> f64, digits: usize| {
            let range = predicted(&tested.prediction, place, of);
            range.map_or("-".into(), |[low, _, high]| ends([low, high], digits, "-"))
        };
        let settled = one.at_load.map(|load| load.settled_s);
        moves.add_row([
            format!("{:.3}", one.to_deg),
            settled.map_or("-".into(), |s| s.map_or("never".into(), |s| format!("{s:.2}"))),
            range(late_at_load, 2),
            number(one.at_load.map(|load| load.rest_counts), 0),
            range(rest_at_load, 0),
        ]);
    }
    moves.trim_fmt()
}

/// Returns the verdict with its remarks, on one or more lines.
pub fn sentence(tested: &SelfTestResult) -> String {
    match &tested.ended_by {
        Some(by) => format!("FAIL: ended by {by}"),
        None => {
            let verdict = if tested.passes() {
                "pass: the joint moves as its file predicts".into()
            } else {
                format!("FAIL: {}: not as predicted", tested.failed().join("; "))
            };
            let misses = tested.misses_as_predicted().map(|missed| {
                let advice = match tested.success_at_encoder() {
                    Some(true) => "",
                    _ => ".\nTune this law, or choose another one",
                };
                format!(".\nNote: {missed}{advice}")
            });
            verdict + &misses.unwrap_or_default() + &both_sides(tested)
        }
    }
}

/// Returns sentences with the number of moves that missed the goal at the encoder and at the load;
/// empty unless the gear has slack that the encoder cannot measure.
fn both_sides(tested: &SelfTestResult) -> String {
    if tested.unseen_slack.is_none() {
        return String::new();
    }
    let [at_encoder, at_load] = tested.missed();
    let [_, predicted_at_load] = tested.prediction.missed_of_most();
    let moves = tested.moves.len();
    let count = |missed: Option<u32>| match missed {
        Some(0) => format!("all {moves} moves met the goal"),
        Some(missed) => format!("{missed} of {moves} moves missed the goal"),
        None => "not measured".into(),
    };
    let predicted = predicted_at_load
        .map_or_else(String::new, |missed| format!(" (predicted: {missed} of {moves} missed)"));
    format!(".\nAt the encoder: {}.\nAt the load: {}{predicted}", count(at_encoder), count(at_load))
}

fn remarks(tested: &SelfTestResult) -> String {
    let mut text = String::new();
    if let Some(first) = tested.prediction.ended.first() {
        let count = tested.prediction.ended.len();
        text += &format!("{count} more simulated joints ended early, the first by {first}\n");
    }
    if !tested.differences.is_empty() {
        text +=
            "The device runs other parameters than the file; the prediction uses the device's:\n";
        let shown = tested.differences.iter().take(8);
        shown.for_each(|line| text += &format!("  {line}\n"));
        let more = tested.differences.len().saturating_sub(8);
        if more > 0 {
            text += &format!("  and {more} more (`params push FILE.toml` makes them the same)\n");
        }
    }
    text
}

/// Returns the JSON object for scripts.
pub fn object(tested: &SelfTestResult, warning: Option<&str>) -> Value {
    let three = |[low, median, high]: [f64; 3]| {
        let value = |value: f64| value.is_finite().then_some(value);
        json!({"least": value(low), "median": value(median), "largest": value(high)})
    };
    let [missed_at_encoder, missed_at_load] = tested.missed();
    let [_, predicted_at_load] = tested.prediction.missed_of_most();
    let moves = tested.moves.iter().enumerate().map(|(place, one)| {
        let load = |of: fn(&MoveMeasures) -> f64| {
            let known = tested.prediction.figures.iter().all(|one| one.missed_at_load.is_some());
            predicted(&tested.prediction, place, of).filter(|_| known).map(three)
        };
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
            "success_at_encoder": one.success(),
            "success_at_load": one.at_load.as_ref().map(AtLoad::success),
            "settled_at_encoder_s": one.settled_s,
            "settled_at_load_s": one.at_load.and_then(|load| load.settled_s),
            "rest_at_encoder_counts": one.rest_counts,
            "rest_at_load_counts": one.at_load.map(|load| load.rest_counts),
            "predicted_settled_at_load_s": load(late_at_load),
            "predicted_rest_at_load_counts": load(rest_at_load),
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
        "goal": tested.goal.in_both_units(tested.count_deg),
        "unseen_slack": tested.unseen_slack,
        "success_at_encoder": tested.success_at_encoder(),
        "success_at_load": tested.success_at_load(),
        "missed_at_encoder": missed_at_encoder,
        "missed_at_load": missed_at_load,
        "predicted_missed_at_load": predicted_at_load,
        "doubts": tested.doubts,
        "differences": tested.differences,
        "checks": checks.collect::<Vec<_>>(),
        "moves": moves.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::measures::{Mean, SessionFigures};
    use super::super::verdict::verdict;
    use super::*;

    fn moved(to_deg: f64, settled_s: Option<f64>) -> MoveMeasures {
        MoveMeasures {
            to_deg,
            settled_s,
            rest_counts: 150.0,
            held_v: 0.123,
            sliding_v: Mean::of(0.456),
            ..MoveMeasures::default()
        }
    }

    /// Returns the result of a session of four moves, none of which settles. On the three predicted
    /// joints, the second move settles after the given times, and the other moves never settle.
    fn tested(settled_s: [Option<f64>; 3]) -> SelfTestResult {
        let session = |second| {
            let to = [-123.456, 0.2, 0.4, 0.0];
            to.map(|to| moved(to, if to == 0.2 { second } else { None })).to_vec()
        };
        let moves = settled_s.map(session).to_vec();
        let figures = moves.iter().map(|moves| SessionFigures::of(moves)).collect();
        let prediction = Prediction { figures, moves, ended: vec![] };
        let moves = session(None);
        SelfTestResult {
            machine: "joint.toml".into(),
            range_deg: 130.0,
            spreads: vec![],
            seed: 1,
            checks: verdict(&SessionFigures::of(&moves), &prediction),
            prediction,
            moves,
            ended_by: None,
            doubts: vec![],
            differences: vec![],
            goal: PositionGoal::default(),
            unseen_slack: None,
            count_deg: 0.01,
        }
    }

    #[test]
    fn a_range_with_equal_ends_is_printed_once_and_no_row_of_the_moves_is_broken() {
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
        // No move settles on any joint, so there is no check of the mean settling time.
        assert!(missing.passes(), "{:?}", missing.checks);
        let text = words(&missing);
        let said = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            said.ends_with(
                "moves as its file predicts. Note: 4 of 4 moves miss the goal; predicted 4. Tune \
                 this law, or choose another one"
            ),
            "{said}"
        );
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        // The device does better than most of the predicted joints.
        let mut better = missing.clone();
        better.moves.iter_mut().for_each(|one| one.settled_s = Some(0.2));
        better.checks[0].measured = Some(0.0);
        let remark = better.misses_as_predicted().unwrap();
        assert_eq!(remark, "all 4 moves meet the goal, although 4 were predicted to miss it");
        assert!(!words(&better).contains("Tune"), "{}", words(&better));
        let mut settling = missing;
        settling.checks[0].predicted = [0.0, 0.0, 4.0];
        let text = words(&settling);
        assert!(text.ends_with("the joint moves as its file predicts\n"), "{text}");
    }
    const SLACK: UnseenSlack =
        UnseenSlack { backlash_deg: 0.6, backlash_counts: 60.0, wind_up_deg: 0.01 };

    /// Returns the result of a joint whose encoder's side settles in each move, and whose load
    /// never settles.
    fn with_slack() -> SelfTestResult {
        let load = AtLoad { rest_counts: 31.0, ..AtLoad::default() };
        let mut tested = tested([Some(0.2); 3]);
        let settle = |one: &mut MoveMeasures| {
            (one.settled_s, one.rest_counts, one.at_load) = (Some(0.2), 1.0, Some(load));
        };
        tested.prediction.moves.iter_mut().flatten().for_each(settle);
        let moves = &tested.prediction.moves;
        tested.prediction.figures = moves.iter().map(|moves| SessionFigures::of(moves)).collect();
        tested.moves.iter_mut().for_each(settle);
        tested.checks = verdict(&SessionFigures::of(&tested.moves), &tested.prediction);
        SelfTestResult { unseen_slack: Some(SLACK), ..tested }
    }

    #[test]
    fn both_sides_of_a_gear_with_unseen_slack_are_named_and_the_slack_once() {
        let tested = with_slack();
        let text = words(&tested);
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let said = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(said.matches("cannot see 60 counts of backlash").count(), 1, "{text}");
        assert!(said.contains("At the encoder: all 4 moves met the goal."), "{text}");
        let load = "At the load: 4 of 4 moves missed the goal (predicted: 4 of 4 missed)";
        assert!(said.ends_with(load), "{text}");
        let json = object(&tested, None);
        assert_eq!(
            (&json["success_at_encoder"], &json["success_at_load"]),
            (&true.into(), &false.into())
        );
        assert_eq!(json["predicted_missed_at_load"], 4);
        assert_eq!(json["moves"][0]["predicted_rest_at_load_counts"]["median"], 31.0);
        // A board measures only its encoder; the prediction has the load in any case.
        let mut board = tested;
        board.moves.iter_mut().for_each(|one| one.at_load = None);
        let text = words(&board);
        assert!(text.contains("At the load: not measured (predicted: 4 of 4 missed)"), "{text}");
        let json = object(&board, None);
        assert!(json["success_at_load"].is_null() && json["unseen_slack"].is_object(), "{json}");
        // A joint whose encoder sees the load has one side.
        let text = words(&SelfTestResult { unseen_slack: None, ..board });
        assert!(!text.contains("the load") && !text.contains("the encoder"), "{text}");
    }
}
