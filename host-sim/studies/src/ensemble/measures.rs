//! Measures of a case, computed sample by sample: no samples are stored.
//!
//! Errors are the set point minus the *true* position, not quantised, in counts. Settling, rest and
//! tracking are judged at the encoder and at the load, all other measures at the encoder's side
//! only. Time zero is the first tick of the step, of the profiled move or of the trajectory.
//!
//! | measure | over | meaning |
//! |---|---|---|
//! | settled | the step | time from which the error stays within the goal's tolerance: 2 counts by default |
//! | near | the step | the same with the family's wider band |
//! | rest | last half of the step | largest error |
//! | hunting | last half of the step | at least 3 reversals: retreats of more than a count from the last extreme |
//! | variation | last half, or motion | total variation of the held effort per second |
//! | held effort | last half of the step | root mean square: its square is the motor's heat |
//! | tracking | from the start of the first blend to the end of the last | rms of the error |
//! | sticks | the same, while the set point has more than half of its top speed | number of stops |

use files::goal::{PositionGoal, TOLERANCE_COUNTS};
use simulator::settling::Settling;

/// Largest error with which a joint counts as at its target, counts.
pub const BAND_COUNTS: f64 = TOLERANCE_COUNTS;

/// Smallest number of reversals that counts as hunting.
pub const HUNTING_REVERSALS: u32 = 3;

/// Largest distance from its target at which a set point has arrived, counts: a profile has steps
/// of 2^-8.
const ARRIVED: f64 = 0.01;

/// Retreat from the last extreme beyond which a reversal is counted, counts.
const RETREAT_COUNTS: f64 = 1.0;

/// Ratios of the joint's speed to the set point's: below the first one a joint has stopped, and
/// from the second one on a stopped joint moves again.
const STOPPED: [f64; 2] = [0.1, 0.5];

/// A joint and its loop at one sampling instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CaseSample {
    /// Set point minus the true position at the encoder's side, counts.
    pub error: f64,
    /// Set point minus the true position of the load, counts.
    pub load_error: f64,
    /// True position at the encoder's side, counts; for a machine's file, the joint's own position.
    pub position: f64,
    /// Ratio of the true speed of the same side to the speed of the set point; 0 if that is zero.
    pub speed_ratio: f64,
    /// Set point's speed, counts a tick.
    pub speed: f64,
    /// Effort that is held until the next sample, in the unit of the joint.
    pub effort: f64,
}

/// Verdict on a step, sample by sample.
#[derive(Clone, Debug)]
pub struct StepJudge {
    half: u32,
    last: u32,
    k: u32,
    sample_time_s: f64,
    near: f64,
    /// Target of a set point that moves there, counts; `None` for a step.
    target: Option<f64>,
    rests_from: Option<u32>,
    far_until: Option<u32>,
    at_encoder: Settling,
    at_load: Settling,
    rest: f64,
    load_rest: f64,
    hunt: Reversals,
    effort: Variation,
    square: f64,
}

/// Measures of a step at one side of the gear.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SideMeasures {
    /// Time after which the error stays within the tolerance, s; `None` if it does not.
    pub settled_s: Option<f64>,
    /// Largest error in the last half, counts.
    pub rest_counts: f64,
    /// Whether this side met the goal.
    pub is_success: bool,
}

/// Measures of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepMeasures {
    /// Measures at the encoder's side.
    pub at_encoder: SideMeasures,
    /// Measures at the load.
    pub at_load: SideMeasures,
    /// Time after which the error at the encoder stays within the wider band, s; `None` if it does
    /// not.
    pub near_s: Option<f64>,
    /// Number of reversals in the last half.
    pub reversals: u32,
    /// Distance between the extremes in the last half, counts.
    pub swing_counts: f64,
    /// Twice the mean time between reversals, s; `None` with fewer than two.
    pub period_s: Option<f64>,
    /// Total variation of the effort in the last half, per second.
    pub variation_per_s: f64,
    /// Root mean square of the effort in the last half.
    pub held_effort: f64,
}

impl StepJudge {
    /// Creates the verdict on a step of `samples` samples after the first, `sample_time_s` apart.
    /// The goal is two counts without a time limit; `near` is the wider band, counts.
    pub fn new(samples: u32, near: f64, sample_time_s: f64) -> Self {
        let settling = Settling::new(&PositionGoal::default(), 1.0);
        Self {
            half: samples / 2,
            last: samples,
            k: 0,
            sample_time_s,
            near,
            target: None,
            rests_from: None,
            far_until: None,
            at_encoder: settling,
            at_load: settling,
            rest: 0.0,
            load_rest: 0.0,
            hunt: Reversals::default(),
            effort: Variation::default(),
            square: 0.0,
        }
    }

    /// Sets the target (counts) of a set point that moves there and then rests. Errors within the
    /// tolerance on the way do not count.
    #[must_use]
    pub const fn of_move_to(self, target: f64) -> Self {
        Self { target: Some(target), ..self }
    }

    /// Replaces the goal; one count of the encoder is `count_deg`, deg.
    #[must_use]
    pub fn by(self, goal: &PositionGoal, count_deg: f64) -> Self {
        let settling = Settling::new(goal, count_deg);
        Self { at_encoder: settling, at_load: settling, ..self }
    }

    /// Evaluates the next sample.
    #[inline]
    pub fn see(&mut self, sample: &CaseSample) {
        // NaN counts as an infinite error.
        let far = |error: f64| if error.is_nan() { f64::INFINITY } else { error.abs() };
        let error = far(sample.error);
        let has_arrived = self
            .target
            .is_none_or(|target| (sample.position + sample.error - target).abs() <= ARRIVED);
        if has_arrived {
            self.rests_from.get_or_insert(self.k);
        } else {
            self.rests_from = None;
        }
        if error > self.near || !has_arrived {
            self.far_until = Some(self.k);
        }
        let time_s = f64::from(self.k) * self.sample_time_s;
        for (side, error) in [(&mut self.at_encoder, error), (&mut self.at_load, sample.load_error)]
        {
            if has_arrived { side.see(time_s, error) } else { side.restart() }
        }
        if self.k >= self.half {
            self.rest = self.rest.max(error);
            self.load_rest = self.load_rest.max(far(sample.load_error));
            self.hunt.see(self.k, sample.position);
            self.effort.see(sample.effort);
            self.square += sample.effort * sample.effort;
        }
        self.k += 1;
    }

    /// Returns the time at which the set point came to rest at its target, s; 0 for a step.
    pub fn rests_s(&self) -> f64 {
        self.rests_from.map_or(0.0, |k| f64::from(k) * self.sample_time_s)
    }

    /// Returns the measures; the set point rested from `rests_s` on. A run that ended early has not
    /// settled, and its rest error is at least its last error.
    pub fn measures(&self, last: &CaseSample, rests_s: f64) -> StepMeasures {
        let is_whole = self.k > self.last;
        let sample_time_s = self.sample_time_s;
        let after = |k: u32| f64::from(k + 1) * sample_time_s;
        let samples = f64::from(self.k.saturating_sub(self.half).max(1));
        let far = |rest: f64, error: f64| if is_whole { rest } else { rest.max(error.abs()) };
        let side = |settling: &Settling, rest: f64, error: f64| SideMeasures {
            settled_s: settling.settled_s().filter(|_| is_whole),
            rest_counts: far(rest, error),
            is_success: is_whole && settling.is_success(rests_s),
        };
        StepMeasures {
            at_encoder: side(&self.at_encoder, self.rest, last.error),
            at_load: side(&self.at_load, self.load_rest, last.load_error),
            near_s: (is_whole && self.far_until != Some(self.last))
                .then(|| self.far_until.map_or(0.0, after)),
            reversals: self.hunt.count,
            swing_counts: self.hunt.swing(),
            period_s: self.hunt.period().map(|ticks| ticks * sample_time_s),
            variation_per_s: self.effort.total / ((samples - 1.0).max(1.0) * sample_time_s),
            held_effort: (self.square / samples).sqrt(),
        }
    }
}

/// Verdict on a trajectory between two ticks, sample by sample.
#[derive(Clone, Debug)]
pub struct TrackingJudge {
    window: [u32; 2],
    top: f64,
    k: u32,
    square: f64,
    load_square: f64,
    seen: u32,
    has_stopped: bool,
    sticks: u32,
    effort: Variation,
}

/// Measures of a trajectory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackingMeasures {
    /// Root mean square of the error at the encoder, counts; none if the motion ended early.
    pub rms_counts: Option<f64>,
    /// The same at the load, counts.
    pub load_rms_counts: Option<f64>,
    /// Number of stops on the way.
    pub sticks: u32,
    /// Total variation of the effort, per second.
    pub variation_per_s: f64,
}

impl TrackingJudge {
    /// Creates the verdict on the ticks from the first of `window` to the last. The largest speed
    /// of the set point is `top` counts a tick.
    pub fn new(window: [u32; 2], top: f64) -> Self {
        Self {
            window,
            top,
            k: 0,
            square: 0.0,
            load_square: 0.0,
            seen: 0,
            // The joint starts at rest: the first stop is after the first motion.
            has_stopped: true,
            sticks: 0,
            effort: Variation::default(),
        }
    }

    /// Evaluates the next sample.
    #[inline]
    pub fn see(&mut self, sample: &CaseSample) {
        if (self.window[0]..=self.window[1]).contains(&self.k) {
            self.square += sample.error * sample.error;
            self.load_square += sample.load_error * sample.load_error;
            self.seen += 1;
            self.effort.see(sample.effort);
            if sample.speed.abs() > 0.5 * self.top {
                let was_stopped = self.has_stopped;
                self.has_stopped =
                    sample.speed_ratio < if was_stopped { STOPPED[1] } else { STOPPED[0] };
                self.sticks += u32::from(self.has_stopped && !was_stopped);
            } else {
                self.has_stopped = true;
            }
        }
        self.k += 1;
    }

    /// Returns the measures; samples are `sample_time_s` apart.
    pub fn measures(&self, sample_time_s: f64) -> TrackingMeasures {
        let is_whole = self.k > self.window[1];
        let samples = f64::from(self.seen.max(1));
        let rms = |square: f64| is_whole.then(|| (square / samples).sqrt());
        TrackingMeasures {
            rms_counts: rms(self.square),
            load_rms_counts: rms(self.load_square),
            sticks: self.sticks,
            variation_per_s: self.effort.total / ((samples - 1.0).max(1.0) * sample_time_s),
        }
    }
}

/// Counter of the changes of direction of a motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reversals {
    range: Option<[f64; 2]>,
    direction: f64,
    extreme: f64,
    count: u32,
    first: u32,
    last: u32,
}

impl Reversals {
    /// Evaluates the position (counts) at tick `k`.
    #[inline]
    pub(crate) fn see(&mut self, k: u32, position: f64) {
        let Some([low, high]) = &mut self.range else {
            (self.range, self.extreme) = (Some([position; 2]), position);
            return;
        };
        (*low, *high) = (low.min(position), high.max(position));
        if self.direction == 0.0 {
            // The first retreat from either extreme determines the direction.
            let (below, above) = (*high - position, position - *low);
            if below.max(above) > RETREAT_COUNTS {
                (self.direction, self.extreme) = ((above - below).signum(), position);
            }
            return;
        }
        let travelled = position - self.extreme;
        if travelled * self.direction > 0.0 {
            self.extreme = position;
        } else if travelled.abs() > RETREAT_COUNTS {
            (self.direction, self.extreme) = (-self.direction, position);
            self.first = if self.count == 0 { k } else { self.first };
            self.last = k;
            self.count += 1;
        }
    }

    /// Returns the number of reversals.
    pub(crate) const fn count(&self) -> u32 {
        self.count
    }

    fn swing(&self) -> f64 {
        self.range.map_or(0.0, |[low, high]| high - low)
    }

    /// Returns twice the mean time between reversals, ticks.
    fn period(&self) -> Option<f64> {
        let between = self.count.checked_sub(1).filter(|between| *between > 0)?;
        Some(2.0 * f64::from(self.last - self.first) / f64::from(between))
    }
}

/// Total variation.
#[derive(Clone, Copy, Debug, Default)]
struct Variation {
    before: Option<f64>,
    total: f64,
}

impl Variation {
    #[inline]
    fn see(&mut self, value: f64) {
        self.total += self.before.map_or(0.0, |before| (value - before).abs());
        self.before = Some(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.01;

    /// Returns the measures of a step of 1000 counts, from 1000 samples. `error` is the error
    /// (counts) at a time (s); the position is 1000 counts less the error.
    fn stepped(error: impl Fn(f64) -> f64) -> StepMeasures {
        let sample = |k: u32| {
            let error = error(f64::from(k) * H);
            CaseSample {
                error,
                load_error: -2.0 * error,
                position: 1000.0 - error,
                ..CaseSample::default()
            }
        };
        let mut judge = StepJudge::new(1000, 20.0, H);
        (0..=1000).for_each(|k| judge.see(&sample(k)));
        judge.measures(&sample(1000), 0.0)
    }

    #[test]
    fn settled_is_the_first_sample_after_the_last_one_outside_of_two_counts() {
        // 100 exp(-t) is 2 at ln 50 = 3.912 s: 391 is outside, 392 is the first one within.
        assert_eq!(stepped(|t| 100.0 * (-t).exp()).at_encoder.settled_s, Some(392.0 * H));
        // 100 exp(-t) is 20 at ln 5 = 1.609 s.
        assert_eq!(stepped(|t| 100.0 * (-t).exp()).near_s, Some(161.0 * H));
        assert_eq!(stepped(|_| 20.001).near_s, None);
        assert_eq!(stepped(|_| -20.0).near_s, Some(0.0));
        // Exactly two counts are within, a little more is not.
        assert_eq!(stepped(|_| 2.0).at_encoder.settled_s, Some(0.0));
        assert_eq!(stepped(|_| -2.000_001).at_encoder.settled_s, None);
        // An error that leaves again at the very end has not settled; one that comes back has,
        // late.
        assert_eq!(stepped(|t| if t > 9.995 { 2.1 } else { 0.0 }).at_encoder.settled_s, None);
        let late = stepped(|t| if (8.995..9.005).contains(&t) { 2.1 } else { 0.0 });
        assert_eq!(late.at_encoder.settled_s, Some(901.0 * H));
        assert_eq!(stepped(|_| f64::NAN).at_encoder.settled_s, None);
    }

    /// The load's error is twice the encoder's: 200 exp(-t) is 2 at ln 100 = 4.605 s.
    #[test]
    fn each_side_settles_by_its_own_error_and_within_the_tolerance_of_a_goal() {
        let found = stepped(|t| 100.0 * (-t).exp());
        assert_eq!(found.at_encoder.settled_s, Some(392.0 * H));
        assert_eq!(found.at_load.settled_s, Some(461.0 * H));
        let judged = |goal: &PositionGoal| {
            let mut judge = StepJudge::new(1000, 20.0, H).by(goal, 0.1);
            for k in 0..=1000 {
                let error = 100.0 * (-f64::from(k) * H).exp();
                judge.see(&CaseSample { error, load_error: 2.0 * error, ..CaseSample::default() });
            }
            judge.measures(&CaseSample::default(), 0.0)
        };
        // 1 deg is 10 counts: ln 10 = 2.303 s, and ln 20 = 2.996 s at the load.
        let goal = PositionGoal { tolerance_deg: Some(1.0), ..PositionGoal::default() };
        let found = judged(&goal);
        assert_eq!(found.at_encoder.settled_s, Some(231.0 * H));
        assert_eq!(found.at_load.settled_s, Some(300.0 * H));
        let in_time = judged(&PositionGoal { settle_s: Some(2.5), ..goal });
        assert!(in_time.at_encoder.is_success && !in_time.at_load.is_success, "{in_time:?}");
    }

    /// A joint that follows its set point is within two counts all the way; it has settled when the
    /// set point rests on the target, and in time if that is not too late.
    #[test]
    fn what_is_within_the_tolerance_on_the_way_of_the_set_point_does_not_count() {
        let goal = PositionGoal { settle_s: Some(1.0), ..PositionGoal::default() };
        let mut judge = StepJudge::new(1000, 20.0, H).by(&goal, 1.0).of_move_to(500.0);
        for k in 0..=1000 {
            let (set_point, error) = (f64::from(k.min(250)) * 2.0, if k < 300 { 1.9 } else { 0.5 });
            judge.see(&CaseSample { error, position: set_point - error, ..CaseSample::default() });
        }
        assert!((judge.rests_s() - 250.0 * H).abs() < 1e-9);
        let found = judge.measures(&CaseSample::default(), judge.rests_s());
        assert_eq!(found.at_encoder.settled_s, Some(250.0 * H));
        assert!(found.at_encoder.is_success);
        // 2.5 s from the start are too late for a step.
        assert!(!judge.measures(&CaseSample::default(), 0.0).at_encoder.is_success);
    }

    #[test]
    fn rest_is_the_largest_error_of_the_last_half_of_either_side() {
        let found = stepped(|t| if t < 4.995 { 50.0 } else { -1.5 });
        assert_eq!((found.at_encoder.rest_counts, found.at_load.rest_counts), (1.5, 3.0));
        let found = stepped(|t| if t < 5.005 { 50.0 } else { -1.5 });
        assert_eq!(found.at_encoder.rest_counts, 50.0);
    }

    #[test]
    fn a_run_that_ends_early_is_not_settled_and_rests_where_it_was() {
        let mut judge = StepJudge::new(1000, 20.0, H);
        let at = |error| CaseSample { error, ..CaseSample::default() };
        (0..=999).for_each(|_| judge.see(&at(0.5)));
        let found = judge.measures(&at(7.0), 0.0);
        assert_eq!((found.at_encoder.settled_s, found.at_encoder.rest_counts), (None, 7.0));
        judge.see(&at(0.5));
        assert_eq!(judge.measures(&at(7.0), 0.0).at_encoder.settled_s, Some(0.0));
    }

    #[test]
    fn hunting_is_counted_in_retreats_of_more_than_a_count() {
        use std::f64::consts::TAU;
        // A sine of 1 Hz turns twice a second, ten times in the last five: the first turn only
        // determines the direction if the joint moved less than a count before it.
        let hunting = |amplitude: f64| stepped(|t| amplitude * (TAU * t).sin());
        let found = hunting(3.0);
        assert!((9..=10).contains(&found.reversals), "{found:?}");
        assert!((found.swing_counts - 6.0).abs() < 0.02, "{found:?}");
        assert!((found.period_s.unwrap() - 1.0).abs() < 0.02, "{found:?}");
        // Peak to peak 0.98 counts is no reversal, 1.02 is one each.
        assert_eq!(hunting(0.49).reversals, 0);
        assert!(hunting(0.52).reversals >= 8);
        // A joint that creeps one way, however far, has none.
        assert_eq!(stepped(|t| 100.0 * t).reversals, 0);
        // Nor does one that turned before the last half.
        assert_eq!(stepped(|t| if t < 4.9 { 9.0 * (TAU * t).sin() } else { 0.0 }).reversals, 0);
    }

    #[test]
    fn variation_and_heat_of_the_effort_are_those_of_the_last_half() {
        let mut judge = StepJudge::new(1000, 20.0, H);
        let effort = |k: u32| if k < 500 { 99.0 } else { f64::from(k % 2) * 3.0 };
        for k in 0..=1000 {
            judge.see(&CaseSample { effort: effort(k), ..CaseSample::default() });
        }
        let found = judge.measures(&CaseSample::default(), 0.0);
        // 500 changes of 3 in 5 s; half of 501 samples have 3^2, within one.
        assert!((found.variation_per_s - 300.0).abs() < 1e-9, "{found:?}");
        assert!((found.held_effort - (4.5f64).sqrt()).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn tracking_is_judged_within_its_window_and_a_stop_counts_once() {
        let window = [100, 299];
        let run = |samples: u32, ratio: &dyn Fn(u32) -> f64| {
            let mut judge = TrackingJudge::new(window, 1.0);
            for k in 0..samples {
                let is_on = (150..250).contains(&k);
                judge.see(&CaseSample {
                    error: if (100..300).contains(&k) { 3.0 } else { 99.0 },
                    load_error: if (100..300).contains(&k) { -1.0 } else { 99.0 },
                    speed: if is_on { 1.0 } else { 0.4 },
                    speed_ratio: ratio(k),
                    ..CaseSample::default()
                });
            }
            judge.measures(H)
        };
        assert_eq!(
            run(400, &|_| 1.0),
            TrackingMeasures {
                rms_counts: Some(3.0),
                load_rms_counts: Some(1.0),
                sticks: 0,
                variation_per_s: 0.0
            }
        );
        assert_eq!(run(299, &|_| 1.0).rms_counts, None);
        // Two stops at speed; one in a blend does not count, nor does a joint that only slows down,
        // nor one that never sets out.
        let stops = |k: u32| if [120, 170, 171, 172, 200].contains(&k) { 0.05 } else { 1.0 };
        assert_eq!(run(400, &stops).sticks, 2);
        assert_eq!(run(400, &|k| if k == 170 { 0.11 } else { 1.0 }).sticks, 0);
        assert_eq!(run(400, &|_| 0.0).sticks, 0);
        // A joint that trembles about the lower bound has stopped once.
        let trembles = |k: u32| if k < 170 { 1.0 } else { 0.09 + 0.02 * f64::from(k % 2) };
        assert_eq!(run(400, &trembles).sticks, 1);
    }
}
