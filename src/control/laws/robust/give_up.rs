//! Giving up: the law ends attempts without success, above all against an end stop.
//!
//! ```text
//! n_s  judged pulses after which the joint had not moved (peak < q / 2) although
//!      A >= min(1.5 F_hi + u_L, u_m), without one between after which it had: one of 3 ms or more
//!      counts four times; encoder on the motor only
//! n_t  judged attempts, pulses and steps
//! n_s >= 12  or  n_t = n  (8 n with the encoder on the load):  GIVE_UP
//! ```
//!
//! A HOLD and a new motion clear both counts. In GIVE_UP the effort is `u_b`, constant. The law
//! leaves GIVE_UP if the joint is lost, or with a new motion, also one to the same target.
//!
//! Why this form: no friction of the declared range resists three long pulses of 1.5 times its
//! upper end, so something else is in the way. A short pulse is less evidence: a winding of L/R = 5
//! ms has 18 % of its current after 1 ms and 45 % after 3. With such a winding, a rule of three
//! pulses of any length gave up on 18 of 100 simulated rigid joints, and this rule on none. If
//! short pulses did not count, every second wall would trip the stall monitor before the law gave
//! up. With the encoder on the load, a pulse can wind up the transmission without a count, so there
//! only the number of attempts is evidence. Joints that come to rest need fewer attempts than 50
//! with the encoder on the motor, and up to some 320 on the load. With a budget of 100, four
//! families missed as many of 10 000 moves each as with 50, and 33 of 500 flexible joints fewer
//! ended before a wall within 2 s.
//!
//! Guarantees: after `n` attempts at most, the motor has the hold effort and no pulses. Does badly:
//! until then the pulses grow up to the full scale. If a transmission winds up against a stop, the
//! motor can rest at its target, and the law does not give up. The budget of the load side is not
//! simulated.

/// Evidence at which the joint counts as blocked, in short strong pulses without a count.
const SILENT: u8 = 12;

/// Evidence of a long pulse, and the time from which a pulse is long, s.
const LONG: u8 = 4;
const LONG_S: f32 = 0.003;

/// Factor of the budget with the encoder on the load.
const LOAD_SIDE: u32 = 8;

/// The rule, prepared for a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GiveUp {
    /// Number of attempts after which the law gives up; zero: it never does.
    attempts: u16,
    /// Effort of a pulse that moves every free joint, V; infinite with the encoder on the load.
    strong: f32,
    /// Ticks of a long pulse.
    long: u8,
    /// Half a count, deg.
    half_count: f32,
}

/// The attempts since the last HOLD or motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attempts {
    /// Judged attempts n_t.
    pub all: u16,
    /// Evidence of strong pulses without a count n_s.
    silent: u8,
}

impl GiveUp {
    /// Prepares the rule for a number of attempts (zero: off), the effort that moves every free
    /// joint (V), the encoder's side, the angle of a count (deg), and ticks of `sample_time` (s).
    pub fn new(attempts: u32, strong: f32, on_load: bool, [count, sample_time]: [f32; 2]) -> Self {
        let factor = if on_load { LOAD_SIDE } else { 1 };
        let attempts = attempts.saturating_mul(factor).min(u16::MAX.into()) as u16;
        let strong = if on_load { f32::INFINITY } else { strong };
        let long = libm::ceilf((LONG_S - 1e-6) / sample_time).min(255.0) as u8;
        Self { attempts, strong, long, half_count: 0.5 * count }
    }

    /// Counts a judged step. Returns whether it is time to give up.
    pub fn step(&self, attempts: &mut Attempts) -> bool {
        attempts.all = attempts.all.saturating_add(1);
        self.is_due(*attempts)
    }

    /// Counts a judged pulse of an effort (V), in which the joint went as far as `peak` (deg).
    /// Returns whether it is time to give up.
    pub fn pulse(&self, attempts: &mut Attempts, [effort, peak]: [f32; 2], ticks: u8) -> bool {
        if peak >= self.half_count || effort < self.strong {
            attempts.silent = 0;
        } else {
            let by = if ticks >= self.long { LONG } else { 1 };
            attempts.silent = attempts.silent.saturating_add(by);
        }
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
        (1..=1000).find(|_| rule.pulse(&mut attempts, [effort, peak], 3))
    }

    #[test]
    fn three_strong_pulses_without_a_count_are_enough() {
        let rule = GiveUp::new(50, 18.0, false, [1.0, 0.001]);
        assert_eq!(pulses(rule, 18.0, 0.4), Some(3));
        assert_eq!(pulses(rule, 17.9, 0.4), Some(50), "a weaker one may have been too weak");
        assert_eq!(pulses(rule, 18.0, 0.5), Some(50), "it moves");
        let mut attempts = Attempts::default();
        for peak in [0.0, 0.0, 1.0, 0.0, 0.0] {
            assert!(!rule.pulse(&mut attempts, [18.0, peak], 3));
        }
        assert!(rule.pulse(&mut attempts, [18.0, 0.0], 3));
    }

    #[test]
    fn steps_count_as_attempts() {
        let (rule, mut attempts) =
            (GiveUp::new(50, 18.0, false, [1.0, 0.001]), Attempts::default());
        assert_eq!((1..=1000).find(|_| rule.step(&mut attempts)), Some(50));
    }

    #[test]
    fn encoder_on_the_load_takes_eight_times_as_many_attempts_and_no_silence() {
        assert_eq!(pulses(GiveUp::new(50, 18.0, true, [1.0, 0.001]), 60.0, 0.0), Some(400));
        assert_eq!(
            pulses(GiveUp::new(60_000, 18.0, true, [1.0, 0.001]), 60.0, 0.0),
            None,
            "no overflow"
        );
    }

    #[test]
    fn without_a_number_of_attempts_it_never_gives_up() {
        assert_eq!(pulses(GiveUp::new(0, 18.0, false, [1.0, 0.001]), 60.0, 0.0), None);
    }

    /// A long one counts four times, and the others go on counting.
    #[test]
    fn twelve_short_pulses_are_as_much_evidence_as_three_long_ones() {
        for (lengths, enough) in [(&[1u8][..], 12), (&[2, 3], 6), (&[3], 3), (&[200], 3)] {
            let rule = GiveUp::new(100, 18.0, false, [1.0, 0.001]);
            let mut attempts = Attempts::default();
            let mut lengths = lengths.iter().cycle();
            let gives_up =
                |_: &usize| rule.pulse(&mut attempts, [18.0, 0.0], *lengths.next().unwrap());
            assert_eq!((1..=1000).find(gives_up), Some(enough));
        }
        // Of 20 ms every pulse is long, and of 0.1 ms one of 30 ticks.
        for (sample_time, ticks, enough) in [(0.02, 1, 3), (1e-4, 30, 3), (1e-4, 29, 12)] {
            let rule = GiveUp::new(100, 18.0, false, [1.0, sample_time]);
            let mut attempts = Attempts::default();
            let found = (1..=1000).find(|_| rule.pulse(&mut attempts, [18.0, 0.0], ticks));
            assert_eq!(found, Some(enough), "{sample_time}");
        }
    }
}
