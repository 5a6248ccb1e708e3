//! The loop that moves a joint at the speeds of an identification.
//!
//! ```text
//! u = F sgn(r') + J (r'' + 2 w (r' - v) + w^2 (r - q))         v, q: a tracking filter at 5 w
//! ```
//!
//! `J` and `F` are rough: the inertia of two pulses, and the breakaway effort. The loop has double
//! poles at `w`. The loop does not have to be precise: the findings come from the motion of the
//! joint, and not from its set point. An error of the constant friction `F` moves the joint by
//! `(F - F_true) / (J w^2)` off its reference, for all of a stretch.
//!
//! The bandwidth `w` is a tenth of the sample rate, and at most 20 rad/s: with two samples of delay
//! the phase is 0.2 rad at `w`, and the encoder's rounding is not turned into effort.
//!
//! Does badly: a joint whose friction falls with the speed by more than `2 w J` per speed slips and
//! sticks in the slow stretches. Nothing stiffer would be safe on an unknown joint.

use crate::units::saturation::bounded;

/// The largest bandwidth, rad/s.
const BANDWIDTH: f32 = 20.0;

/// The largest product of bandwidth and sample time.
const PER_SAMPLE: f32 = 0.1;

/// Bandwidth of the tracking filter, in bandwidths of the loop.
const FILTER: f32 = 5.0;

/// The state of the loop from tick to tick; positions in degrees are counted from where the present
/// motion began, so that they stay exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Follower {
    origin: i32,
    /// Position of the reference, deg.
    pub reference: f32,
    /// Speed of the reference, deg/s.
    pub speed: f32,
    /// The filter's position (deg) and velocity (deg/s).
    filtered: f32,
    /// Velocity of the joint, deg/s.
    pub velocity: f32,
}

impl Follower {
    /// Returns the bandwidth for a sample time (s), rad/s.
    pub fn bandwidth(tick: f32) -> f32 {
        (PER_SAMPLE / tick).min(BANDWIDTH)
    }

    /// Returns the state of a loop whose joint rests at `counts`.
    pub const fn begin(counts: i32) -> Self {
        Self { origin: counts, reference: 0.0, speed: 0.0, filtered: 0.0, velocity: 0.0 }
    }

    /// Updates only the filter, with the joint at `counts`.
    ///
    /// The filter is a Luenberger observer with both poles at `exp(-5 w h)`.
    pub fn observe(&mut self, counts: i32, [tick, count]: [f32; 2]) {
        let x = FILTER * Self::bandwidth(tick) * tick;
        // exp(-x) to third order: x is 0.5 at most.
        let pole = 1.0 - x * (1.0 - x * (0.5 - x * 0.166_666_7));
        let position = counts.wrapping_sub(self.origin) as f32 * count;
        let ahead = self.filtered + self.velocity * tick;
        let off = position - ahead;
        self.filtered = ahead + (1.0 - pole * pole) * off;
        self.velocity += (1.0 - pole) * (1.0 - pole) / tick * off;
    }

    /// Moves the reference on towards a speed (deg/s) within an acceleration (deg/s^2), and returns
    /// the effort (V). The last argument has rough values of the joint: its inertia (V per
    /// deg/s^2), its friction in this sense (V), and the largest effort that a lag adds to the
    /// friction (V).
    pub fn lead(
        &mut self,
        towards: f32,
        acceleration: f32,
        tick: f32,
        [inertia, friction, pull]: [f32; 3],
    ) -> f32 {
        let change = bounded(towards - self.speed, acceleration * tick);
        self.speed += change;
        self.reference += self.speed * tick;
        let w = Self::bandwidth(tick);
        // A joint that lags far behind is not chased: it would shoot out when it comes free.
        let lag = bounded(self.reference - self.filtered, pull / (inertia * w * w));
        self.reference = self.filtered + lag;
        let level = if self.speed == 0.0 { 0.0 } else { friction * self.speed.signum() };
        inertia * (change / tick + 2.0 * w * (self.speed - self.velocity) + w * w * lag) + level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the mean and the least speed of the last two of four seconds: a joint with Coulomb
    /// friction alone, by its closed form within a tick.
    fn speeds(tick: f32, inertia: f32, coulomb: f32, count: f32, target: f32) -> [f32; 2] {
        let (mut q, mut v) = (0.0f64, 0.0f64);
        let mut follower = Follower::begin(0);
        let h = f64::from(tick);
        let ticks = (4.0 / tick) as u32;
        let (mut sum, mut least) = (0.0, f32::MAX);
        for k in 0..ticks {
            let counts = (q / f64::from(count)).floor() as i32;
            follower.observe(counts, [tick, count]);
            // Inertia and friction are 30 % wrong.
            let rough = [1.3 * inertia, 0.7 * coulomb, coulomb];
            let u = follower.lead(target, 200.0, tick, rough);
            let (u, coulomb) = (f64::from(u), f64::from(coulomb));
            let sense = if v == 0.0 { u.signum() } else { v.signum() };
            let push = u - sense * coulomb;
            let next = v + push / f64::from(inertia) * h;
            let stops = v == 0.0 && u.abs() < coulomb || v != 0.0 && next * v < 0.0;
            let next = if stops { 0.0 } else { next };
            q += 0.5 * (v + next) * h;
            v = next;
            if 2 * k >= ticks {
                sum += v as f32;
                least = least.min(v as f32 / target);
            }
        }
        [2.0 * sum / ticks as f32, least]
    }

    #[test]
    fn a_joint_that_is_known_roughly_keeps_the_speed_that_is_asked_for() {
        for (tick, inertia, coulomb, count) in
            [(1e-3, 5e-4, 0.4, 0.0036), (1e-3, 5e-4, 0.2, 0.036), (2e-2, 0.037, 0.38, 0.00242)]
        {
            for target in [40.0, -5.0] {
                let [mean, least] = speeds(tick, inertia, coulomb, count, target);
                assert!((mean / target - 1.0).abs() < 0.02, "{mean} {target} {tick}");
                // It slides all the time.
                assert!(least > 0.5, "{least} {target} {tick}");
            }
        }
    }
}
