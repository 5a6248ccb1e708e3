//! Settling of a motion: when its error comes within the tolerance of a file's `[goal]` and stays
//! there.
//!
//! `run`, `benchmark`, `device move`, the self-test and the studio's prediction all use this
//! verdict. Errors are in counts, of either side of the gear.

use files::goal::PositionGoal;

/// Largest time difference that counts as rounding, s: k h can differ from the written decimal.
const SAME_TIME_S: f64 = 1e-9;

/// Verdict on one motion, sample by sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settling {
    tolerance_counts: f64,
    settle_s: Option<f64>,
    hold_s: Option<f64>,
    inside_since_s: Option<f64>,
    held: bool,
}

impl Settling {
    /// Starts a verdict by a goal; one count of the encoder is `count_deg`, deg.
    pub fn new(goal: &PositionGoal, count_deg: f64) -> Self {
        Self {
            tolerance_counts: goal.tolerance_counts(count_deg),
            settle_s: goal.settle_s,
            hold_s: goal.hold_s,
            inside_since_s: None,
            held: false,
        }
    }

    /// Evaluates the error (counts) at a time (s). Samples must be in the order of their times. NaN
    /// counts as outside.
    #[inline]
    pub fn see(&mut self, time_s: f64, error_counts: f64) {
        if self.held {
            return;
        }
        if error_counts.abs() <= self.tolerance_counts {
            let since_s = *self.inside_since_s.get_or_insert(time_s);
            self.held = self.hold_s.is_some_and(|hold_s| time_s - since_s >= hold_s - SAME_TIME_S);
        } else {
            self.inside_since_s = None;
        }
    }

    /// Restarts the verdict while the set point moves: errors within the tolerance on the way do
    /// not count.
    pub const fn restart(&mut self) {
        (self.inside_since_s, self.held) = (None, false);
    }

    /// Returns the time from which the error was within the tolerance and stayed there, s: for
    /// `hold_s`, or until the last sample if the goal has no `hold_s`. `None` if it did not.
    pub fn settled_s(&self) -> Option<f64> {
        self.inside_since_s.filter(|_| self.held || self.hold_s.is_none())
    }

    /// Returns whether the motion met the goal; `end_s` is the end of the set point's motion.
    pub fn is_success(&self, end_s: f64) -> bool {
        let in_time = |settled_s: f64| {
            self.settle_s.is_none_or(|most_s| settled_s - end_s <= most_s + SAME_TIME_S)
        };
        self.settled_s().is_some_and(in_time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Outside until 0.1 s, inside until 0.5 s, outside for one sample, inside until 1 s.
    fn judged(goal: PositionGoal) -> Settling {
        let mut settling = Settling::new(&goal, 0.01);
        for k in 0..=100 {
            let error = if k < 10 || k == 50 { -2.01 } else { 2.0 };
            settling.see(f64::from(k) * 0.01, error);
        }
        settling
    }

    #[test]
    fn the_default_goal_is_two_counts_until_the_end() {
        let settling = judged(PositionGoal::default());
        assert_eq!(settling.settled_s(), Some(0.51));
        assert!(settling.is_success(0.0));
        let mut left_again = settling;
        left_again.see(1.01, f64::NAN);
        assert_eq!((left_again.settled_s(), left_again.is_success(0.0)), (None, false));
    }

    #[test]
    fn a_tolerance_in_degrees_is_converted_by_the_count() {
        let wide = PositionGoal { tolerance_deg: Some(0.0202), ..PositionGoal::default() };
        assert_eq!(judged(wide).settled_s(), Some(0.0));
        let narrow = PositionGoal { tolerance_deg: Some(0.0199), ..PositionGoal::default() };
        assert_eq!(judged(narrow).settled_s(), None);
    }

    #[test]
    fn a_hold_time_ends_the_judgement_and_one_that_the_motion_is_too_short_for_fails_it() {
        let held = |hold_s| {
            judged(PositionGoal { hold_s: Some(hold_s), ..PositionGoal::default() }).settled_s()
        };
        // The first stay lasts from 0.10 s to 0.49 s, the second from 0.51 s to 1.00 s.
        assert_eq!(
            [held(0.39), held(0.4), held(0.49), held(0.5)],
            [Some(0.1), Some(0.51), Some(0.51), None]
        );
    }

    #[test]
    fn the_settle_time_counts_from_the_end_of_the_set_point() {
        let judged =
            |settle_s| judged(PositionGoal { settle_s: Some(settle_s), ..PositionGoal::default() });
        assert!(judged(0.51).is_success(0.0) && !judged(0.50).is_success(0.0));
        assert!(judged(0.11).is_success(0.4) && !judged(0.10).is_success(0.4));
        // Within the tolerance before the set point rests: settled at once.
        assert!(judged(1e-3).is_success(0.8));
    }
}
