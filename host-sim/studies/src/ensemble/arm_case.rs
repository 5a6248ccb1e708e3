//! An arm under one law at each joint: both step at once, and both follow a trajectory at once.
//!
//! Each measure in its row is that of the worse joint, so a success is one of both joints.

use super::arm_rig::ArmRig;
use super::assemble::{self, TrackedTrajectory};
use super::case_result::{CaseResult, JudgedMotion, goal, near_counts};
use super::drawn_case::Case;
use super::measures::{CaseSample, SideMeasures, StepJudge, TrackingJudge};
use super::motions::Approach;
use files::error::Error;
use simulator::rules::ControllerGains;

/// Runs step and trajectory. A sample that `show` receives is that of the first joint; its
/// `load_error` is the error of the second joint.
///
/// # Errors
/// If the core refuses gains.
pub fn run(
    case: &Case,
    law: &str,
    gains: &[ControllerGains],
    approach: Approach,
    mut show: impl FnMut(JudgedMotion, f64, &CaseSample),
) -> Result<CaseResult, Error> {
    let count = case.count();
    let mut row = CaseResult {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        count,
        ..CaseResult::default()
    };
    step(&mut row, case, gains, approach, |time_s, sample| {
        show(JudgedMotion::Positioning, time_s, sample);
    })?;
    trajectory(&mut row, case, gains, |time_s, sample| {
        show(JudgedMotion::Trajectory, time_s, sample);
    })?;
    Ok(row)
}

/// Returns the sample of the first joint with the error of the second one as `load_error`.
fn shown([first, second]: [CaseSample; 2]) -> CaseSample {
    CaseSample { load_error: second.error, ..first }
}

fn step(
    row: &mut CaseResult,
    case: &Case,
    gains: &[ControllerGains],
    approach: Approach,
    mut show: impl FnMut(f64, &CaseSample),
) -> Result<(), Error> {
    let h = case.bounds.sampled.sample_time;
    let samples = (case.family.duration_s() / h).round() as u32;
    let mut judges =
        [0, 1].map(|_| StepJudge::new(samples, near_counts(case), h).by(&goal(case), 1.0));
    let mut rig = ArmRig::armed(case, gains)?;
    let second = case.arm.as_ref().map_or(0.0, |arm| arm.step);
    let targets = [case.step, second].map(|to| to / case.count());
    if approach == Approach::Profiled {
        let ([one, other], [from, from_other]) = (judges, rig.armed_at());
        judges = [one.of_move_to(from + targets[0]), other.of_move_to(from_other + targets[1])];
    }
    // A move is refused after a fault only, which the first tick reports.
    rig.go_to(approach, targets)?;
    let mut last = [CaseSample::default(); 2];
    for k in 0..=samples {
        last = rig.step(case.count());
        if rig.fault().is_some() {
            break;
        }
        judges.iter_mut().zip(&last).for_each(|(judge, sample)| judge.see(sample));
        show(f64::from(k) * h, &shown(last));
    }
    // Both joints are judged from the time at which the last set point rests.
    let rests_s = judges.iter().map(StepJudge::rests_s).fold(0.0, f64::max);
    row.set_point_rests_s = rests_s;
    let [a, b] = [0, 1].map(|i: usize| judges[i].measures(&last[i], rests_s));
    let both = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a.max(b));
    row.step_fault = rig.failure();
    let worse = |a: SideMeasures, b: SideMeasures| SideMeasures {
        settled_s: both(a.settled_s, b.settled_s),
        rest_counts: a.rest_counts.max(b.rest_counts),
        is_success: a.is_success && b.is_success,
    };
    let sides = [worse(a.at_encoder, b.at_encoder), worse(a.at_load, b.at_load)];
    row.judge(sides, case.family.settles_within_s());
    (row.settled_s, row.rest_counts) = (row.settled_at_encoder_s, row.rest_at_encoder_counts);
    let hunting = if a.reversals >= b.reversals { &a } else { &b };
    row.reversals = hunting.reversals;
    row.swing_counts = hunting.swing_counts;
    row.period_s = hunting.period_s;
    row.variation_rest_per_s = a.variation_per_s.max(b.variation_per_s);
    row.held_effort = a.held_effort.max(b.held_effort);
    Ok(())
}

fn trajectory(
    row: &mut CaseResult,
    case: &Case,
    gains: &[ControllerGains],
    mut show: impl FnMut(f64, &CaseSample),
) -> Result<(), Error> {
    let h = case.bounds.sampled.sample_time;
    let TrackedTrajectory { reference, window, top } = assemble::trapezoid(case)?;
    let second = case.arm.as_ref().map_or(case.trapezoid, |arm| arm.trapezoid);
    let of_second = assemble::trapezoid_of(case, &second)?;
    let mut judges = [0, 1].map(|_| TrackingJudge::new(window, top));
    let mut rig = ArmRig::armed(case, gains)?;
    let follows = rig.follow([reference, of_second.reference]);
    for k in (0..=window[1]).take_while(|_| follows) {
        let samples = rig.step(case.count());
        if rig.fault().is_some() {
            break;
        }
        judges.iter_mut().zip(&samples).for_each(|(judge, sample)| judge.see(sample));
        show(f64::from(k) * h, &shown(samples));
    }
    let [a, b] = [0, 1].map(|i: usize| judges[i].measures(h));
    row.tracking_fault = rig.failure();
    let worse = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a.max(b) * case.count());
    row.tracking_rms = worse(a.rms_counts, b.rms_counts);
    row.tracking_at_encoder_rms = row.tracking_rms;
    row.tracking_at_load_rms = worse(a.load_rms_counts, b.load_rms_counts);
    row.sticks_in_motion = a.sticks.max(b.sticks);
    row.variation_motion_per_s = a.variation_per_s.max(b.variation_per_s);
    Ok(())
}
