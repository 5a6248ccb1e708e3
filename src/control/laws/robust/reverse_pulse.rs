//! The reverse pulse: it brakes a load that has broken away, with the encoder on the load.
//!
//! The load breaks away at a spring torque, and slides much farther than the motor moved. A load
//! that runs towards the target with the speed `v = s x2` is assumed to need `v (c v + h)` to stop,
//! with `c = 3 J / R_0`. If less than that is left, it would pass the target. So once in an
//! attempt,
//!
//! ```text
//! m > q / 2,  v > 0.05 q / h  and  s e <= v (c v + h):
//!     one pulse in the other direction, of the distance kb max(k_i min(|e_b|, 50 q), 10 q)
//! judged:  e s < -1.5 q:   kb = min(1.25 kb, 8)         it went too far
//!          m < 0.3 |e_b|:  kb = max(0.6 kb, 0.03)       it was braked too early
//! ```
//!
//! Why this form: `c v^2` is six times the way in which the sliding friction stops the joint (`v^2
//! J / (2 R)`): the load hangs on the spring that the motor has wound up. Guarantees: one pulse in
//! an attempt, of a bounded length. Does badly: a slide of more than some 16 counts is over before
//! a few samples have shown it. Whether a reverse pulse comes depends on the measured motion, so
//! that a small change of the effort can trigger one.

/// The rule, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReversePulse {
    /// c, s^2/deg.
    reach: f32,
    sample_time: f32,
    /// Speed below which the joint is left alone, deg/s.
    slowest: f32,
    /// Angle of a count q, deg.
    count: f32,
    /// The largest distance of a pulse, 50 counts, deg.
    pub farthest: f32,
}

impl ReversePulse {
    /// Prepares the rule for an inertia (V s^2/deg), a first sliding friction (V), ticks of
    /// `sample_time` (s) and the angle of a count (deg).
    pub fn new(inertia: f32, friction: f32, sample_time: f32, count: f32) -> Self {
        let reach = inertia / (2.0 * friction) * 6.0;
        let slowest = 0.05 * count / sample_time;
        Self { reach, sample_time, slowest, count, farthest: 50.0 * count }
    }

    /// Returns whether a joint that has `moved` (deg) would pass a target that is still `ahead`
    /// (deg) at its `speed` (deg/s).
    #[inline]
    pub fn is_due(&self, moved: f32, ahead: f32, speed: f32) -> bool {
        moved > 0.5 * self.count
            && speed > self.slowest
            && ahead <= speed * (self.reach * speed + self.sample_time)
    }

    /// Returns the distance to brake by, deg: `gain` is kb, and `pulse` the distance that the
    /// pulse of the attempt was planned for.
    #[inline]
    pub fn distance(&self, gain: f32, pulse: f32) -> f32 {
        let least = 10.0 * self.count;
        gain * if pulse > least { pulse } else { least }
    }

    /// Returns whether a joint with its target `ahead` (deg) has passed it by more than 1.5 counts.
    pub fn is_beyond(&self, ahead: f32) -> bool {
        ahead < -1.5 * self.count
    }

    /// Learns the gain kb from an attempt with a reverse pulse, for an error of `wanted` (deg,
    /// positive): the joint has `moved` towards the target, and `ahead` is left (deg).
    pub fn learn(&self, gain: &mut f32, wanted: f32, moved: f32, ahead: f32) {
        if self.is_beyond(ahead) {
            *gain = (1.25 * *gain).min(8.0);
        } else if moved < 0.3 * wanted {
            *gain = (0.6 * *gain).max(0.03);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: ReversePulse =
        ReversePulse { reach: 1e-5, sample_time: 0.001, slowest: 50.0, count: 1.0, farthest: 50.0 };

    #[test]
    fn prepared_rule_is_the_one_of_these_tests() {
        let ReversePulse { reach, sample_time, slowest, .. } =
            ReversePulse::new(2e-5, 6.0, 0.001, 1.0);
        assert!((reach / RULE.reach - 1.0).abs() < 1e-6, "{reach}");
        assert_eq!((sample_time, slowest), (RULE.sample_time, RULE.slowest));
    }

    #[test]
    fn a_joint_is_braked_only_if_it_would_pass_the_target() {
        // With 1000 counts/s it needs 1000 (1e-5 1000 + 0.001) = 11 counts.
        assert!(RULE.is_due(1.0, 10.9, 1000.0) && !RULE.is_due(1.0, 11.1, 1000.0));
        assert!(!RULE.is_due(0.5, 10.9, 1000.0), "it has not moved");
        assert!(!RULE.is_due(1.0, -5.0, 50.0) && RULE.is_due(1.0, -5.0, 50.1), "it creeps");
    }

    #[test]
    fn braking_learns_from_how_far_the_joint_went() {
        let learned = |moved: f32, ahead: f32| {
            let mut gain = 1.0;
            RULE.learn(&mut gain, 10.0, moved, ahead);
            gain
        };
        assert_eq!([learned(11.4, -1.4), learned(11.6, -1.6)], [1.0, 1.25]);
        assert_eq!([learned(3.1, 6.9), learned(2.9, 7.1)], [1.0, 0.6]);
        let (mut most, mut least) = (1.0, 1.0);
        for _ in 0..50 {
            RULE.learn(&mut most, 10.0, 20.0, -10.0);
            RULE.learn(&mut least, 10.0, 0.0, 10.0);
        }
        assert_eq!([most, least], [8.0, 0.03]);
    }

    #[test]
    fn distance_to_brake_by_is_ten_counts_at_least() {
        assert_eq!([RULE.distance(0.5, 4.0), RULE.distance(0.5, 40.0)], [5.0, 20.0]);
    }
}
