//! Which of the gains of a search stand the judgement, on joints that they were not found on.
//!
//! Gains pass if they cost less than the file's and no more joints fail. Of those that pass, the
//! first by which no joint is lost stays: none that succeeds with the file's gains fails with the
//! new ones. Joints are compared one by one, each with its delay, since a count of failures lets
//! gains trade a joint that they save for one that they lose. If each loses a joint, the first that
//! passes stays: docs/how-to/tune.md says what it costs to ask for more. Candidates are judged in
//! the order of their costs in the search, and [`CANDIDATES`] at most.

use super::figures::{TuningFigures, TuningGoal, is_fine};
use crate::ensemble::CaseResult;
use files::error::Error;

/// Candidates that are judged at most.
pub(super) const CANDIDATES: usize = 5;

/// Gains that were tried, as factors, with what they cost more than the file's on the joints of the
/// search.
pub(super) type Tried = (f64, Vec<f64>);

/// Gains that passed: their values by key and their factors, with the rows of their joints.
pub(super) struct Passed {
    pub factors: Vec<f64>,
    pub set: Vec<(String, f64)>,
    pub rows: Vec<CaseResult>,
}

/// What a judgement comes to.
pub(super) enum Outcome {
    /// It was cancelled.
    Cancelled,
    /// The gains that passed, if any did.
    Judged(Option<Passed>),
}

/// Looks for the first of the candidates that passes: `set` makes keys of factors, and `rows` runs
/// them on the joints of the judgement, in the order of `before`. It is cancelled if that returns
/// no rows.
///
/// # Errors
/// That of `rows`.
pub(super) fn first(
    mut tried: Vec<Tried>,
    before: &[CaseResult],
    (goal, limits): (TuningGoal, &[(String, f64)]),
    set: impl Fn(&[f64]) -> Vec<(String, f64)>,
    rows: impl Fn(&[(String, f64)]) -> Result<Option<Vec<CaseResult>>, Error>,
) -> Result<Outcome, Error> {
    tried.retain(|(cost, _)| *cost < 0.0);
    tried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut candidates: Vec<_> =
        tried.into_iter().map(|(_, factors)| (set(&factors), factors)).collect();
    candidates.dedup_by(|(a, _), (b, _)| a == b);
    let start = TuningFigures::of(before);
    let mut second = None;
    for (set, factors) in candidates.into_iter().take(CANDIDATES) {
        let Some(rows) = rows(&set)? else { return Ok(Outcome::Cancelled) };
        if !TuningFigures::of(&rows).are_better_than(&start, goal, limits) {
            continue;
        }
        let is_lost = loses(before, &rows);
        let passed = Some(Passed { factors, set, rows });
        if !is_lost {
            return Ok(Outcome::Judged(passed));
        }
        second = second.or(passed);
    }
    Ok(Outcome::Judged(second))
}

/// Whether a joint fails that did not.
fn loses(before: &[CaseResult], after: &[CaseResult]) -> bool {
    before.iter().zip(after).any(|(was, is)| is_fine(was) && !is_fine(is))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(settled_s: [f64; 3]) -> Vec<CaseResult> {
        let row = |settled_s: f64| CaseResult {
            settled_at_encoder_s: Some(settled_s).filter(|s| s.is_finite()),
            success_at_encoder: settled_s <= 5.0,
            count: 0.001,
            ..CaseResult::default()
        };
        settled_s.map(row).to_vec()
    }

    fn judged(tried: &[(f64, f64)], after: impl Fn(&str) -> [f64; 3]) -> Option<String> {
        let never = f64::INFINITY;
        let before = rows([2.0, 2.0, never]);
        let tried = tried.iter().map(|(cost, factor)| (*cost, vec![*factor])).collect();
        let set = |factors: &[f64]| vec![(format!("{:?}", factors[0]), factors[0])];
        let run = |set: &[(String, f64)]| Ok(Some(rows(after(&set[0].0))));
        let outcome = first(tried, &before, (TuningGoal::Settle, &[]), set, run).unwrap();
        let Outcome::Judged(passed) = outcome else { panic!("it was cancelled") };
        passed.map(|passed| passed.set[0].0.clone())
    }

    #[test]
    fn gains_that_lose_a_joint_are_passed_over_if_others_lose_none() {
        let never = f64::INFINITY;
        let after = |set: &str| match set {
            // One that is lost, and one that is saved: no more fail than before.
            "2.0" => [1.0, never, 1.0],
            _ => [1.0, 1.0, never],
        };
        assert_eq!(judged(&[(-1.0, 3.0), (-2.0, 2.0)], after).as_deref(), Some("3.0"));
        // It is no worse as a whole, and stays if there is nothing else.
        assert_eq!(judged(&[(-2.0, 2.0)], after).as_deref(), Some("2.0"));
        let careless = |_: &str| [1.0, never, never];
        assert_eq!(judged(&[(-2.0, 2.0)], careless), None);
        // What is no better on the joints of the search is not judged.
        assert_eq!(judged(&[(0.0, 3.0)], after), None);
        assert_eq!(judged(&[(-1.0, 3.0)], |_| [3.0, 3.0, never]), None);
    }

    #[test]
    fn a_judgement_that_is_cancelled_passes_nothing() {
        let before = rows([2.0; 3]);
        let outcome = first(
            vec![(-1.0, vec![2.0])],
            &before,
            (TuningGoal::Settle, &[]),
            |_| vec![],
            |_| Ok(None),
        );
        assert!(matches!(outcome, Ok(Outcome::Cancelled)));
    }

    #[test]
    fn at_most_five_candidates_are_judged_and_the_same_gains_once() {
        let tried: Vec<(f64, f64)> =
            (0u8..12).map(|n| (-20.0 + f64::from(n), 1.0 + f64::from(n / 2))).collect();
        let never = f64::INFINITY;
        let passes = |number: &'static str| {
            move |set: &str| if set == number { [1.0, 1.0, never] } else { [3.0, 3.0, never] }
        };
        assert_eq!(judged(&tried, passes("5.0")).as_deref(), Some("5.0"));
        assert_eq!(judged(&tried, passes("6.0")), None);
    }
}
