//! Metrics of a run.
//!
//! Errors are the reference minus the *true* joint position, at the sampling instants. Keys are
//! those of the JSON output; `None` is `null`.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::both_sides::BothSides;
use crate::closed_loop::LoopSample;
use crate::experiment::Task;
use files::goal::PositionGoal;
use files::machine::{SineTable, TrajectoryTable};

/// Largest error of a settled joint, deg.
const SETTLED_DEG: f64 = 0.05;

/// Least distance that the joint moves back in a reversal, counts. A stuck joint of the banded
/// model moves by up to 8e-4 counts in a sample of the thesis's axis; that does not count as
/// motion.
const REVERSAL_COUNTS: f64 = 0.01;

/// Share of a sine's top speed below which its set point reverses.
pub const REVERSES: f64 = 0.2;

/// Least number of reversals of hunting; fewer are a transient.
const HUNTING_REVERSALS: usize = 4;

/// Metrics of one run of the axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunMetrics {
    /// Mean error of the last second, deg.
    pub steady_state_error_deg: Option<f64>,
    /// Error at the last sample, in counts.
    pub rest_error_counts: Option<f64>,
    /// Overshoot beyond the target of a step, deg.
    pub overshoot_deg: Option<f64>,
    /// Time from 10 % to 90 % of a step, s.
    pub rise_time_s: Option<f64>,
    /// Time after which a step stays within +-0.05 deg, or within the goal of the file if it has
    /// one, s.
    pub settling_time_s: Option<f64>,
    /// Root mean square of the error, deg: over the run of a step, or from the start of a
    /// trajectory's first blend to the end of its last, or after the first period of a sine.
    pub rms_error_deg: Option<f64>,
    /// Largest error over the same time as `rms_error_deg`, deg.
    pub max_error_deg: Option<f64>,
    /// Mean error from 2 s after the first corner to 0.5 s before the second, deg.
    pub cruise_error_deg: Option<f64>,
    /// Largest error at a reversal of a sine, deg: where its set point has less than a fifth of its
    /// top speed.
    pub reversal_error_deg: Option<f64>,
    /// Number of stops of the joint while the set point of a trajectory or a sine moves at more
    /// than half of its top speed: stair-like motion. Stops between two samples do not count.
    pub sticks_in_motion: Option<u32>,
    /// Peak-to-peak amplitude of hunting in the second half of the run of a step, deg.
    pub hunting_peak_to_peak_deg: Option<f64>,
    /// Period of hunting in the second half of the run of a step: twice the mean time between
    /// reversals, s.
    pub hunting_period_s: Option<f64>,
    /// Total variation of the D/A's output per second, V/s.
    pub control_total_variation_v_per_s: Option<f64>,
    /// Effort at which the joint broke away, V.
    pub stick_v: Option<f64>,
    /// Effort at which the joint stopped, V.
    pub slip_v: Option<f64>,
    /// Effort at which the joint stopped, without the lag of the axis, V.
    pub slip_corrected_v: Option<f64>,
    /// Rest, settling and success on both sides of the gear, by the goal of the file.
    #[serde(flatten)]
    pub sides: BothSides,
    /// `settling_time_s` at the encoder, s. A benchmark ranks by it if the encoder cannot see
    /// slack.
    #[serde(skip)]
    pub settling_time_at_encoder_s: Option<f64>,
}

impl RunMetrics {
    /// Returns the metrics of the samples of a run; at least one sample is needed. The results of a
    /// ramp are added elsewhere.
    pub fn of(moments: &[LoopSample], task: &Task, resolution_deg: f64) -> Self {
        let (Some(first), Some(last)) = (moments.first(), moments.last()) else {
            return Self::default();
        };
        let last_second = within(moments, [last.time_s - 1.0, last.time_s]);
        let mut metrics = Self {
            steady_state_error_deg: mean(errors(last_second)),
            rest_error_counts: Some(last.error_deg() / resolution_deg),
            control_total_variation_v_per_s: variation_per_s(moments),
            ..Self::default()
        };
        let judged = match task {
            Task::Step(step) => {
                let towards = step.signum();
                let beyond = moments.iter().map(|m| -m.error_deg() * towards).fold(0.0, f64::max);
                metrics.overshoot_deg = Some(beyond);
                metrics.rise_time_s = rise_time(moments, *step);
                metrics.settling_time_s = settling_time(moments, LoopSample::error_deg);
                metrics.settling_time_at_encoder_s =
                    settling_time(moments, |m| m.reference_deg - m.at_encoder_deg);
                let half_s = 0.5 * (first.time_s + last.time_s);
                if let Some((peak_to_peak, period)) = hunting(moments, half_s, resolution_deg) {
                    metrics.hunting_peak_to_peak_deg = Some(peak_to_peak);
                    metrics.hunting_period_s = Some(period);
                }
                moments
            }
            Task::Trajectory(trajectory) => {
                metrics.sticks_in_motion = Some(sticks_in_motion(moments));
                metrics.cruise_error_deg = mean(errors(within(moments, cruise_s(trajectory))));
                within(moments, trajectory.motion_s())
            }
            Task::Sine(SineTable { amplitude_deg, frequency_hz }) => {
                metrics.sticks_in_motion = Some(sticks_in_motion(moments));
                // A sine does not rest.
                (metrics.steady_state_error_deg, metrics.rest_error_counts) = (None, None);
                let judged = within(moments, [1.0 / frequency_hz, last.time_s]);
                let slow = (REVERSES * amplitude_deg * TAU * frequency_hz).abs() as f32;
                let turns = judged.iter().filter(|m| m.tick.reference_velocity.abs() < slow);
                metrics.reversal_error_deg = turns.map(|m| m.error_deg().abs()).reduce(f64::max);
                judged
            }
            Task::Ramp(_) => return Self::default(),
        };
        metrics.rms_error_deg = mean(errors(judged).map(|e| e * e)).map(f64::sqrt);
        metrics.max_error_deg = errors(judged).map(f64::abs).reduce(f64::max);
        metrics
    }

    /// Sets the verdicts of both sides. If the file has a goal, a step's settling times are those
    /// of the goal.
    pub fn judge(&mut self, sides: BothSides, task: &Task, goal: &PositionGoal) {
        self.sides = sides;
        if matches!(task, Task::Step(_)) && !goal.is_default() {
            self.settling_time_s = sides.settled_at_load_s;
            self.settling_time_at_encoder_s = sides.settled_at_encoder_s;
        }
    }
}

/// Returns whether a run is unstable: the error has exceeded ten times `span_deg` (the largest
/// distance of the motion from its start; 0: not checked), or the output is saturated with
/// alternating sign for more than half of the last second.
pub fn is_unstable(moments: &[LoopSample], span_deg: f64) -> bool {
    let Some(last) = moments.last() else { return false };
    let escaped = span_deg > 0.0 && moments.iter().any(|m| m.error_deg().abs() > 10.0 * span_deg);
    let last_second = within(moments, [last.time_s - 1.0, last.time_s]);
    let limits: Vec<f32> =
        last_second.iter().filter(|m| m.tick.saturated).map(|m| m.tick.v.signum()).collect();
    let alternates = limits.windows(2).any(|pair| pair[0] != pair[1]);
    escaped || (2 * limits.len() > last_second.len() && alternates)
}

/// Returns the time window of the cruise error, s.
fn cruise_s(trajectory: &TrajectoryTable) -> [f64; 2] {
    [corner_s(trajectory, 0) + 2.0, corner_s(trajectory, 1) - 0.5]
}

fn corner_s(trajectory: &TrajectoryTable, number: usize) -> f64 {
    trajectory.corner_times_s.get(number).copied().unwrap_or(0.0)
}

/// Returns the samples from one time to another, both included.
fn within(moments: &[LoopSample], [from_s, to_s]: [f64; 2]) -> &[LoopSample] {
    // Times are k h; a bound written as a decimal can differ in the last digit.
    const SAME_TIME_S: f64 = 1e-9;
    let begin = moments.partition_point(|m| m.time_s < from_s - SAME_TIME_S);
    let end = moments.partition_point(|m| m.time_s <= to_s + SAME_TIME_S);
    moments.get(begin..end).unwrap_or_default()
}

fn errors(moments: &[LoopSample]) -> impl Iterator<Item = f64> {
    moments.iter().map(LoopSample::error_deg)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}

fn variation_per_s(moments: &[LoopSample]) -> Option<f64> {
    let duration_s = moments.last()?.time_s - moments.first()?.time_s;
    let variation: f64 =
        moments.windows(2).map(|pair| (pair[1].applied_v - pair[0].applied_v).abs()).sum();
    (duration_s > 0.0).then(|| variation / duration_s)
}

/// Returns the time from 10 % to 90 % of the step, s, with crossings interpolated between samples.
fn rise_time(moments: &[LoopSample], step: f64) -> Option<f64> {
    let crossing = |part: f64| {
        moments.windows(2).find_map(|pair| {
            let [before, after] = [0, 1].map(|i| pair[i].position_deg / step);
            let part_of_sample = (part - before) / (after - before);
            (before < part && after >= part)
                .then(|| pair[0].time_s + part_of_sample * (pair[1].time_s - pair[0].time_s))
        })
    };
    Some(crossing(0.9)? - crossing(0.1)?)
}

fn sticks_in_motion(moments: &[LoopSample]) -> u32 {
    let speed = |m: &LoopSample| m.tick.reference_velocity.abs();
    let top = moments.iter().map(speed).fold(0.0, f32::max);
    let sticks = moments
        .windows(2)
        .filter(|pair| speed(&pair[1]) > 0.5 * top && pair[1].stuck && !pair[0].stuck);
    sticks.count() as u32
}

fn settling_time(moments: &[LoopSample], error_deg: impl Fn(&LoopSample) -> f64) -> Option<f64> {
    let unsettled = moments.iter().rposition(|m| error_deg(m).abs() > SETTLED_DEG);
    let settled = moments.get(unsettled.map_or(0, |i| i + 1))?;
    Some(settled.time_s - moments.first()?.time_s)
}

/// Returns peak-to-peak amplitude (deg) and period (s) of a joint that hunts after `from_s`.
fn hunting(moments: &[LoopSample], from_s: f64, resolution_deg: f64) -> Option<(f64, f64)> {
    // Over the whole run: whether the first motion after `from_s` is a reversal depends on the
    // motion before it.
    let mut turns = reversals(moments, REVERSAL_COUNTS * resolution_deg);
    turns.retain(|turn_s| *turn_s >= from_s);
    if turns.len() < HUNTING_REVERSALS {
        return None;
    }
    let positions = || moments.iter().filter(|m| m.time_s >= from_s).map(|m| m.position_deg);
    let peak_to_peak = positions().reduce(f64::max)? - positions().reduce(f64::min)?;
    let between = (turns.last()? - turns.first()?) / (turns.len() - 1) as f64;
    Some((peak_to_peak, 2.0 * between))
}

/// Returns the times of reversals: the joint has come back from its extreme by more than
/// `hysteresis`, deg.
fn reversals(moments: &[LoopSample], hysteresis: f64) -> Vec<f64> {
    let mut turns = Vec::new();
    let Some(first) = moments.first() else { return turns };
    let (mut direction, mut extreme) = (0.0, first.position_deg);
    for moment in moments {
        let travelled = moment.position_deg - extreme;
        if direction == 0.0 {
            if travelled.abs() <= hysteresis {
                continue;
            }
            direction = travelled.signum();
        } else if travelled * direction < -hysteresis {
            turns.push(moment.time_s);
            direction = -direction;
        } else if travelled * direction <= 0.0 {
            continue;
        }
        extreme = moment.position_deg;
    }
    turns
}
