//! What gains come to on a set of joints, and what that is worth for a goal.

use clap::ValueEnum;
use serde::Deserialize;

use crate::ensemble::{Row, Sorted};

/// A success settles so soon, s; what does not is taken for twice as late.
const WITHIN_S: f64 = 5.0;

/// What it costs if all joints fail: as much as a figure of weight 1 that is e^20 times as large.
/// One failure of a few dozen joints costs less than a large gain of a figure, so that the search
/// is not stopped by it; [`Figures::are_better_than`] is.
const FAILURE: f64 = 20.0;

/// What a figure costs that is above its limit, for each factor of e.
const EXCESS: f64 = 20.0;

/// What the gains are to be good at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// To be at rest within two counts soon after a step
    Settle,
    /// To follow a trajectory closely
    Track,
    /// Both, with little chatter and little heat
    Balanced,
}

impl Goal {
    /// Weights of settling, tracking, rest, chatter and heat.
    const fn weights(self) -> [f64; 5] {
        match self {
            Self::Settle => [1.0, 0.1, 0.1, 0.05, 0.05],
            Self::Track => [0.1, 1.0, 0.1, 0.05, 0.05],
            Self::Balanced => [0.5, 0.5, 0.2, 0.1, 0.1],
        }
    }
}

/// The figures of a set of gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Joints.
    pub cases: usize,
    /// Joints that settle within 5 s, stay, and trip no monitor, in step and trajectory.
    pub successes: usize,
    /// Mean settling, s; of what does not settle, 10 s.
    pub settling_s: f64,
    /// Mean tracking error, rms, counts; none if the file has no trajectory, infinite after a
    /// fault.
    pub tracking_counts: Option<f64>,
    /// Rest error that 90 % of the joints do not exceed, counts.
    pub rest_counts: f64,
    /// Mean total variation of the effort, at rest and in motion, V/s.
    pub chatter_v_per_s: f64,
    /// Root mean square of the effort at rest, V: its square is the motor's heat.
    pub held_v: f64,
}

/// Whether a joint settles in time, stays, and trips no monitor.
pub(super) fn is_fine(row: &Row) -> bool {
    row.is_success(WITHIN_S) && row.faults().next().is_none()
}

impl Figures {
    /// Sums up the rows of one law.
    pub fn of(rows: &[Row]) -> Self {
        let cases = rows.len();
        let mean =
            |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / cases.max(1) as f64;
        let has_motion =
            rows.iter().any(|row| row.tracking_rms.is_some() || row.tracking_fault.is_some());
        let tracking = |row: &Row| row.tracking_rms.map_or(f64::INFINITY, |rms| rms / row.count);
        Self {
            cases,
            successes: rows.iter().filter(|row| is_fine(row)).count(),
            settling_s: mean(&|row| {
                let settled_s = row.settled_s.filter(|_| row.step_fault.is_none());
                settled_s.map_or(2.0 * WITHIN_S, |settled_s| settled_s.min(2.0 * WITHIN_S))
            }),
            tracking_counts: has_motion.then(|| mean(&tracking)),
            rest_counts: Sorted::new(rows.iter().map(|row| row.rest_counts))
                .quantile(0.9)
                .unwrap_or(f64::INFINITY),
            chatter_v_per_s: mean(&|row| row.variation_rest_per_s + row.variation_motion_per_s),
            held_v: mean(&|row| row.held_effort.powi(2)).sqrt(),
        }
    }

    /// The figures by the names that limits have, each with the size below which it does not
    /// matter.
    fn named(&self) -> [(&'static str, f64, f64); 5] {
        [
            ("settling_s", self.settling_s, 1e-3),
            ("tracking_counts", self.tracking_counts.unwrap_or(0.0), 1.0),
            ("rest_counts", self.rest_counts, 1.0),
            ("chatter_v_per_s", self.chatter_v_per_s, 0.1),
            ("held_v", self.held_v, 0.01),
        ]
    }

    /// What these figures cost beside those of the gains to begin with, for a goal and under
    /// limits:
    ///
    /// ```text
    /// cost = 20 (failures / joints) + sum w_i ln((x_i + s_i) / (x_i0 + s_i))
    ///      + 20 sum ln(x_i / limit_i) of those above their limit
    /// ```
    ///
    /// `s_i` is the size below which a figure does not matter. A ratio counts the same wherever a
    /// figure begins, and units cancel.
    pub fn cost(&self, start: &Self, goal: Goal, limits: &[(String, f64)]) -> f64 {
        let failed = (self.cases - self.successes) as f64 / self.cases.max(1) as f64;
        let pairs = self.named().into_iter().zip(start.named()).zip(goal.weights());
        let gained: f64 = pairs
            .map(|(((_, now, size), (_, then, _)), weight)| {
                // A trajectory that ends in a fault is infinitely bad, and counted as a failure.
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

    /// Tells whether these figures are better than `start`: they cost less, and no joint more
    /// fails.
    pub fn are_better_than(&self, start: &Self, goal: Goal, limits: &[(String, f64)]) -> bool {
        let cost = |figures: &Self| figures.cost(start, goal, limits);
        self.successes >= start.successes && cost(self) < cost(start)
    }

    /// The names that a limit may have.
    pub fn names() -> [&'static str; 5] {
        ["settling_s", "tracking_counts", "rest_counts", "chatter_v_per_s", "held_v"]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(settled_s: Option<f64>, rest_counts: f64) -> Row {
        let tracking_rms = Some(0.01);
        Row { settled_s, rest_counts, tracking_rms, count: 0.001, ..Row::default() }
    }

    #[test]
    fn a_failure_costs_more_than_any_figure_gains() {
        let slow = Figures::of(&[row(Some(4.0), 1.0), row(Some(4.0), 1.0)]);
        let fast = Figures::of(&[row(Some(0.1), 1.0), row(None, 30.0)]);
        assert_eq!((slow.successes, fast.successes), (2, 1));
        assert!((fast.settling_s - 5.05).abs() < 1e-12 && fast.rest_counts == 30.0);
        assert!((slow.tracking_counts.unwrap() - 10.0).abs() < 1e-9);
        for goal in [Goal::Settle, Goal::Track, Goal::Balanced] {
            assert_eq!(slow.cost(&slow, goal, &[]), 0.0);
            assert!(fast.cost(&slow, goal, &[]) > 5.0);
        }
    }

    #[test]
    fn what_lets_one_joint_more_fail_is_not_better_however_much_faster_it_is() {
        let slow = Figures { cases: 40, successes: 40, ..Figures::of(&[row(Some(4.0), 1.0)]) };
        let fast = Figures { settling_s: 0.1, ..slow };
        let careless = Figures { successes: 39, ..fast };
        assert!(careless.cost(&slow, Goal::Settle, &[]) < slow.cost(&slow, Goal::Settle, &[]));
        let is_better = |figures: &Figures| figures.are_better_than(&slow, Goal::Settle, &[]);
        assert!(is_better(&fast) && !is_better(&careless) && !is_better(&slow));
    }

    #[test]
    fn a_goal_weighs_its_own_figure_most_and_a_limit_more() {
        let start = Figures::of(&[row(Some(1.0), 1.0)]);
        let sooner = Figures { settling_s: 0.5, ..start };
        let closer = Figures { tracking_counts: Some(4.5), ..start };
        // (10 + 1) / (4.5 + 1) is 2, as is 1 s to 0.5 s but for its size of 1 ms.
        let cost = |figures: &Figures, goal| figures.cost(&start, goal, &[]);
        assert!((cost(&closer, Goal::Track) + 2.0_f64.ln()).abs() < 1e-12);
        assert!(cost(&sooner, Goal::Settle) < cost(&closer, Goal::Settle));
        assert!(cost(&closer, Goal::Track) < cost(&sooner, Goal::Track));
        let limit = [("settling_s".to_owned(), 0.25)];
        let excess = sooner.cost(&start, Goal::Settle, &limit) - cost(&sooner, Goal::Settle);
        assert!((excess - 20.0 * 2.0_f64.ln()).abs() < 1e-9, "{excess}");
    }
}
