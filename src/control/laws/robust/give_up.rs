//! Giving up: attempts without success end, against an end stop above all.
//!
//! ```text
//! n_s  judged pulses in a row after which the joint had not moved (peak < q / 2) although
//!      A >= min(1.5 F_hi + u_L, u_m); encoder on the motor only
//! n_t  judged attempts, pulses and steps
//! n_s = 3  or  n_t = n  (8 n with the encoder on the load):  GIVE_UP
//! ```
//!
//! A HOLD and a new motion clear both. In GIVE_UP the effort is `u_b`, constant; a joint that is
//! lost, or a new motion, leaves it, also one to the same target.
//!
//! Why this form: no friction of the declared range stands against three pulses of half as much
//! again as its upper end, so something else is in the way. A pulse with the encoder on the load
//! may wind up the transmission without a count, so there only the number of attempts says
//! anything. Joints that come to rest need fewer attempts than 50 with the encoder on the motor
//! (smaller budgets cost a prototype some of them), and up to some 320 on the load: eight times 50
//! is beyond that.
//!
//! Guarantees: after `n` attempts at most, the motor has the hold effort and no pulses. Does badly:
//! until then the pulses grow up to the full scale. A transmission that winds up against a stop
//! lets the motor rest at its target, and nothing is given up. The budget of the load side is not
//! simulated.

/// Strong pulses without a count after which the joint is stuck for good.
const SILENT: u8 = 3;

/// Factor of the budget with the encoder on the load.
const LOAD_SIDE: u32 = 8;

/// The rule, prepared for a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GiveUp {
    /// The number of attempts; zero: it never gives up.
    attempts: u16,
    /// Effort of a pulse that moves every free joint, V; infinite with the encoder on the load.
    strong: f32,
    /// Half a count, deg.
    half_count: f32,
}

/// The attempts since the last HOLD or motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attempts {
    /// Judged attempts n_t.
    pub all: u16,
    /// Strong pulses in a row without a count n_s.
    silent: u8,
}

impl GiveUp {
    /// Prepares the rule for a number of attempts (zero: off), the effort that moves every free
    /// joint (V), the encoder's side, and the angle of a count (deg).
    pub fn new(attempts: u32, strong: f32, on_load: bool, count: f32) -> Self {
        let factor = if on_load { LOAD_SIDE } else { 1 };
        let attempts = attempts.saturating_mul(factor).min(u16::MAX.into()) as u16;
        let strong = if on_load { f32::INFINITY } else { strong };
        Self { attempts, strong, half_count: 0.5 * count }
    }

    /// Takes a judged step. Returns whether it is time to give up.
    pub fn step(&self, attempts: &mut Attempts) -> bool {
        attempts.all = attempts.all.saturating_add(1);
        self.is_due(*attempts)
    }

    /// Takes a judged pulse of an effort (V), on which the joint went `peak` (deg). Returns
    /// whether it is time to give up.
    pub fn pulse(&self, attempts: &mut Attempts, effort: f32, peak: f32) -> bool {
        let silent = peak < self.half_count && effort >= self.strong;
        attempts.silent = if silent { attempts.silent.saturating_add(1) } else { 0 };
        self.step(attempts)
    }

    const fn is_due(&self, attempts: Attempts) -> bool {
        self.attempts > 0 && (attempts.silent >= SILENT || attempts.all >= self.attempts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns after how many pulses of an effort it gives up.
    fn pulses(rule: GiveUp, effort: f32, peak: f32) -> Option<usize> {
        let mut attempts = Attempts::default();
        (1..=1000).find(|_| rule.pulse(&mut attempts, effort, peak))
    }

    #[test]
    fn three_strong_pulses_without_a_count_are_enough() {
        let rule = GiveUp::new(50, 18.0, false, 1.0);
        assert_eq!(pulses(rule, 18.0, 0.4), Some(3));
        assert_eq!(pulses(rule, 17.9, 0.4), Some(50), "a weaker one may have been too weak");
        assert_eq!(pulses(rule, 18.0, 0.5), Some(50), "it moves");
        let mut attempts = Attempts::default();
        for peak in [0.0, 0.0, 1.0, 0.0, 0.0] {
            assert!(!rule.pulse(&mut attempts, 18.0, peak));
        }
        assert!(rule.pulse(&mut attempts, 18.0, 0.0));
    }

    #[test]
    fn steps_count_as_attempts() {
        let (rule, mut attempts) = (GiveUp::new(50, 18.0, false, 1.0), Attempts::default());
        assert_eq!((1..=1000).find(|_| rule.step(&mut attempts)), Some(50));
    }

    #[test]
    fn encoder_on_the_load_takes_eight_times_as_many_attempts_and_no_silence() {
        assert_eq!(pulses(GiveUp::new(50, 18.0, true, 1.0), 60.0, 0.0), Some(400));
        assert_eq!(pulses(GiveUp::new(60_000, 18.0, true, 1.0), 60.0, 0.0), None, "no overflow");
    }

    #[test]
    fn without_a_number_of_attempts_it_never_gives_up() {
        assert_eq!(pulses(GiveUp::new(0, 18.0, false, 1.0), 60.0, 0.0), None);
    }
}
