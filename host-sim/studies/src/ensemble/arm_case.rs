//! An arm under one law at each joint: both step at once, and both follow a trajectory at once.
//!
//! A row of it is that of the worse joint in each measure, so a success is one of both.

use super::arm_rig::ArmRig;
use super::assemble::{self, Tracked};
use super::case::{Motion, Row, goal, near_counts};
use super::draw::Case;
use super::measures::{Sample, SideMeasures, StepJudge, TrackingJudge};
use super::rules::Tuned;
use crate::error::Error;

/// Runs step and trajectory. What is shown of a sample is the first joint, and as the error of a
/// load that of the second.
///
/// # Errors
/// If the core refuses gains.
pub fn run(
    case: &Case,
    law: &str,
    tuned: &[Tuned],
    mut show: impl FnMut(Motion, f64, &Sample),
) -> Result<Row, Error> {
    let count = case.count();
    let mut row = Row {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        count,
        ..Row::default()
    };
    step(&mut row, case, tuned, |time_s, sample| show(Motion::Step, time_s, sample))?;
    trajectory(&mut row, case, tuned, |time_s, sample| show(Motion::Trajectory, time_s, sample))?;
    Ok(row)
}

/// Both joints as one sample.
fn shown([first, second]: [Sample; 2]) -> Sample {
    Sample { load_error: second.error, ..first }
}

fn step(
    row: &mut Row,
    case: &Case,
    tuned: &[Tuned],
    mut show: impl FnMut(f64, &Sample),
) -> Result<(), Error> {
    let h = case.told.sample_time;
    let samples = (case.family.duration_s() / h).round() as u32;
    let mut judges =
        [0, 1].map(|_| StepJudge::new(samples, near_counts(case), h).by(&goal(case), 1.0));
    let mut rig = ArmRig::armed(case, tuned)?;
    let second = case.arm.as_ref().map_or(0.0, |arm| arm.step);
    // A step is refused after a fault only, which the first tick tells.
    let _ = rig.follow([case.step, second].map(|to| assemble::step_to(to / case.count())));
    let mut last = [Sample::default(); 2];
    for k in 0..=samples {
        last = rig.tick(case.count());
        if rig.fault().is_some() {
            break;
        }
        judges.iter_mut().zip(&last).for_each(|(judge, sample)| judge.see(sample));
        show(f64::from(k) * h, &shown(last));
    }
    let [a, b] = [0, 1].map(|i: usize| judges[i].measures(&last[i]));
    let both = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a.max(b));
    row.step_fault = rig.fault().map(|fault| fault.describe().to_owned());
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
    row: &mut Row,
    case: &Case,
    tuned: &[Tuned],
    mut show: impl FnMut(f64, &Sample),
) -> Result<(), Error> {
    let h = case.told.sample_time;
    let Tracked { reference, window, top } = assemble::trapezoid(case)?;
    let second = case.arm.as_ref().map_or(case.trapezoid, |arm| arm.trapezoid);
    let of_second = assemble::trapezoid_of(case, &second)?;
    let mut judges = [0, 1].map(|_| TrackingJudge::new(window, top));
    let mut rig = ArmRig::armed(case, tuned)?;
    let follows = rig.follow([reference, of_second.reference]);
    for k in (0..=window[1]).take_while(|_| follows) {
        let samples = rig.tick(case.count());
        if rig.fault().is_some() {
            break;
        }
        judges.iter_mut().zip(&samples).for_each(|(judge, sample)| judge.see(sample));
        show(f64::from(k) * h, &shown(samples));
    }
    let [a, b] = [0, 1].map(|i: usize| judges[i].measures(h));
    row.tracking_fault = rig.fault().map(|fault| fault.describe().to_owned());
    let worse = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a.max(b) * case.count());
    row.tracking_rms = worse(a.rms_counts, b.rms_counts);
    row.tracking_at_encoder_rms = row.tracking_rms;
    row.tracking_at_load_rms = worse(a.load_rms_counts, b.load_rms_counts);
    row.sticks_in_motion = a.sticks.max(b.sticks);
    row.variation_motion_per_s = a.variation_per_s.max(b.variation_per_s);
    Ok(())
}
