//! Figures of a set of gains on a set of joints, and their cost for a goal.
//!
//! Gains are judged at the encoder: no gain can correct an error that the encoder cannot see. The
//! same figures at the load are reported too.

use serde::Deserialize;

use crate::ensemble::{CaseResult, SortedValues};

/// Default limit on the settling time of a success, s. A joint that settles later than twice this
/// time, or never, counts as twice this time.
const WITHIN_S: f64 = 5.0;

/// Cost if all joints fail: that of a figure of weight 1 that is e^20 times as large. One failure
/// among a few dozen joints costs less than a large improvement of a figure saves, so the search
/// continues past it. [`TuningFigures::are_better_than`] rejects it.
const FAILURE: f64 = 20.0;

/// Cost of a figure above its limit, for each factor e of the excess.
const EXCESS: f64 = 20.0;

/// Objective of the gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
pub enum TuningGoal {
    /// To be at rest within two counts soon after a step
    Settle,
    /// To follow a trajectory closely
    Track,
    /// Both, with little chatter and little heat
    Balanced,
}

impl TuningGoal {
    /// Weights of settling, tracking, rest, chatter and heat.
    const fn weights(self) -> [f64; 5] {
        match self {
            Self::Settle => [1.0, 0.1, 0.1, 0.05, 0.05],
            Self::Track => [0.1, 1.0, 0.1, 0.05, 0.05],
            Self::Balanced => [0.5, 0.5, 0.2, 0.1, 0.1],
        }
    }
}

/// Figures of a set of gains at one side of the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideFigures {
    /// Number of joints that meet the file's `[goal]` (default: two counts within 5 s) and trip no
    /// monitor, in step and trajectory.
    pub successes: usize,
    /// Mean settling time, s; 10 s for a joint that does not settle.
    pub settling_s: f64,
    /// Mean over the joints of the rms tracking error, counts; `None` if the file has no
    /// trajectory, infinite if a fault ends one.
    pub tracking_counts: Option<f64>,
    /// Rest error that 90 % of the joints do not exceed, counts.
    pub rest_counts: f64,
}

/// The figures of a set of gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuningFigures {
    /// Number of joints; a joint counts once for each of its delays.
    pub cases: usize,
    /// Figures at the encoder, by which the gains are judged.
    pub at_encoder: SideFigures,
    /// Figures at the load.
    pub at_load: SideFigures,
    /// Mean total variation of the effort, sum of rest and motion, V/s.
    pub chatter_v_per_s: f64,
    /// Root mean square of the effort at rest, V: its square is the motor's heat.
    pub held_v: f64,
}

/// Returns whether a joint meets its goal at the encoder, and trips no monitor.
pub(super) fn is_fine(row: &CaseResult) -> bool {
    row.success_at_encoder && row.faults().next().is_none()
}

/// One side of a row: success in the step, settling, tracking and rest error.
type Side = (bool, Option<f64>, Option<f64>, f64);

impl SideFigures {
    fn of(rows: &[CaseResult], side: impl Fn(&CaseResult) -> Side) -> Self {
        let mean = |of: &dyn Fn(&CaseResult) -> f64| {
            rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64
        };
        let has_motion =
            rows.iter().any(|row| row.tracking_rms.is_some() || row.tracking_fault.is_some());
        let is_fine = |row: &&CaseResult| side(row).0 && row.faults().next().is_none();
        Self {
            successes: rows.iter().filter(is_fine).count(),
            settling_s: mean(&|row| {
                let settled_s = side(row).1.filter(|_| row.step_fault.is_none());
                settled_s.map_or(2.0 * WITHIN_S, |settled_s| settled_s.min(2.0 * WITHIN_S))
            }),
            tracking_counts: has_motion
                .then(|| mean(&|row| side(row).2.map_or(f64::INFINITY, |rms| rms / row.count))),
            rest_counts: SortedValues::new(rows.iter().map(|row| side(row).3))
                .quantile(0.9)
                .unwrap_or(f64::INFINITY),
        }
    }
}

impl TuningFigures {
    /// Summarizes the rows of one law.
    pub fn of(rows: &[CaseResult]) -> Self {
        let cases = rows.len();
        let mean = |of: &dyn Fn(&CaseResult) -> f64| {
            rows.iter().map(of).sum::<f64>() / cases.max(1) as f64
        };
        Self {
            cases,
            at_encoder: SideFigures::of(rows, |row| {
                (
                    row.success_at_encoder,
                    row.settled_at_encoder_s,
                    row.tracking_at_encoder_rms,
                    row.rest_at_encoder_counts,
                )
            }),
            at_load: SideFigures::of(rows, |row| {
                (
                    row.success_at_load,
                    row.settled_at_load_s,
                    row.tracking_at_load_rms,
                    row.rest_at_load_counts,
                )
            }),
            chatter_v_per_s: mean(&|row| row.variation_rest_per_s + row.variation_motion_per_s),
            held_v: mean(&|row| row.held_effort.powi(2)).sqrt(),
        }
    }

    /// Returns whether the figures at the load differ from those at the encoder.
    pub fn is_two_sided(&self) -> bool {
        self.at_encoder != self.at_load
    }

    /// Returns the name of each figure in a limit, its value at the encoder, and the size below
    /// which it does not matter.
    fn named(&self) -> [(&'static str, f64, f64); 5] {
        let SideFigures { settling_s, tracking_counts, rest_counts, .. } = self.at_encoder;
        [
            ("settling_s", settling_s, 1e-3),
            ("tracking_counts", tracking_counts.unwrap_or(0.0), 1.0),
            ("rest_counts", rest_counts, 1.0),
            ("chatter_v_per_s", self.chatter_v_per_s, 0.1),
            ("held_v", self.held_v, 0.01),
        ]
    }

    /// Returns the cost of these figures relative to `start`, those of the file's gains, for a goal
    /// and limits:
    ///
    /// ```text
    /// cost = 20 (failures / joints) + sum w_i ln((x_i + s_i) / (x_i0 + s_i))
    ///      + 20 sum ln(x_i / limit_i) of those above their limit
    /// ```
    ///
    /// `s_i` is the size below which a figure does not matter. The same ratio has the same cost at
    /// any start value, and units cancel.
    pub fn cost(&self, start: &Self, goal: TuningGoal, limits: &[(String, f64)]) -> f64 {
        let failed = (self.cases - self.at_encoder.successes) as f64 / self.cases.max(1) as f64;
        let pairs = self.named().into_iter().zip(start.named()).zip(goal.weights());
        let gained: f64 = pairs
            .map(|(((_, now, size), (_, then, _)), weight)| {
                // A trajectory that a fault ends has an infinite error, and counts as a failure.
                let ratio = (now.min(1e6) + size) / (then.min(1e6) + size);
                weight * ratio.ln()
            })
            .sum();
        let above: f64 = limits
            .iter()
            .filter_map(|(name, limit)| {
                let (_, value, _) = self.named().into_iter().find(|(known, ..)| known == name)?;
                (value > *limit).then(|| (value.min(1e6) / limit).ln())
            })
            .sum();
        FAILURE * failed + gained + EXCESS * above
    }

    /// Returns whether these figures are better than `start`: a lower cost, and no more failures at
    /// the encoder.
    pub fn are_better_than(
        &self,
        start: &Self,
        goal: TuningGoal,
        limits: &[(String, f64)],
    ) -> bool {
        let cost = |figures: &Self| figures.cost(start, goal, limits);
        self.at_encoder.successes >= start.at_encoder.successes && cost(self) < cost(start)
    }

    /// Returns the names of the figures that can have a limit.
    pub fn names() -> [&'static str; 5] {
        ["settling_s", "tracking_counts", "rest_counts", "chatter_v_per_s", "held_v"]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(settled_s: Option<f64>, rest_counts: f64) -> CaseResult {
        CaseResult {
            success_at_encoder: settled_s.is_some_and(|settled_s| settled_s <= 5.0),
            settled_at_encoder_s: settled_s,
            rest_at_encoder_counts: rest_counts,
            tracking_rms: Some(0.01),
            tracking_at_encoder_rms: Some(0.01),
            count: 0.001,
            ..CaseResult::default()
        }
    }

    /// Returns the figures with those at the encoder changed.
    fn at_encoder(of: TuningFigures, change: impl Fn(SideFigures) -> SideFigures) -> TuningFigures {
        TuningFigures { at_encoder: change(of.at_encoder), ..of }
    }

    #[test]
    fn a_failure_costs_more_than_any_figure_gains() {
        let slow = TuningFigures::of(&[row(Some(4.0), 1.0), row(Some(4.0), 1.0)]);
        let fast = TuningFigures::of(&[row(Some(0.1), 1.0), row(None, 30.0)]);
        let (slow_side, fast_side) = (slow.at_encoder, fast.at_encoder);
        assert_eq!((slow_side.successes, fast_side.successes), (2, 1));
        assert!((fast_side.settling_s - 5.05).abs() < 1e-12 && fast_side.rest_counts == 30.0);
        assert!((slow_side.tracking_counts.unwrap() - 10.0).abs() < 1e-9);
        for goal in [TuningGoal::Settle, TuningGoal::Track, TuningGoal::Balanced] {
            assert_eq!(slow.cost(&slow, goal, &[]), 0.0);
            assert!(fast.cost(&slow, goal, &[]) > 5.0);
        }
    }

    #[test]
    fn what_lets_one_joint_more_fail_is_not_better_however_much_faster_it_is() {
        let slow = TuningFigures { cases: 40, ..TuningFigures::of(&[row(Some(4.0), 1.0)]) };
        let slow = at_encoder(slow, |side| SideFigures { successes: 40, ..side });
        let fast = at_encoder(slow, |side| SideFigures { settling_s: 0.1, ..side });
        let careless = at_encoder(fast, |side| SideFigures { successes: 39, ..side });
        assert!(
            careless.cost(&slow, TuningGoal::Settle, &[])
                < slow.cost(&slow, TuningGoal::Settle, &[])
        );
        let is_better =
            |figures: &TuningFigures| figures.are_better_than(&slow, TuningGoal::Settle, &[]);
        assert!(is_better(&fast) && !is_better(&careless) && !is_better(&slow));
    }

    #[test]
    fn a_goal_weighs_its_own_figure_most_and_a_limit_more() {
        let start = TuningFigures::of(&[row(Some(1.0), 1.0)]);
        let sooner = at_encoder(start, |side| SideFigures { settling_s: 0.5, ..side });
        let closer = at_encoder(start, |side| SideFigures { tracking_counts: Some(4.5), ..side });
        // (10 + 1) / (4.5 + 1) is 2, as is 1 s to 0.5 s but for its size of 1 ms.
        let cost = |figures: &TuningFigures, goal| figures.cost(&start, goal, &[]);
        assert!((cost(&closer, TuningGoal::Track) + 2.0_f64.ln()).abs() < 1e-12);
        assert!(cost(&sooner, TuningGoal::Settle) < cost(&closer, TuningGoal::Settle));
        assert!(cost(&closer, TuningGoal::Track) < cost(&sooner, TuningGoal::Track));
        let limit = [("settling_s".to_owned(), 0.25)];
        let excess =
            sooner.cost(&start, TuningGoal::Settle, &limit) - cost(&sooner, TuningGoal::Settle);
        assert!((excess - 20.0 * 2.0_f64.ln()).abs() < 1e-9, "{excess}");
    }

    /// No gain corrects the error of the load within the slack, so the load must not affect the
    /// cost.
    #[test]
    fn the_load_is_beside_the_encoder_and_does_not_move_the_cost() {
        let side = |rest_at_load_counts| CaseResult { rest_at_load_counts, ..row(Some(1.0), 1.0) };
        let [near, far] = [1.0, 105.0].map(|rest| TuningFigures::of(&[side(rest)]));
        assert_eq!((near.at_encoder, near.at_load.rest_counts), (far.at_encoder, 1.0));
        assert_eq!((far.at_load.rest_counts, far.at_load.successes), (105.0, 0));
        assert_eq!(far.cost(&near, TuningGoal::Settle, &[]), 0.0);
        assert!(far.is_two_sided());
    }
}
