//! Result of a law on a case, and the goal by which it is judged.

use serde::{Deserialize, Serialize};

use super::drawn_case::Case;
use super::measures::SideMeasures;
use files::goal::PositionGoal;

/// Result of a law on a joint; a line of `--csv`. An empty cell means that there is no value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseResult {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Number of the case.
    pub case: u64,
    /// Angle of a count, in the family's unit: a turn of the SI families has 1e5 or 1e4 counts.
    pub count: f64,
    /// Jump of a load behind a shaft, counts.
    pub jump_counts: Option<f64>,
    /// Time after which the joint stays within 2 counts, s.
    pub settled_s: Option<f64>,
    /// Largest error in the last half of the step, counts.
    pub rest_counts: f64,
    /// The same of a load that the encoder does not see, counts.
    pub load_rest_counts: Option<f64>,
    /// Number of reversals in the last half of the run.
    pub reversals: u32,
    /// Distance between the extremes in the last half of the run, counts.
    pub swing_counts: f64,
    /// Period of the reversals, s.
    pub period_s: Option<f64>,
    /// Total variation of the effort in the last half of the run, in the family's unit per second.
    pub variation_rest_per_s: f64,
    /// Root mean square of the effort in the last half of the run, in the family's unit.
    pub held_effort: f64,
    /// Fault that ended the step.
    pub step_fault: Option<String>,
    /// Root mean square of the error in tracking, in the family's unit.
    pub tracking_rms: Option<f64>,
    /// Number of stops in motion.
    pub sticks_in_motion: u32,
    /// Total variation of the effort in motion, in the family's unit per second.
    pub variation_motion_per_s: f64,
    /// Fault that ended the trajectory.
    pub tracking_fault: Option<String>,
    /// Number of moves in a row.
    pub moves: u32,
    /// Number of moves in the first tenth of the row that did not end within 2 counts.
    pub missed_first: u32,
    /// The same of the last tenth.
    pub missed_last: u32,
    /// Number of moves in a tenth of the row.
    pub judged_moves: u32,
    /// Root mean square of the tracking error in the first tenth, in the family's unit.
    pub moves_rms_first: Option<f64>,
    /// The same in the last tenth.
    pub moves_rms_last: Option<f64>,
    /// Fault that ended the row.
    pub moves_fault: Option<String>,
    /// Number of moves in the whole row that did not end within 2 counts.
    pub missed: u32,
    /// Time after which the joint stays near its target, s, if its family defines an error for
    /// that.
    pub near_s: Option<f64>,
    /// Time at which the law gave up before a wall, s.
    pub gave_up_s: Option<f64>,
    /// Largest effort after the law gave up, from the next tick on, in the family's unit.
    pub effort_after: Option<f64>,
    /// Signals that the law published at the end of the step, `name=value` with a space between;
    /// empty for an arm and for a machine's own file.
    pub law_signals: String,
    /// Time after which the encoder's side stays within the tolerance, s.
    pub settled_at_encoder_s: Option<f64>,
    /// The same of the load, s.
    pub settled_at_load_s: Option<f64>,
    /// Largest error of the encoder's side in the last half of the step, counts.
    pub rest_at_encoder_counts: f64,
    /// The same of the load, counts.
    pub rest_at_load_counts: f64,
    /// Whether the step met the goal at the encoder without a fault. Before a wall, giving up in
    /// time counts as well.
    pub success_at_encoder: bool,
    /// The same at the load.
    pub success_at_load: bool,
    /// Root mean square of the encoder side's error in tracking, in the family's unit.
    pub tracking_at_encoder_rms: Option<f64>,
    /// The same of the load.
    pub tracking_at_load_rms: Option<f64>,
    /// Move of the row that a fault ended, from 1.
    pub fault_in_move: Option<u32>,
    /// Time at which the set point came to rest at the target, s; 0 for a step.
    #[serde(default)]
    pub set_point_rests_s: f64,
}

/// Differences of times below this are rounding, s.
const SAME_TIME_S: f64 = 1e-9;

impl CaseResult {
    /// Returns whether the joint settled in time, stayed until the end, and no monitor tripped in
    /// the step. Before a wall, giving up in time counts as well.
    pub fn is_success(&self, within_s: f64) -> bool {
        let mut ends = [self.settled_s, self.gave_up_s].into_iter().flatten();
        let latest_s = self.set_point_rests_s + within_s + SAME_TIME_S;
        self.step_fault.is_none() && ends.any(|end_s| end_s <= latest_s)
    }

    /// Sets the verdict at both sides of the gear. `step_fault`, `gave_up_s` and
    /// `set_point_rests_s` must be set before.
    pub(super) fn judge(&mut self, [at_encoder, at_load]: [SideMeasures; 2], within_s: f64) {
        let latest_s = self.set_point_rests_s + within_s + SAME_TIME_S;
        let has_given_up = self.gave_up_s.is_some_and(|end_s| end_s <= latest_s);
        let succeeds =
            |side: SideMeasures| self.step_fault.is_none() && (side.is_success || has_given_up);
        (self.success_at_encoder, self.success_at_load) = (succeeds(at_encoder), succeeds(at_load));
        self.settled_at_encoder_s = at_encoder.settled_s;
        self.settled_at_load_s = at_load.settled_s;
        self.rest_at_encoder_counts = at_encoder.rest_counts;
        self.rest_at_load_counts = at_load.rest_counts;
    }

    /// Returns the names of the faults that ended a motion of the case: false trips, since no joint
    /// of an ensemble is defective.
    pub fn faults(&self) -> impl Iterator<Item = &str> {
        [&self.step_fault, &self.tracking_fault, &self.moves_fault]
            .into_iter()
            .flatten()
            .map(|s| &**s)
    }
}

/// Motion that a sample belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JudgedMotion {
    /// The move to the target.
    Positioning,
    /// The trajectory.
    Trajectory,
}

/// Returns the goal of a family: within two counts in the time of the family, and until the end.
pub(super) fn goal(case: &Case) -> PositionGoal {
    let settle_s = Some(case.family.settles_within_s());
    PositionGoal { settle_s, ..PositionGoal::default() }
}

/// Returns the error below which the joint counts as close to its target, counts; infinite if the
/// family defines none.
pub(super) fn near_counts(case: &Case) -> f64 {
    case.family.near().map_or(f64::INFINITY, |near| near / case.count())
}
