//! The oscillation guard: it lowers the gain of a joint that swings, and tries it again later.
//!
//! The gain `g`, under a ceiling `g_c`, multiplies the derivative gain, and `g^2` the proportional
//! one: the bandwidth is `g w_n`. Swings are counted, not ticks of motion.
//!
//! ```text
//! reference at rest:  d = y - y_e.  In the direction of dir:  y_e = y.  Otherwise, with
//!                     |d| >= (2.5 + n_j) q: a reversal. n_w += 1 (not the first),
//!                     dir = sgn d, y_e = y.  n_w = 5: lower g
//!                     cleared by a rest, in HOLD, and by each attempt of the law
//! moving:             w = sign of p' - x2 beyond 0.3 |p'| + 0.4 q / h.  A change adds
//!                     N_g / 6 + 1 to v_n, which leaks 1 in 8 ticks.  v_n >= N_g: lower g.
//!                     One after |p' - x2| > v_m / 2 + 0.8 q / h adds N_g, if the joint was not
//!                     pushed away (encoder on the motor, h <= 10 ms). With g <= 0.3 it halves Kd
//!                     in motion until the next HOLD
//!                     forgotten:  w, of a joint at rest
//! slow:               (see `inching`) as with the reference at rest. Up to v_i no floor of 0.3
//! lost:               the third time without a HOLD between: lower g
//!
//! lower:              g_c = max(0.85 g, g_min),  g = max(0.7 g, g_min)
//! entering HOLD:      unless g was lowered since the last one:
//!                     g = min(1.1 g, g_c),  g_c = min(1.002 g_c, 1)
//! ```
//!
//! Why this form: on a flexible joint the loop's own oscillation is a few counts large, and no gain
//! is right for all of them. Swings of the law's own pulses do not count, since each attempt clears
//! them. In motion a joint crosses the profile's speed a few times after each corner; six times in
//! `8 N_g` ticks is an oscillation. If a motor swings against its gear by half of the profile's
//! speed, the guard does not wait for the sixth crossing: the swing doubles in a period. `g` climbs
//! back within a few moves to just below the level that oscillated, and the ceiling allows that
//! level again some 80 moves later.
//!
//! In motion the law uses a gain of 0.3 at least, since a joint with less does not follow. A motor
//! of a tenth of the inertia swings even at that gain, and wider from period to period. It needs
//! less damping, since the velocity comes late, and as much stiffness as before: with a gain of 0.1
//! instead of 0.3, 33 of 2000 simulated joints fell behind their trajectory, and 3 had swung.
//!
//! Guarantees: `g_min <= g <= g_c <= 1`. Does badly: `g` rises only at a HOLD, so a reference that
//! never rests keeps it down, and a joint that pulses to and fro without swinging is not detected.

/// Number of reversals at rest that count as an oscillation.
const SWINGS: u8 = 5;

/// Number of losses without a HOLD between them that count as an oscillation.
const LOSSES: u8 = 3;

/// The guard, prepared for a sample time and an encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OscillationGuard {
    /// Limit N_g of the counter in motion, and the amount that a swing adds to the counter.
    limit: u16,
    swing: u16,
    /// The least gain g_min.
    least: f32,
    /// Distance from the last extreme that counts as a reversal, deg.
    reversal: f32,
    /// Speed error that the encoder cannot resolve, 0.4 counts a tick, deg/s.
    coarse: f32,
    /// Speed error of a swing that lowers the gain at once, deg/s.
    wide: f32,
}

/// The gain, and the counts of swings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SwingState {
    /// Gain g.
    pub gain: f32,
    /// Ceiling g_c.
    pub ceiling: f32,
    /// Factor on the damping in motion: one half after a wide swing with the least gain of motion.
    pub damping: f32,
    /// Last extreme of the position at rest y_e, deg from the law's origin.
    pub extreme: f32,
    /// Direction in which the joint leaves that extreme; zero: none yet.
    direction: f32,
    /// Counter in motion v_n.
    pub motion: u16,
    /// Ticks for the leak of that counter.
    leak: u8,
    /// Reversals at rest n_w.
    swings: u8,
    /// Losses n_l.
    losses: u8,
    /// Sign w of the speed error.
    side: i8,
    /// Whether the speed error has been wide since its sign changed.
    widely: bool,
    /// Whether the joint was pushed away since the last HOLD.
    pushed: bool,
    /// Whether the gain was lowered since the last HOLD.
    lowered: bool,
}

/// The least gain in motion.
pub(in super::super) const LEAST_IN_MOTION: f32 = 0.3;

#[cfg(feature = "two-encoders")]
impl SwingState {
    /// Clears the mark of a wide swing.
    pub(in super::super) const fn ignore_width(&mut self) {
        self.widely = false;
    }
}

impl OscillationGuard {
    /// Prepares the guard: the limit of the counter in motion (ticks), the least gain, the jitter
    /// of the encoder (counts), the sample time (s), the angle of a count (deg), and the
    /// speed error (deg/s) beyond the encoder's own that is `wide`.
    pub fn new(
        limit: u16,
        least: f32,
        jitter: f32,
        sample_time: f32,
        count: f32,
        wide: f32,
    ) -> Self {
        Self {
            limit,
            swing: limit / 6 + 1,
            least,
            reversal: (2.5 + jitter) * count,
            coarse: 0.4 * count / sample_time,
            // The speed of a coarse encoder is off by a part of a count a tick, to either side.
            wide: wide + 0.8 * count / sample_time,
        }
    }

    /// Returns the initial state, with the whole gain.
    pub fn start(&self) -> SwingState {
        SwingState { gain: 1.0, ceiling: 1.0, damping: 1.0, ..SwingState::default() }
    }

    /// Updates the guard in a tick in which the reference rests. In a HOLD, and after a long rest,
    /// the joint is `quiet`, and the swings are cleared.
    #[inline]
    pub fn at_rest(&self, guarded: &mut SwingState, position: f32, quiet: bool) {
        guarded.motion = 0;
        guarded.side = 0;
        if quiet {
            return self.clear(guarded, position);
        }
        let left = position - guarded.extreme;
        if left * guarded.direction > 0.0 {
            guarded.extreme = position;
        } else if left.abs() >= self.reversal {
            if guarded.direction != 0.0 {
                guarded.swings = guarded.swings.saturating_add(1);
            }
            guarded.direction = if left > 0.0 { 1.0 } else { -1.0 };
            guarded.extreme = position;
            if guarded.swings >= SWINGS {
                self.lower(guarded);
            }
        }
    }

    /// Updates the guard in a tick in which the reference moves with `wanted` and the joint with
    /// `velocity`, deg/s. A joint that `sticks` does not swing: its motion is stick and slip.
    #[inline]
    pub fn in_motion(
        &self,
        guarded: &mut SwingState,
        position: f32,
        [wanted, velocity]: [f32; 2],
        sticks: bool,
    ) {
        self.clear(guarded, position);
        if sticks {
            (guarded.side, guarded.widely) = (0, false);
            return;
        }
        let error = wanted - velocity;
        let threshold = 0.3 * wanted.abs() + self.coarse;
        let side = if error > threshold {
            1
        } else if error < -threshold {
            -1
        } else {
            guarded.side
        };
        if side != guarded.side {
            if guarded.side != 0 {
                let swing = if guarded.widely { self.limit } else { self.swing };
                guarded.motion = guarded.motion.saturating_add(swing);
                if guarded.widely && guarded.gain <= LEAST_IN_MOTION {
                    guarded.damping = 0.5;
                }
            }
            (guarded.side, guarded.widely) = (side, false);
        } else if guarded.motion > 0 {
            guarded.leak = guarded.leak.wrapping_add(1);
            if guarded.leak & 7 == 0 {
                guarded.motion -= 1;
            }
        }
        // A joint that was pushed away comes back at any speed.
        guarded.widely |= error.abs() > self.wide && !guarded.pushed;
        if guarded.motion >= self.limit {
            self.lower(guarded);
        }
    }

    /// Clears the count of swings at rest.
    #[inline]
    pub fn clear(&self, guarded: &mut SwingState, position: f32) {
        guarded.swings = 0;
        guarded.direction = 0.0;
        guarded.extreme = position;
    }

    /// Called when the joint is lost: `pushed` away, or left behind by its set point.
    pub fn lost(&self, guarded: &mut SwingState, pushed: bool) {
        guarded.pushed |= pushed;
        guarded.losses = guarded.losses.saturating_add(1);
        if guarded.losses >= LOSSES {
            self.lower(guarded);
        }
    }

    /// Called when a HOLD starts: raises the gain unless it was lowered since the last HOLD.
    pub fn holds(&self, guarded: &mut SwingState) {
        if !guarded.lowered {
            guarded.gain = (1.1 * guarded.gain).min(guarded.ceiling);
            guarded.ceiling = (1.002 * guarded.ceiling).min(1.0);
        }
        (guarded.lowered, guarded.pushed, guarded.damping) = (false, false, 1.0);
        guarded.losses = 0;
    }

    /// Lowers the gain, and clears the counts.
    pub fn lower(&self, guarded: &mut SwingState) {
        guarded.ceiling = (0.85 * guarded.gain).max(self.least);
        guarded.gain = (0.7 * guarded.gain).max(self.least);
        (guarded.motion, guarded.swings, guarded.losses) = (0, 0, 0);
        guarded.lowered = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUARD: OscillationGuard = OscillationGuard {
        limit: 100,
        swing: 17,
        least: 0.1,
        reversal: 2.5,
        coarse: 400.0,
        wide: 5000.0,
    };

    fn gain_after(positions: impl IntoIterator<Item = f32>) -> f32 {
        let mut guarded = GUARD.start();
        positions.into_iter().for_each(|position| GUARD.at_rest(&mut guarded, position, false));
        guarded.gain
    }

    #[test]
    fn prepared_guard_is_the_one_of_these_tests() {
        assert_eq!(OscillationGuard::new(100, 0.1, 0.0, 0.001, 1.0, 4200.0), GUARD);
    }

    #[test]
    fn five_swings_at_rest_lower_the_gain_and_four_do_not() {
        let swings = |n: usize| [0.0, 3.0].into_iter().cycle().take(n + 2);
        assert_eq!(gain_after(swings(4)), 1.0);
        assert_eq!(gain_after(swings(5)), 0.7);
        // Two counts are noise, and a drift of any length is no swing.
        assert_eq!(gain_after([0.0, 2.0].into_iter().cycle().take(50)), 1.0);
        assert_eq!(gain_after((0..500).map(|i| i as f32)), 1.0);
    }

    #[test]
    fn swings_are_forgotten_when_they_are_cleared() {
        let mut guarded = GUARD.start();
        for position in [0.0, 3.0].into_iter().cycle().take(100) {
            GUARD.at_rest(&mut guarded, position, position == 3.0);
        }
        assert_eq!(guarded.gain, 1.0);
    }

    /// Swings of a given half period (ticks) about the profile's speed.
    fn gain_in_motion(half_period: usize, swing: f32) -> f32 {
        let mut guarded = GUARD.start();
        for tick in 0..20 * half_period {
            let velocity = if (tick / half_period).is_multiple_of(2) { swing } else { -swing };
            GUARD.in_motion(&mut guarded, 0.0, [1000.0, 1000.0 + velocity], false);
        }
        guarded.gain
    }

    #[test]
    fn quick_swings_in_motion_lower_the_gain_and_slow_or_small_ones_do_not() {
        assert!(gain_in_motion(20, 701.0) < 1.0);
        assert_eq!(gain_in_motion(20, 699.0), 1.0);
        // The counter leaks as fast as swings of 17 in 136 ticks fill it.
        assert_eq!(gain_in_motion(140, 701.0), 1.0);
    }

    /// A joint that sticks lags, and one that slips is ahead: the same swings, with rests between.
    #[test]
    fn stick_and_slip_is_no_swing() {
        let gain = |rests: bool| {
            let mut guarded = GUARD.start();
            for _ in 0..20 {
                for velocity in [299.0, 1701.0] {
                    (0..20).for_each(|_| {
                        GUARD.in_motion(&mut guarded, 0.0, [1000.0, velocity], false)
                    });
                    GUARD.in_motion(&mut guarded, 0.0, [1000.0, 0.0], rests);
                }
            }
            guarded.gain
        };
        assert!(gain(true) == 1.0 && gain(false) < 1.0);
    }

    /// Gain after a joint has swung to one side of the profile's speed by `error` for ten ticks,
    /// and then is on the other side.
    fn gain_after_a_swing(guarded: &mut SwingState, wanted: f32, error: f32) -> f32 {
        for velocity in [[wanted - error; 10], [2.0 * wanted; 10]].concat() {
            GUARD.in_motion(guarded, 0.0, [wanted, velocity], false);
        }
        guarded.gain
    }

    #[test]
    fn one_wide_swing_in_motion_lowers_the_gain_unless_the_joint_was_pushed() {
        // Wide is half of the profile's speed and 0.8 counts a tick: 4200 + 800.
        let swing = |error| gain_after_a_swing(&mut GUARD.start(), 9000.0, error);
        assert_eq!([swing(4999.0), swing(5001.0)], [1.0, 0.7]);
        // A wide error that stays on its side is a joint that lags, not one that swings.
        let mut guarded = GUARD.start();
        (0..1000).for_each(|_| GUARD.in_motion(&mut guarded, 0.0, [9000.0, 0.0], false));
        assert_eq!(guarded.gain, 1.0);
        // A joint that was left behind by a step still swings; one that was pushed comes back at
        // any speed, until it has held again.
        for (pushed, gain) in [(false, 0.7), (true, 1.0)] {
            let mut guarded = GUARD.start();
            GUARD.lost(&mut guarded, pushed);
            assert_eq!(gain_after_a_swing(&mut guarded, 9000.0, 5001.0), gain, "{pushed}");
            GUARD.holds(&mut guarded);
            guarded.side = 0;
            assert!(gain_after_a_swing(&mut guarded, 9000.0, 5001.0) < 0.8, "{pushed}");
        }
    }

    #[test]
    fn wide_swing_with_the_least_gain_of_motion_halves_the_damping_until_the_next_hold() {
        let mut guarded = GUARD.start();
        let swing = |guarded: &mut SwingState, speed: f32| {
            GUARD.in_motion(guarded, 0.0, [1000.0, 1000.0 + speed], false);
            GUARD.in_motion(guarded, 0.0, [1000.0, 1000.0 - speed], false);
        };
        let mut gains = [0.0; 3];
        for gain in &mut gains {
            assert!(guarded.damping == 1.0, "{guarded:?}");
            swing(&mut guarded, 5001.0);
            *gain = guarded.gain;
        }
        // It is lowered at each change of the sign but the first: 0.7, 0.7^3, 0.7^5.
        assert!(gains[1] > LEAST_IN_MOTION && gains[2] < LEAST_IN_MOTION, "{gains:?}");
        assert!(guarded.damping == 0.5);
        GUARD.holds(&mut guarded);
        GUARD.at_rest(&mut guarded, 0.0, true);
        assert!(guarded.damping == 1.0);
        // One that is not wide leaves it.
        guarded.gain = 0.2;
        (0..40).for_each(|_| swing(&mut guarded, 2000.0));
        assert!(guarded.damping == 1.0 && guarded.gain < 0.2, "{guarded:?}");
    }

    #[test]
    fn third_loss_without_a_hold_between_lowers_the_gain() {
        let mut guarded = GUARD.start();
        for _ in 0..2 {
            GUARD.lost(&mut guarded, true);
            GUARD.lost(&mut guarded, false);
            GUARD.holds(&mut guarded);
        }
        assert_eq!(guarded.gain, 1.0);
        (0..3).for_each(|_| GUARD.lost(&mut guarded, true));
        assert_eq!((guarded.gain, guarded.ceiling), (0.7, 0.85));
    }

    #[test]
    fn gain_climbs_back_to_the_ceiling_and_with_it_to_one() {
        let mut guarded = GUARD.start();
        GUARD.lower(&mut guarded);
        GUARD.holds(&mut guarded);
        assert_eq!(guarded.gain, 0.7, "the first hold afterwards leaves it");
        let holds = |guarded: &mut SwingState, n| (0..n).for_each(|_| GUARD.holds(guarded));
        holds(&mut guarded, 3);
        assert!((guarded.gain - 0.85 * 1.002f32.powi(2)).abs() < 1e-6, "{guarded:?}");
        // 0.85 * 1.002^n = 1 for n = 81.3.
        holds(&mut guarded, 78);
        assert!(guarded.gain < 1.0);
        holds(&mut guarded, 3);
        assert_eq!((guarded.gain, guarded.ceiling), (1.0, 1.0));
    }

    #[test]
    fn gain_falls_no_lower_than_the_least() {
        let mut guarded = GUARD.start();
        (0..20).for_each(|_| GUARD.lower(&mut guarded));
        assert_eq!((guarded.gain, guarded.ceiling), (0.1, 0.1));
    }
}
