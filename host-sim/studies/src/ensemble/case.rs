//! One case under one law: a step, a trajectory, and a row of moves if it is requested.

use super::case_result::{CaseResult, JudgedMotion, goal, near_counts};
use super::drawn_case::Case;
use super::measures::{CaseSample, StepJudge, StepMeasures, TrackingJudge, TrackingMeasures};
use super::motions::{Approach, Motions};
use super::moves::{self, Wear};
use super::rig::Rig;
use super::{arm_case, assemble};
use files::error::Error;
use simulator::guest;
use simulator::rules::ControllerGains;

/// Runs a case under a law; `gains` has those of each joint. An arm makes no moves in a row.
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

/// Runs a case as `run` does, and passes every sample of step and trajectory with its time (s) to
/// `show`.
///
/// # Errors
/// If the core refuses the gains, or a law of another program fails.
pub fn run_and_show(
    case: &Case,
    law: &str,
    gains: &[ControllerGains],
    motions: Motions,
    show: impl FnMut(JudgedMotion, f64, &CaseSample),
) -> Result<CaseResult, Error> {
    guest::run_case(gains, || ran(case, law, gains, motions, show))
}

fn ran(
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
        moves_fault: wear.fault,
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

type Judged<M> = Result<(M, Option<String>), Error>;

/// Result of a step.
struct Stepped {
    measures: StepMeasures,
    /// Time at which the set point came to rest at the target, s.
    rests_s: f64,
    fault: Option<String>,
    /// Time at which the law gave up before a wall (s), and the largest effort afterwards.
    end: Option<(f64, f64)>,
    law_signals: String,
}

/// Runs the step. A fault ends it: the servo turns its output off, and the brake that would then
/// hold the joint is not simulated.
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
    let fault = rig.failure();
    let law_signals = rig.published(&gains.laws);
    let rests_s = judge.rests_s();
    Ok(Stepped { measures: judge.measures(&last, rests_s), rests_s, fault, end, law_signals })
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
    let fault = rig.failure();
    Ok((judge.measures(h), fault))
}
