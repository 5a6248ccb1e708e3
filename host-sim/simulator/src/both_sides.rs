//! The end of a motion on both sides of the gear: at the encoder, which the controller sees, and at
//! the load, which is what a user positions.
//!
//! ```text
//! e_encoder = r - x_encoder      e_load = r - x_load
//! ```
//!
//! Both positions are zero where the gear is in the middle of its slack and not wound up. With the
//! encoder on the load, or a rigid gear, both errors are the same. Each side is judged by the
//! file's `[goal]` ([`Settling`]), from the time on at which the set point rests.

use serde::Serialize;

use crate::closed_loop::LoopSample;
use crate::experiment::Task;
use crate::settling::Settling;
use files::goal::PositionGoal;

/// Largest time difference that counts as rounding, s.
const SAME_TIME_S: f64 = 1e-9;

/// Rest, settling and success of a motion at the encoder and at the load. All are `None` for a
/// ramp, and for a run that ends before its set point rests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BothSides {
    /// Reference minus position of the encoder at the last sample, counts.
    pub rest_at_encoder_counts: Option<f64>,
    /// Reference minus position of the load at the last sample, counts.
    pub rest_at_load_counts: Option<f64>,
    /// Time from the end of the set point's motion until the encoder's side is within the goal's
    /// tolerance and stays there, s.
    pub settled_at_encoder_s: Option<f64>,
    /// Time from the end of the set point's motion until the load is within the goal's tolerance
    /// and stays there, s.
    pub settled_at_load_s: Option<f64>,
    /// Whether the encoder's side met the goal.
    pub success_at_encoder: Option<bool>,
    /// Whether the load met the goal.
    pub success_at_load: Option<bool>,
}

impl BothSides {
    /// Judges the samples of a closed loop; one count of the encoder is `count_deg`, deg.
    pub fn of(moments: &[LoopSample], task: &Task, goal: &PositionGoal, count_deg: f64) -> Self {
        let (Some(first), Some(last)) = (moments.first(), moments.last()) else {
            return Self::default();
        };
        let end_s = match task {
            Task::Step(_) => first.time_s,
            Task::Trajectory(trajectory) => trajectory.motion_s()[1],
            // Neither has a set point that comes to rest.
            Task::Sine(_) | Task::Ramp(_) => return Self::default(),
        };
        let errors = |moment: &LoopSample| {
            let of = |position_deg: f64| (moment.reference_deg - position_deg) / count_deg;
            [of(moment.at_encoder_deg), of(moment.at_load_deg)]
        };
        let rest = errors(last);
        let begin = moments.partition_point(|moment| moment.time_s < end_s - SAME_TIME_S);
        let mut sides = [Settling::new(goal, count_deg); 2];
        for moment in moments.iter().skip(begin) {
            for (side, error) in sides.iter_mut().zip(errors(moment)) {
                side.see(moment.time_s, error);
            }
        }
        let is_judged = begin < moments.len();
        let settled = sides.map(|side| side.settled_s().map(|at_s| (at_s - end_s).max(0.0)));
        let success = sides.map(|side| is_judged.then(|| side.is_success(end_s)));
        Self {
            rest_at_encoder_counts: Some(rest[0]),
            rest_at_load_counts: Some(rest[1]),
            settled_at_encoder_s: settled[0],
            settled_at_load_s: settled[1],
            success_at_encoder: success[0],
            success_at_load: success[1],
        }
    }

    /// Marks a motion as failed, after a fault, a divergence or an unstable loop.
    pub fn fail(&mut self) {
        for success in [&mut self.success_at_encoder, &mut self.success_at_load] {
            *success = success.map(|_| false);
        }
    }

    /// Returns a copy with absolute errors.
    #[must_use]
    pub fn magnitude(self) -> Self {
        Self {
            rest_at_encoder_counts: self.rest_at_encoder_counts.map(f64::abs),
            rest_at_load_counts: self.rest_at_load_counts.map(f64::abs),
            ..self
        }
    }

    /// Returns the worse of two motions, value by value: the larger absolute errors, the later
    /// times, and success only if both succeed. Not settling is later than any time.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        let larger = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.abs().max(b.abs())),
            (a, b) => a.or(b).map(f64::abs),
        };
        let later = |a: Option<f64>, b: Option<f64>| Some(a?.max(b?));
        let both = |a: Option<bool>, b: Option<bool>| match (a, b) {
            (Some(a), Some(b)) => Some(a && b),
            (a, b) => a.or(b),
        };
        Self {
            rest_at_encoder_counts: larger(
                self.rest_at_encoder_counts,
                other.rest_at_encoder_counts,
            ),
            rest_at_load_counts: larger(self.rest_at_load_counts, other.rest_at_load_counts),
            settled_at_encoder_s: later(self.settled_at_encoder_s, other.settled_at_encoder_s),
            settled_at_load_s: later(self.settled_at_load_s, other.settled_at_load_s),
            success_at_encoder: both(self.success_at_encoder, other.success_at_encoder),
            success_at_load: both(self.success_at_load, other.success_at_load),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::machine::TrajectoryTable;
    use stiction::Tick;

    const COUNT_DEG: f64 = 0.01;

    /// A second of samples every 10 ms; the encoder is off by the first number of counts and the
    /// load by the second.
    fn moments(off: impl Fn(f64) -> [f64; 2]) -> Vec<LoopSample> {
        let moment = |k| {
            let time_s = f64::from(k) * 0.01;
            let [encoder, load] = off(time_s).map(|counts| 5.0 - counts * COUNT_DEG);
            LoopSample {
                time_s,
                tick: Tick::default(),
                reference_deg: 5.0,
                position_deg: load,
                at_encoder_deg: encoder,
                at_load_deg: load,
                motor_counts: None,
                velocity_deg_per_s: 0.0,
                applied_v: 0.0,
                stuck: false,
            }
        };
        (0..=100).map(moment).collect()
    }

    fn near(value: Option<f64>, expected: f64) -> bool {
        value.is_some_and(|value| (value - expected).abs() < 1e-9)
    }

    #[test]
    fn a_step_is_judged_on_each_side_alone() {
        let moments = moments(|s| if s < 0.295 { [500.0; 2] } else { [1.0, -40.0] });
        let goal = PositionGoal::default();
        let sides = BothSides::of(&moments, &Task::Step(5.0), &goal, COUNT_DEG);
        assert!(near(sides.rest_at_encoder_counts, 1.0) && near(sides.rest_at_load_counts, -40.0));
        assert!(near(sides.settled_at_encoder_s, 0.3) && sides.settled_at_load_s.is_none());
        assert_eq!((sides.success_at_encoder, sides.success_at_load), (Some(true), Some(false)));
        // A tolerance that the load keeps, and a time that neither does.
        let wide = PositionGoal { tolerance_deg: Some(0.4001), ..goal };
        let sides = BothSides::of(&moments, &Task::Step(5.0), &wide, COUNT_DEG);
        assert_eq!((sides.success_at_encoder, sides.success_at_load), (Some(true), Some(true)));
        let soon = PositionGoal { settle_s: Some(0.29), ..wide };
        let mut sides = BothSides::of(&moments, &Task::Step(5.0), &soon, COUNT_DEG);
        assert_eq!(sides.success_at_load, Some(false));
        assert!(near(sides.settled_at_load_s, 0.3));
        sides.fail();
        assert_eq!(sides.success_at_encoder, Some(false));
    }

    #[test]
    fn a_trajectory_is_judged_from_the_end_of_its_motion() {
        let trajectory = |end_s| TrajectoryTable {
            corner_times_s: vec![0.1, end_s],
            corner_positions_deg: vec![0.0, 5.0],
            half_blend_s: 0.1,
        };
        // It rests before it begins, and again 0.2 s after the end of the last blend at 0.5 s.
        let moments = moments(|s| if (0.1..0.695).contains(&s) { [9.0; 2] } else { [0.0, 2.0] });
        let goal = PositionGoal { hold_s: Some(0.05), ..PositionGoal::default() };
        let of =
            |end_s| BothSides::of(&moments, &Task::Trajectory(trajectory(end_s)), &goal, COUNT_DEG);
        let sides = of(0.4);
        assert!(near(sides.settled_at_encoder_s, 0.2) && near(sides.settled_at_load_s, 0.2));
        assert_eq!(sides.success_at_load, Some(true));
        // The run ends before the set point rests.
        assert_eq!(of(1.1).success_at_load, None);
    }

    #[test]
    fn the_worst_of_two_motions_is_their_larger_error_and_later_time() {
        let good = BothSides {
            rest_at_encoder_counts: Some(-1.0),
            settled_at_encoder_s: Some(0.2),
            success_at_encoder: Some(true),
            ..BothSides::default()
        };
        let late = BothSides { settled_at_encoder_s: Some(0.5), ..good };
        assert!(near(good.worst(late).settled_at_encoder_s, 0.5));
        assert!(near(good.worst(late).rest_at_encoder_counts, 1.0));
        let never = BothSides {
            rest_at_encoder_counts: Some(9.0),
            settled_at_encoder_s: None,
            success_at_encoder: Some(false),
            ..BothSides::default()
        };
        let worst = good.worst(never);
        assert!(near(worst.rest_at_encoder_counts, 9.0) && worst.settled_at_encoder_s.is_none());
        assert_eq!((worst.success_at_encoder, worst.success_at_load), (Some(false), None));
    }
}
