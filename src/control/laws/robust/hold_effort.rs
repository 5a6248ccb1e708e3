//! The hold effort of a joint that springs back: it is stepped until the joint breaks away.
//!
//! A joint whose friction sits behind a spring (a gear, a bristle) goes back after each pulse. Only
//! an effort that stays moves it permanently. `u_b` is that effort, and `db` its step:
//!
//! ```text
//! step:   against the last step's sign  N_b = min(N_b + N_b / 2, cap), db = max(0.6 db, db_min)
//!         u_b += s db,  if |u_b + s db| <= most; otherwise a pulse
//! undo:   u_b -= s db,  db = max(db / 2, db_min)         the joint went beyond 2 |e_b| + 8 q
//! judge:  |m| < q / 2, or m > 8 q and m > 3 |e_b|        no spring after all: a pulse next
//!         m < 0.3 |e_b|:  db = min(1.3 db, 0.3 F_hi)      too small
//!         m > 1.2 |e_b|:  db = max(db / 2, db_min)        too large
//! ```
//!
//! A pulse has sprung back if the joint returned by a count at least, and by half of its way, and
//! rests short of half of the error. From the second time on, steps take over; from the third one
//! they grow, `db = min(1.4 db, 0.3 F_hi)`. After a pulse that moved the joint permanently, the
//! count of pulses that sprang back falls to one, never to zero: a joint that has sprung back once
//! can do it again.
//!
//! Why this form: the elastic range before sliding is some counts wide, so that steps of a few
//! hundredths of the friction move the joint by fractions of a count. Guarantees: no step exceeds
//! `most`. Does badly: the effort that remains in `u_b` heats the motor at rest.

use crate::units::saturation::bounded;

/// The bounds of the steps, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldEffort {
    /// First, smallest and largest step, V.
    pub first: f32,
    smallest: f32,
    largest: f32,
    /// The largest hold effort, V.
    pub most: f32,
    /// Angle of a count q, deg.
    count: f32,
    /// Ticks to wait after a step: at first, and at most.
    pub first_wait: u16,
    longest_wait: u16,
}

/// The hold effort, and the values learned from its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Hold effort u_b, V.
    pub effort: f32,
    /// Step db, V.
    pub step: f32,
    /// Sign of the last step; zero: there was none.
    last: f32,
    /// Ticks to wait after a step, N_b.
    pub wait: u16,
    /// Pulses after which the joint sprang back.
    returns: u8,
    /// Whether the next attempt is a step.
    pub springs: bool,
}

impl HoldEffort {
    /// Prepares the steps: the first one, the converter's step, the range of breakaway efforts and
    /// the largest hold effort, all in V, the angle of a count in deg, and the waits in ticks.
    pub fn new(
        [first, lsb]: [f32; 2],
        [low, high]: [f32; 2],
        most: f32,
        count: f32,
        [first_wait, longest_wait]: [u16; 2],
    ) -> Self {
        Self {
            first,
            smallest: lsb.max(0.03 * low),
            largest: 0.3 * high,
            most,
            count,
            first_wait,
            longest_wait,
        }
    }

    /// Returns the initial state for a hold effort, V.
    pub fn start(&self, effort: f32) -> Held {
        let effort = bounded(effort, self.most);
        Held { effort, step: self.first, wait: self.first_wait, ..Held::default() }
    }

    /// Called when a move starts: the waits are short again, and the steps are no smaller than the
    /// first.
    pub fn begin_move(&self, held: &mut Held) {
        held.wait = self.first_wait;
        held.step = held.step.max(self.first);
    }

    /// Steps towards the sign of the error, if the joint springs and the effort allows it. Returns
    /// whether it did.
    #[inline]
    pub fn step(&self, held: &mut Held, sign: f32) -> bool {
        if !held.springs || (held.effort + sign * held.step).abs() > self.most {
            return false;
        }
        if held.last * sign < 0.0 {
            held.wait = held.wait.saturating_add(held.wait / 2).min(self.longest_wait);
            self.shrink(held, 0.6);
        }
        held.last = sign;
        held.effort += sign * held.step;
        true
    }

    /// Takes the last step back.
    pub fn undo(&self, held: &mut Held, sign: f32) {
        held.effort -= sign * held.step;
        self.shrink(held, 0.5);
    }

    /// Judges a step towards an error of `wanted` (deg, positive), after which the joint has
    /// moved by `moved`.
    pub fn judge(&self, held: &mut Held, wanted: f32, moved: f32) {
        if moved.abs() < 0.5 * self.count || moved > 8.0 * self.count && moved > 3.0 * wanted {
            held.springs = false;
        } else if moved < 0.3 * wanted {
            self.grow(held, 1.3);
        } else if moved > 1.2 * wanted {
            self.shrink(held, 0.5);
        }
    }

    /// Returns whether the joint sprang back after a pulse for an error of `wanted`: it went as far
    /// as `peak` towards the target, and rests at `moved` (deg).
    pub fn sprang_back(&self, held: &mut Held, wanted: f32, moved: f32, peak: f32) -> bool {
        let back = peak - moved;
        if !(back >= self.count && back >= 0.5 * peak && moved < 0.5 * wanted) {
            if peak >= 0.5 * self.count {
                held.returns = held.returns.min(1);
            }
            return false;
        }
        held.returns = held.returns.saturating_add(1);
        if held.returns >= 2 {
            held.springs = true;
        }
        if held.returns > 2 {
            self.grow(held, 1.4);
        }
        true
    }

    fn shrink(&self, held: &mut Held, factor: f32) {
        held.step = (factor * held.step).max(self.smallest);
    }

    fn grow(&self, held: &mut Held, factor: f32) {
        held.step = (factor * held.step).min(self.largest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps() -> HoldEffort {
        HoldEffort::new([1.0, 0.001], [2.0, 12.0], 9.6, 1.0, [20, 100])
    }

    fn springing() -> Held {
        Held { springs: true, ..steps().start(0.0) }
    }

    #[test]
    fn steps_lead_up_to_the_largest_effort_and_no_farther() {
        let (steps, mut held) = (steps(), springing());
        let taken = (0..20).filter(|_| steps.step(&mut held, 1.0)).count();
        assert_eq!((taken, held.effort), (9, 9.0));
        assert!(steps.step(&mut held, -1.0), "back is allowed");
        assert!((held.effort - 8.4).abs() < 1e-5 && held.wait == 30);
        // Eight steps to and fro: the smallest step is 0.03 of the low breakaway effort.
        for _ in 0..4 {
            assert!(steps.step(&mut held, 1.0) && steps.step(&mut held, -1.0));
        }
        assert_eq!((held.step, held.wait), (0.06, 100));
    }

    #[test]
    fn a_joint_that_does_not_spring_is_not_stepped() {
        let (steps, mut held) = (steps(), steps().start(0.0));
        assert!(!steps.step(&mut held, 1.0));
        assert_eq!(held, steps.start(0.0));
    }

    #[test]
    fn a_step_that_is_undone_leaves_the_effort_and_halves_the_step() {
        let (steps, mut held) = (steps(), springing());
        steps.step(&mut held, -1.0);
        steps.undo(&mut held, -1.0);
        assert_eq!((held.effort, held.step), (0.0, 0.5));
    }

    #[test]
    fn steps_are_judged_by_how_far_the_joint_went() {
        let judged = |wanted: f32, moved: f32| {
            let (steps, mut held) = (steps(), springing());
            steps.judge(&mut held, wanted, moved);
            (held.springs, held.step)
        };
        assert_eq!(judged(10.0, 0.4), (false, 1.0));
        assert_eq!(judged(10.0, 2.9), (true, 1.3));
        assert_eq!(judged(10.0, 3.1), (true, 1.0));
        assert_eq!(judged(10.0, 12.1), (true, 0.5));
        assert_eq!(judged(10.0, 30.1), (false, 1.0));
        assert_eq!(judged(1.0, 7.9), (true, 0.5), "eight counts are no jump");
    }

    #[test]
    fn a_joint_that_springs_back_twice_is_stepped_and_three_times_with_larger_steps() {
        let (steps, mut held) = (steps(), steps().start(0.0));
        // Out by 6, back to 3 of 10: half of the way, and less than half of the error.
        assert!(!steps.sprang_back(&mut held, 10.0, 3.1, 6.0));
        let found: [_; 3] = core::array::from_fn(|_| {
            assert!(steps.sprang_back(&mut held, 10.0, 3.0, 6.0));
            (held.springs, held.step)
        });
        assert_eq!(found, [(false, 1.0), (true, 1.0), (true, 1.4)]);
        // One pulse that stays leaves one of the three.
        assert!(!steps.sprang_back(&mut held, 10.0, 10.0, 10.0));
        held.springs = false;
        assert!(steps.sprang_back(&mut held, 10.0, 3.0, 6.0) && held.springs);
    }

    #[test]
    fn a_configured_hold_effort_is_bounded() {
        assert_eq!(steps().start(-5.0).effort, -5.0);
        assert_eq!(steps().start(50.0).effort, 9.6);
    }
}
