//! One case under one law: a step, a trajectory, and a row of moves if it is asked for.

use serde::{Deserialize, Serialize};

use super::draw::Case;
use super::measures::{
    CaseSample, SideMeasures, StepJudge, StepMeasures, TrackingJudge, TrackingMeasures,
};
use super::motions::{Approach, Motions};
use super::moves::{self, Wear};
use super::rig::Rig;
use super::{arm_case, assemble};
use files::error::Error;
use files::goal::PositionGoal;
use simulator::rules::ControllerGains;

/// What a law comes to on a joint; a line of `--csv`. An empty value is one that is not there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseResult {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Number of the case.
    pub case: u64,
    /// Counts of a turn are 1e5 or 1e4; this is the angle of one, in the family's unit.
    pub count: f64,
    /// Jump of a load behind a shaft, counts.
    pub jump_counts: Option<f64>,
    /// Time after which the joint stays within 2 counts, s.
    pub settled_s: Option<f64>,
    /// Largest error in the last half of the step, counts.
    pub rest_counts: f64,
    /// The same of a load that the encoder does not see, counts.
    pub load_rest_counts: Option<f64>,
    /// Reversals there.
    pub reversals: u32,
    /// Distance of the extremes there, counts.
    pub swing_counts: f64,
    /// Period of the reversals, s.
    pub period_s: Option<f64>,
    /// Total variation of the effort there, in the family's unit per second.
    pub variation_rest_per_s: f64,
    /// Root mean square of the effort there, in the family's unit.
    pub held_effort: f64,
    /// Fault that ended the step.
    pub step_fault: Option<String>,
    /// Root mean square of the error in tracking, in the family's unit.
    pub tracking_rms: Option<f64>,
    /// Stops in motion.
    pub sticks_in_motion: u32,
    /// Total variation of the effort in motion, in the family's unit per second.
    pub variation_motion_per_s: f64,
    /// Fault that ended the trajectory.
    pub tracking_fault: Option<String>,
    /// Moves in a row: how many were asked for.
    pub moves: u32,
    /// Moves that did not end within 2 counts: of the first tenth of the row.
    pub missed_first: u32,
    /// The same of the last tenth.
    pub missed_last: u32,
    /// Moves of a tenth.
    pub judged_moves: u32,
    /// Root mean square of the tracking error in the first tenth, in the family's unit.
    pub moves_rms_first: Option<f64>,
    /// The same in the last tenth.
    pub moves_rms_last: Option<f64>,
    /// Fault that ended the row.
    pub moves_fault: Option<String>,
    /// Moves of the whole row that did not end within 2 counts.
    pub missed: u32,
    /// Time after which the joint stays near its target, s, if its family says what that is.
    pub near_s: Option<f64>,
    /// Time at which the law gave up before a wall, s.
    pub gave_up_s: Option<f64>,
    /// Largest effort from the next tick on, in the family's unit.
    pub effort_after: Option<f64>,
    /// What the law published of itself at the end of the step, `name=value` with a space between;
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
    /// Whether the step met the goal at the encoder without a fault. Before a wall the law may give
    /// up in time instead.
    pub success_at_encoder: bool,
    /// The same at the load.
    pub success_at_load: bool,
    /// Root mean square of the encoder side's error in tracking, in the family's unit.
    pub tracking_at_encoder_rms: Option<f64>,
    /// The same of the load.
    pub tracking_at_load_rms: Option<f64>,
    /// Move of the row that a fault ended, from 1.
    pub fault_in_move: Option<u32>,
    /// Time at which the set point came to rest at the target, s; 0 of a step.
    #[serde(default)]
    pub set_point_rests_s: f64,
}

/// Differences of times below this are rounding, s.
const SAME_TIME_S: f64 = 1e-9;

impl CaseResult {
    /// Says whether the joint settled in time, stayed until the end, and no monitor tripped in the
    /// step. Before a wall it is as good that the law gives up in time.
    pub fn is_success(&self, within_s: f64) -> bool {
        let mut ends = [self.settled_s, self.gave_up_s].into_iter().flatten();
        let latest_s = self.set_point_rests_s + within_s + SAME_TIME_S;
        self.step_fault.is_none() && ends.any(|end_s| end_s <= latest_s)
    }

    /// Sets the verdict at both sides of the gear. The fault of the step and the time at which the
    /// set point rests are set before.
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

    /// Returns the faults of the case. Nothing is wrong with a joint of an ensemble.
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

/// Runs a case under a law with its gains, of each of its joints. An arm makes no moves in a row.
///
/// # Errors
/// If the core refuses the gains.
pub fn run(
    case: &Case,
    law: &str,
    gains: &[ControllerGains],
    motions: Motions,
) -> Result<CaseResult, Error> {
    run_and_show(case, law, gains, motions, |_, _, _| {})
}

/// Does the same, and shows every sample of step and trajectory with its time, s.
///
/// # Errors
/// If the core refuses the gains.
pub fn run_and_show(
    case: &Case,
    law: &str,
    gains: &[ControllerGains],
    motions: Motions,
    mut show: impl FnMut(JudgedMotion, f64, &CaseSample),
) -> Result<CaseResult, Error> {
    if case.family.is_arm() {
        return arm_case::run(case, law, gains, motions.approach, show);
    }
    let [gains] = gains else {
        return Err(Error::Input("gains for one joint are wanted".into()));
    };
    let Stepped { measures: step, rests_s, fault: step_fault, end, law_signals } =
        stepped(case, gains, motions.approach, |time_s, sample| {
            show(JudgedMotion::Positioning, time_s, sample);
        })?;
    // A trajectory would lead far beyond a wall.
    let has_wall = case.family.has_wall();
    let (tracking, tracking_fault) = if has_wall {
        (TrackingMeasures::default(), None)
    } else {
        tracked(case, gains, |time_s, sample| show(JudgedMotion::Trajectory, time_s, sample))?
    };
    let moves = if has_wall { 0 } else { motions.moves };
    let wear = if moves > 0 {
        moves::run(case, gains, Motions { moves, ..motions })?
    } else {
        Wear::default()
    };
    let count = case.count();
    let [at_encoder, at_load] = [step.at_encoder, step.at_load];
    let mut row = CaseResult {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        count,
        jump_counts: case.jump_counts,
        settled_s: at_encoder.settled_s,
        rest_counts: at_encoder.rest_counts,
        load_rest_counts: case.family.has_unseen_load().then_some(at_load.rest_counts),
        reversals: step.reversals,
        swing_counts: step.swing_counts,
        period_s: step.period_s,
        variation_rest_per_s: step.variation_per_s,
        held_effort: step.held_effort,
        step_fault,
        tracking_rms: tracking.rms_counts.map(|rms| rms * count),
        sticks_in_motion: tracking.sticks,
        variation_motion_per_s: tracking.variation_per_s,
        tracking_fault,
        moves,
        missed_first: wear.missed[0],
        missed_last: wear.missed[1],
        judged_moves: wear.judged,
        moves_rms_first: wear.rms_counts[0].map(|rms| rms * count),
        moves_rms_last: wear.rms_counts[1].map(|rms| rms * count),
        moves_fault: wear.fault.map(|fault| fault.describe().into()),
        missed: wear.missed_of_all,
        near_s: case.family.near().and(step.near_s),
        gave_up_s: end.map(|(time_s, _)| time_s),
        effort_after: end.map(|(_, effort)| effort),
        law_signals,
        tracking_at_encoder_rms: tracking.rms_counts.map(|rms| rms * count),
        tracking_at_load_rms: tracking.load_rms_counts.map(|rms| rms * count),
        fault_in_move: wear.fault_in,
        set_point_rests_s: rests_s,
        ..CaseResult::default()
    };
    row.judge([at_encoder, at_load], case.family.settles_within_s());
    Ok(row)
}

/// Returns the goal of a family: two counts, its time, and to stay until the end.
pub(super) fn goal(case: &Case) -> PositionGoal {
    let settle_s = Some(case.family.settles_within_s());
    PositionGoal { settle_s, ..PositionGoal::default() }
}

type Judged<M> = Result<(M, Option<String>), Error>;

/// What a step comes to.
struct Stepped {
    measures: StepMeasures,
    /// Time at which the set point came to rest at the target, s.
    rests_s: f64,
    fault: Option<String>,
    /// When the law gave up before a wall (s), and the largest effort afterwards.
    end: Option<(f64, f64)>,
    law_signals: String,
}

/// Runs the step. A fault ends it: the servo lets go, and its brake is no part of the joint.
fn stepped(
    case: &Case,
    gains: &ControllerGains,
    approach: Approach,
    mut show: impl FnMut(f64, &CaseSample),
) -> Result<Stepped, Error> {
    let h = case.bounds.sampled.sample_time;
    let samples = (case.family.duration_s() / h).round() as u32;
    let mut judge = StepJudge::new(samples, near_counts(case), h).by(&goal(case), 1.0);
    let mut end: Option<(f64, f64)> = None;
    let mut rig = Rig::armed(case, gains)?;
    let target = case.step / case.count();
    if approach == Approach::Profiled {
        judge = judge.of_move_to(rig.armed_at() + target);
    }
    // A move is refused after a fault only, which the first tick reports.
    rig.go_to(approach, target)?;
    let mut last = CaseSample::default();
    for k in 0..=samples {
        last = rig.step();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&last);
        show(f64::from(k) * h, &last);
        if case.family.has_wall() {
            end = match end {
                // The law's effort of the tick in which it gives up is still under way.
                Some((time_s, effort)) => Some((time_s, effort.max(last.effort.abs()))),
                None => rig.has_given_up().then(|| (f64::from(k) * h, 0.0)),
            };
        }
    }
    let fault = rig.fault().map(|fault| fault.describe().to_owned());
    let law_signals = rig.published(&gains.laws);
    let rests_s = judge.rests_s();
    Ok(Stepped { measures: judge.measures(&last, rests_s), rests_s, fault, end, law_signals })
}

/// Error below which the joint counts as close to its target, counts.
pub(super) fn near_counts(case: &Case) -> f64 {
    case.family.near().map_or(f64::INFINITY, |near| near / case.count())
}

fn tracked(
    case: &Case,
    gains: &ControllerGains,
    mut show: impl FnMut(f64, &CaseSample),
) -> Judged<TrackingMeasures> {
    let h = case.bounds.sampled.sample_time;
    let motion = assemble::trapezoid(case)?;
    let mut judge = TrackingJudge::new(motion.window, motion.top);
    let mut rig = Rig::armed(case, gains)?;
    let follows = rig.follow(motion.reference);
    for k in (0..=motion.window[1]).take_while(|_| follows) {
        let sample = rig.step();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&sample);
        show(f64::from(k) * h, &sample);
    }
    let fault = rig.fault().map(|fault| fault.describe().to_owned());
    Ok((judge.measures(h), fault))
}
