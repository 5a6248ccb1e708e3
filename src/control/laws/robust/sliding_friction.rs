//! The sliding friction in each direction, learned while the profile runs.
//!
//! In the direction `i` of the profile, with `s = sgn p'` and the observer's `x2` and `x3`:
//!
//! ```text
//! s x2 > |p'| / 2,  s x2 > 0.02 q / h,  |p'| <= v_R  and  the joint does not rest:
//!     R_i += min(1/2, 5 h) (min(max(-J x3 s, 0.3 F_lo), 1.2 F_hi) - R_i)
//! v_R = max(0.3 F_lo / B, 3 a_m h)  where h > 10 ms, else infinite; or as configured
//! ```
//!
//! `R_i` begins as `R_0 = 0.8 sqrt(F_lo F_hi)`, four fifths of the geometric mean of the breakaway
//! range: sliding friction is below the breakaway friction.
//!
//! Why this form: the observer needs some `3 / w_e` to find the friction after a change of
//! direction; the learned friction is available at once. The filter of 0.2 s is longer than a stop
//! at a spot, and shorter than a move. The conditions exclude joints that do not slide: a joint
//! that hangs, and one that is pushed back.
//!
//! In a slow loop a pulse is a single tick, and `R_i` decides how far it goes. The configured
//! viscous friction is wrong by a part of `B p'`, which at the full speed is more than the sliding
//! friction of a loose joint. Pulses that were planned with it went twice as far as they should,
//! to and fro, and 81 of 120,000 moves of the thesis's axis were late. At `0.3 F_lo / B` an error
//! of the viscous friction by all of `B` is no more than the least friction that is learned. At
//! twice that speed, 12 of 400,000 moves were late; at that speed none, at two thirds of it one, at
//! a third none.
//!
//! The profile of a light joint passes that speed in its first tick. With `3 a_m h`, the law learns
//! from the three ticks at either end of a move, instead of not at all.
//!
//! Guarantees: `R_i` stays within `[0.3 F_lo, 1.2 F_hi]`. Does badly: a constant load appears in
//! both directions with opposite signs, and friction that depends on the place is averaged. A slow
//! loop learns less of the friction at full speed, so it tracks less closely there
//! (docs/explanation/robust.md).

/// The least friction that is learned, as a part of F_lo.
pub(super) const LEAST_LEARNED: f32 = 0.3;

/// Rate and bounds of the learned friction, prepared for a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingFriction {
    rate: f32,
    least: f32,
    most: f32,
    /// Speed below which nothing is learned, deg/s.
    slowest: f32,
    /// Speed of the profile above which nothing is learned, deg/s.
    fastest: f32,
    /// Friction R_0 that is assumed before anything is learned, V.
    pub first: f32,
}

impl SlidingFriction {
    /// Prepares the rule for ticks of `sample_time` (s), a range of breakaway efforts (V), a speed
    /// above which nothing is learned (deg/s) and the angle of a count (deg).
    pub fn new(sample_time: f32, [low, high]: [f32; 2], fastest: f32, count: f32) -> Self {
        Self {
            rate: (5.0 * sample_time).min(0.5),
            least: LEAST_LEARNED * low,
            most: 1.2 * high,
            slowest: 0.02 * count / sample_time,
            fastest,
            first: 0.8 * libm::sqrtf(low * high),
        }
    }

    /// Learns from the disturbance `found` (V, against the motion) if the joint slides. `speed` is
    /// its speed in the direction of the profile, and `wanted` the speed of the profile (positive),
    /// both deg/s.
    #[inline]
    pub fn learn(&self, friction: &mut f32, found: f32, speed: f32, wanted: f32) {
        if speed > 0.5 * wanted && speed > self.slowest && wanted <= self.fastest {
            let found = if found > self.least { found } else { self.least };
            let found = if found < self.most { found } else { self.most };
            *friction += self.rate * (found - *friction);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn learned(found: f32, speed: f32, ticks: u32) -> f32 {
        let sliding = SlidingFriction::new(0.001, [2.0, 8.0], 1e3, 1.0);
        let mut friction = sliding.first;
        (0..ticks).for_each(|_| sliding.learn(&mut friction, found, speed, 100.0));
        friction
    }

    #[test]
    fn friction_is_reached_like_a_first_order_lag_of_a_fifth_of_a_second() {
        let expected = 5.0 + (3.2 - 5.0) * 0.995f32.powi(200);
        assert!((learned(5.0, 100.0, 200) - expected).abs() < 1e-4);
    }

    #[test]
    fn what_is_learned_stays_within_its_bounds() {
        assert!((learned(-3.0, 100.0, 5000) - 0.6).abs() < 1e-4);
        assert!((learned(30.0, 100.0, 5000) - 9.6).abs() < 1e-4);
    }

    #[test]
    fn a_joint_that_hangs_or_creeps_teaches_nothing() {
        assert_eq!(learned(5.0, 50.0, 10), 3.2);
        assert_ne!(learned(5.0, 50.1, 10), 3.2);
        let sliding = SlidingFriction::new(0.001, [2.0, 8.0], 1e3, 1.0);
        for (speed, learns) in [(19.9, false), (20.1, true)] {
            let mut friction = sliding.first;
            sliding.learn(&mut friction, 5.0, speed, 0.0);
            assert_eq!(friction != 3.2, learns, "{speed} counts/s");
        }
    }

    #[test]
    fn friction_is_learned_up_to_the_fastest_speed() {
        for (wanted, learns) in [(20.0, true), (20.1, false)] {
            let sliding = SlidingFriction::new(0.02, [2.0, 8.0], 20.0, 1.0);
            let mut friction = sliding.first;
            sliding.learn(&mut friction, 5.0, wanted, wanted);
            assert_eq!(friction != 3.2, learns, "{wanted} deg/s");
        }
    }
}
