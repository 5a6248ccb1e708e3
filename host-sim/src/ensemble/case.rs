//! One case under one law: a step, a trajectory, and a row of moves if it is asked for.

use serde::{Deserialize, Serialize};

use super::assemble;
use super::draw::Case;
use super::measures::{Sample, StepJudge, StepMeasures, TrackingJudge, TrackingMeasures};
use super::moves::{self, Wear};
use super::rig::Rig;
use super::rules::Tuned;
use crate::error::Error;

/// What a law comes to on a joint; a line of `--csv`. An empty value is one that is not there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
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
}

impl Row {
    /// Says whether the joint settled in time, stayed until the end, and no monitor tripped in the
    /// step.
    pub fn is_success(&self, within_s: f64) -> bool {
        self.step_fault.is_none() && self.settled_s.is_some_and(|settled_s| settled_s <= within_s)
    }

    /// Returns the faults of the case. Nothing is wrong with a joint of an ensemble.
    pub fn faults(&self) -> impl Iterator<Item = &str> {
        [&self.step_fault, &self.tracking_fault, &self.moves_fault]
            .into_iter()
            .flatten()
            .map(|s| &**s)
    }
}

/// The motion that a sample belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// The step.
    Step,
    /// The trajectory.
    Trajectory,
}

/// Runs a case under a law with its gains; then `moves` moves in a row that `seed` draws.
///
/// # Errors
/// If the core refuses the gains.
pub fn run(case: &Case, law: &str, tuned: &Tuned, [seed, moves]: [u64; 2]) -> Result<Row, Error> {
    run_and_show(case, law, tuned, [seed, moves], |_, _, _| {})
}

/// Does the same, and shows every sample of step and trajectory with its time, s.
///
/// # Errors
/// If the core refuses the gains.
pub fn run_and_show(
    case: &Case,
    law: &str,
    tuned: &Tuned,
    [seed, moves]: [u64; 2],
    mut show: impl FnMut(Motion, f64, &Sample),
) -> Result<Row, Error> {
    let (step, step_fault) =
        stepped(case, tuned, |time_s, sample| show(Motion::Step, time_s, sample))?;
    let (tracking, tracking_fault) =
        tracked(case, tuned, |time_s, sample| show(Motion::Trajectory, time_s, sample))?;
    let moves = u32::try_from(moves).unwrap_or(u32::MAX);
    let wear = if moves > 0 { moves::run(case, tuned, seed, moves)? } else { Wear::default() };
    let count = case.count();
    Ok(Row {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        count,
        jump_counts: case.jump_counts,
        settled_s: step.settled_s,
        rest_counts: step.rest_counts,
        load_rest_counts: case.family.has_unseen_load().then_some(step.load_rest_counts),
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
    })
}

type Judged<M> = Result<(M, Option<String>), Error>;

/// Runs the step. A fault ends it: the servo lets go, and its brake is no part of the joint.
fn stepped(case: &Case, tuned: &Tuned, mut show: impl FnMut(f64, &Sample)) -> Judged<StepMeasures> {
    let h = case.told.sample_time;
    let samples = (case.family.duration_s() / h).round() as u32;
    let mut judge = StepJudge::new(samples);
    let mut rig = Rig::armed(case, tuned)?;
    // A step is refused after a fault only, which the first tick tells.
    let _ = rig.follow(assemble::step(case));
    let mut last = Sample::default();
    for k in 0..=samples {
        last = rig.tick();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&last);
        show(f64::from(k) * h, &last);
    }
    let fault = rig.fault().map(|fault| fault.describe().to_owned());
    Ok((judge.measures(h, &last), fault))
}

fn tracked(
    case: &Case,
    tuned: &Tuned,
    mut show: impl FnMut(f64, &Sample),
) -> Judged<TrackingMeasures> {
    let h = case.told.sample_time;
    let motion = assemble::trapezoid(case)?;
    let mut judge = TrackingJudge::new(motion.window, motion.top);
    let mut rig = Rig::armed(case, tuned)?;
    let follows = rig.follow(motion.reference);
    for k in (0..=motion.window[1]).take_while(|_| follows) {
        let sample = rig.tick();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&sample);
        show(f64::from(k) * h, &sample);
    }
    let fault = rig.fault().map(|fault| fault.describe().to_owned());
    Ok((judge.measures(h), fault))
}
