//! A slow push: it distinguishes a load that is blocked from one that needs a larger bump.
//!
//! After four attempts in a row that moved the load by no count, the motor pushes with an effort
//! that grows slowly:
//!
//! ```text
//! u = u_b + s a,    a from 0 to 1.5 F_hi + u_L in 0.2 s,  then for 20 ms more
//! ```
//!
//! At that speed the motor is almost at rest, so the effort less the motor's own friction is in the
//! gear. The friction of both sides together is no more than `F_hi`. So a load that has not moved
//! by then is held by something else, and the law gives up. A load that moves shows the twist at
//! which it breaks away ([`twist_levels`](super::twist_levels)), and the motor draws back at once.
//!
//! Guarantees: the effort never exceeds that limit; the time is bounded. Does badly: a load that
//! moves jumps as far as its gear was wound up for, as in any slow motion; the law gives up on a
//! joint with more friction than `F_hi`. With noise, a load that moves by no more than its jitter
//! counts as at rest.

/// Number of attempts in a row without travel, after which the next attempt is a push.
const ATTEMPTS: u8 = 4;

/// Time in which the effort grows, and for which it is held, s.
const GROWS_S: f32 = 0.2;
const HELD_S: f32 = 0.02;

/// Least number of ticks for which the effort is held: two samples of delay, and the time that a
/// load needs to show a count.
const LEAST_TICKS: u16 = 8;

/// Pushes, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Effort that moves every free load, V.
    strong: f32,
    /// Increase of the effort in a tick, V.
    step: f32,
    held_ticks: u16,
    /// Travel from which a load moves under a push, deg: 1.5 counts and the jitter.
    moves: f32,
    /// Travel beyond which an attempt has moved the load, deg: half a count and the jitter.
    moved: f32,
}

/// The push that runs, and the attempts before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PushState {
    /// Effort a, V.
    effort: f32,
    /// Ticks with the whole effort.
    held: u16,
    /// Attempts in a row without travel.
    without: u8,
}

/// Result of a tick of a push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pushed {
    /// The push goes on with this effort, V.
    On(f32),
    /// The load has moved.
    Moved,
    /// The load does not move.
    Blocked,
}

impl Push {
    /// Prepares pushes up to an effort (V) for ticks of `sample_time` (s), for a load whose count
    /// has an angle (deg), with its jitter (counts).
    pub const fn new(strong: f32, sample_time: f32, count: f32, jitter: f32) -> Self {
        let held = (HELD_S / sample_time + 0.5) as u16;
        Self {
            strong,
            step: strong * sample_time / GROWS_S,
            held_ticks: if held > LEAST_TICKS { held } else { LEAST_TICKS },
            moves: (1.5 + jitter) * count,
            moved: (0.5 + jitter) * count,
        }
    }

    /// Runs a tick of a push. `moved` is the travel of the load since its rest, deg towards the
    /// target.
    pub fn update(&self, push: &mut PushState, moved: f32) -> Pushed {
        if moved >= self.moves {
            return Pushed::Moved;
        }
        push.effort = (push.effort + self.step).min(self.strong);
        if push.effort >= self.strong {
            push.held = push.held.saturating_add(1);
            if push.held > self.held_ticks {
                return Pushed::Blocked;
            }
        }
        Pushed::On(push.effort)
    }

    /// Updates the number of attempts without travel, after an attempt in which the load moved by
    /// `peak` at most (deg).
    pub fn judge(&self, push: &mut PushState, peak: f32) {
        push.without = if peak >= self.moved { 0 } else { push.without.saturating_add(1) };
    }
}

impl PushState {
    /// Returns whether the next attempt is a push.
    pub const fn is_due(&self) -> bool {
        self.without >= ATTEMPTS
    }

    /// Starts a push.
    pub fn begin(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 18 V in 200 ticks, then 20 more; a count is 1 deg.
    const PUSH: Push = Push::new(18.0, 0.001, 1.0, 0.0);

    #[test]
    fn fourth_attempt_in_a_row_without_travel_lets_it_push() {
        let mut push = PushState::default();
        let mut due_after = |with: &Push, peaks: &[f32]| {
            push = PushState::default();
            peaks.iter().for_each(|peak| with.judge(&mut push, *peak));
            push.is_due()
        };
        assert!(due_after(&PUSH, &[0.4; 4]) && !due_after(&PUSH, &[0.4; 3]));
        assert!(!due_after(&PUSH, &[0.4, 0.4, 0.6, 0.4, 0.4, 0.4]));
        let noisy = Push::new(18.0, 0.001, 1.0, 2.0);
        assert!(due_after(&noisy, &[2.4; 4]) && !due_after(&noisy, &[2.6; 4]));
    }

    #[test]
    fn load_that_does_not_move_under_the_whole_effort_is_blocked() {
        let mut push = PushState::default();
        let mut efforts = std::vec::Vec::new();
        while let Pushed::On(effort) = PUSH.update(&mut push, 1.4) {
            efforts.push(effort);
        }
        // 0.09 V a tick.
        assert!((efforts[99] - 9.0).abs() < 1e-3);
        assert!((219..=221).contains(&efforts.len()), "{}", efforts.len());
        assert!(efforts.iter().all(|effort| *effort <= 18.0));
        assert_eq!(PUSH.update(&mut push, 1.4), Pushed::Blocked);
    }

    #[test]
    fn load_that_moves_ends_it() {
        let mut push = PushState::default();
        assert!(matches!(PUSH.update(&mut push, 0.0), Pushed::On(_)));
        assert_eq!(PUSH.update(&mut push, 1.6), Pushed::Moved);
    }

    extern crate std;
}
