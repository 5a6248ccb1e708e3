//! Encoder of a joint, on the motor or on the load: `count = floor(x/q + 1/2)`; and noise of one
//! count.

use super::Joint;
use super::random::SplitMix64;

/// Where the encoder's disc sits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DiscSide {
    /// On the motor, behind the gear.
    #[default]
    Motor,
    /// On the load.
    Load,
}

/// Encoder without noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointEncoder {
    /// Angle of one count q, rad.
    pub count: f64,
    /// Side of the gear on which the disc sits.
    pub side: DiscSide,
}

impl JointEncoder {
    /// Returns the position of the encoder's side of the gear, rad.
    #[inline]
    pub fn position(&self, joint: &impl Joint) -> f64 {
        match self.side {
            DiscSide::Motor => joint.motor().position,
            DiscSide::Load => joint.load().position,
        }
    }

    /// Returns the count at the joint's position.
    #[inline]
    pub fn read(&self, joint: &impl Joint) -> i64 {
        self.count_at(self.position(joint))
    }

    /// Returns the count at a position (rad).
    #[inline]
    pub fn count_at(&self, position: f64) -> i64 {
        let counts = position / self.count + 0.5;
        // Conversion truncates: without SSE 4.1 `floor` is a call.
        let whole = counts as i64;
        whole.saturating_sub(i64::from(whole as f64 > counts))
    }
}

/// Noise of one count: -1, 0 and 1 are equally likely at each reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountNoise {
    random: SplitMix64,
}

impl CountNoise {
    /// Creates the random stream of a seed.
    pub const fn new(seed: u64) -> Self {
        Self { random: SplitMix64::new(seed) }
    }

    /// Returns the next -1, 0 or 1.
    #[inline]
    pub const fn next(&mut self) -> i64 {
        self.random.below(3) as i64 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_begins_half_a_count_below_its_number() {
        use super::super::{Body, Description, StribeckCurve, Train, Turn};
        let curve =
            StribeckCurve { coulomb: 1.0, stick: 1.0, stribeck_velocity: 0.0, viscous: 0.0 };
        let train = Train::Rigid(Body { inertia: 1.0, friction: curve.into() });
        let mut joint = Description::of(train, 1e-4).build().unwrap();
        let encoder = JointEncoder { count: 1e-4, side: DiscSide::Load };
        for (counts, wanted) in [(-2.6, -3), (-2.4, -2), (-0.4, 0), (0.49, 0), (0.51, 1), (7.0, 7)]
        {
            joint.put(Turn { position: counts * 1e-4, velocity: 0.0 });
            assert_eq!(encoder.read(&joint), wanted);
        }
    }

    #[test]
    fn noise_is_minus_one_zero_and_one_equally_often() {
        let mut noise = CountNoise::new(7);
        let mut seen = [0_u32; 3];
        for _ in 0..30_000 {
            seen[(noise.next() + 1) as usize] += 1;
        }
        // Five standard deviations of a binomial count of 1/3 in 30,000: 5 * 81.6.
        assert!(seen.iter().all(|count| count.abs_diff(10_000) < 408), "{seen:?}");
    }
}
