//! Judges the best gains of a search on other joints than those of the search.
//!
//! Gains pass if they cost less than the file's and no more joints fail. The first gains that pass
//! and lose no joint are kept: every joint that succeeds with the file's gains succeeds with them
//! too. Joints are compared one by one, each with its delay, since an equal number of failures can
//! hide a lost joint behind a saved one. If all gains that pass lose a joint, the first that pass
//! are kept (docs/how-to/tune.md). At most [`CANDIDATES`] are judged, in the order of their costs
//! in the search.

use super::figures::{TuningFigures, TuningGoal, is_fine};
use crate::ensemble::CaseResult;
use files::error::Error;

/// Largest number of judged candidates.
pub(super) const CANDIDATES: usize = 5;

/// Tried gains: their cost minus that of the file's gains on the joints of the search, and their
/// factors.
pub(super) type Tried = (f64, Vec<f64>);

/// Gains that passed: their values by key and their factors, with the rows of their joints.
pub(super) struct Passed {
    pub factors: Vec<f64>,
    pub set: Vec<(String, f64)>,
    pub rows: Vec<CaseResult>,
}

/// Outcome of a judgement.
pub(super) enum Outcome {
    /// The judgement was cancelled.
    Cancelled,
    /// The gains that passed, if any did.
    Judged(Option<Passed>),
}

/// Returns the first candidate that passes and loses no joint, or else the first that passes. `set`
/// converts factors to gains with their keys. `rows` runs these gains on the joints of the
/// judgement, in the order of `before`; if it returns `None`, the judgement is cancelled.
///
/// # Errors
/// Returns the error of `rows`.
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

/// Returns whether a joint that succeeded before fails now.
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
        // Gains that are no better on the joints of the search are not judged.
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
