//! The extended state observer: position, velocity and disturbance of a joint of known inertia.
//!
//! With the effort `u` that the joint had since the last tick and its position `y`:
//!
//! ```text
//! a   = (u - B x2) / J + x3
//! e1  = y - (x1 + h x2 + h^2 a / 2)
//! x1  = y - (1 - l1) e1
//! x2 += h a + l2 e1
//! x3  = clamp(x3 + l3 e1, limit / J)
//!
//! z = exp(-w_e h),  l1 = 1 - z^3,  l2 = 1.5 (1 - z)^2 (1 + z) / h,  l3 = (1 - z)^3 / h^2
//! ```
//!
//! `-J x3` is the disturbance: the effort that the model lacks, mainly friction. The gains put all
//! three poles of the error's dynamics at `z` (J. Han, *From PID to active disturbance rejection
//! control*, IEEE Trans. Industrial Electronics 56 (2009), 900; Z. Gao, *Scaling and
//! bandwidth-parameterization based controller tuning*, Proc. ACC 2003, for the single parameter
//! `w_e`; the discrete form is that of R. Miklosovic, A. Radke and Z. Gao, Proc. ACC 2006).
//!
//! Why this form: friction changes by its full size where the direction changes, and no model of
//! friction is as quick as `1/w_e`. The limit keeps an impact, or a count that is lost, from
//! becoming an effort for long.
//!
//! Guarantees: without error of the model, an error of the state decays like `k^2 z^k`. `x3` is
//! bounded. Does badly: a sample is late by half a tick and a count is a step, so that the speed is
//! off by some `l2 q` near rest, and the disturbance by `l3 J q`.

use crate::units::saturation::bounded;

/// The observer, prepared for a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedStateObserver {
    sample_time: f32,
    /// h^2 / 2.
    half_square: f32,
    per_inertia: f32,
    viscous: f32,
    /// 1 - l1, l2 and l3.
    rest: f32,
    to_velocity: f32,
    to_disturbance: f32,
    /// The largest |x3|.
    limit: f32,
}

/// The estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObserverState {
    /// Position x1, deg from the law's origin.
    pub position: f32,
    /// Velocity x2, deg/s.
    pub velocity: f32,
    /// Acceleration by the disturbance x3, deg/s^2.
    pub disturbance: f32,
}

impl ExtendedStateObserver {
    /// Prepares the observer for ticks of `sample_time` (s), a joint with an inertia (V s^2/deg)
    /// and viscous friction (V s/deg), a bandwidth w_e (rad/s) and the largest disturbance (V).
    pub fn new(
        sample_time: f32,
        [inertia, viscous]: [f32; 2],
        bandwidth: f32,
        largest: f32,
    ) -> Self {
        let pole = libm::expf(-bandwidth * sample_time);
        let fast = 1.0 - pole;
        Self {
            sample_time,
            half_square: 0.5 * sample_time * sample_time,
            per_inertia: 1.0 / inertia,
            viscous,
            rest: pole * pole * pole,
            to_velocity: 1.5 * fast * fast * (1.0 + pole) / sample_time,
            to_disturbance: fast * fast * fast / (sample_time * sample_time),
            limit: largest / inertia,
        }
    }

    /// Updates the estimates with the position of a tick (deg from the origin) and the effort (V)
    /// since the last tick.
    #[inline]
    pub fn update(&self, estimate: &mut ObserverState, effort: f32, position: f32) {
        let ObserverState { position: x1, velocity: x2, disturbance: x3 } = *estimate;
        let acceleration = (effort - self.viscous * x2) * self.per_inertia + x3;
        let predicted = x1 + self.sample_time * x2 + self.half_square * acceleration;
        let error = position - predicted;
        *estimate = ObserverState {
            position: position - self.rest * error,
            velocity: x2 + self.sample_time * acceleration + self.to_velocity * error,
            disturbance: bounded(x3 + self.to_disturbance * error, self.limit),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f32 = 0.001;

    /// The position of a joint with the inertia 2 and without friction under 3 V, of which a load
    /// takes 1 V: from rest it has gone t^2 / 2.
    fn observed(ticks: u32, limit: f32) -> ObserverState {
        let observer = ExtendedStateObserver::new(H, [2.0, 0.0], 100.0, limit);
        let mut estimate = ObserverState::default();
        for tick in 1..=ticks {
            let t = tick as f32 * H;
            observer.update(&mut estimate, 3.0, 0.5 * t * t);
        }
        estimate
    }

    #[test]
    fn disturbance_speed_and_place_of_a_steadily_driven_joint_are_found() {
        let found = observed(400, 10.0);
        assert!((found.disturbance - -0.5).abs() < 1e-3, "{found:?}");
        assert!((found.velocity - 0.4).abs() < 1e-3, "{found:?}");
        assert!((found.position - 0.08).abs() < 1e-4, "{found:?}");
    }

    /// Three poles at z: of the disturbance, (1 + b k + c k^2) z^k is missing after k ticks. The
    /// first two ticks, computed by hand from the equations, give b and c.
    #[test]
    fn error_decays_with_three_equal_poles() {
        let z = libm::exp(-0.1);
        let w = 1.0 - z;
        let first = 1.0 - w * w * w / 2.0;
        let ahead = z * z * z / 2.0 + 1.0 - 0.75 * w * w * (1.0 + z) + first / 2.0;
        let second = first - w * w * w * ahead;
        let (one, two) = (first / z - 1.0, second / (z * z) - 1.0);
        let (b, c) = (2.0 * one - two / 2.0, two / 2.0 - one);
        for ticks in [1u32, 10, 30, 100] {
            let k = f64::from(ticks);
            let left = (1.0 + b * k + c * k * k) * libm::pow(z, k);
            let found = f64::from(observed(ticks, 10.0).disturbance) / -0.5;
            assert!((found - (1.0 - left)).abs() < 2e-3, "{ticks}: {found}, not {}", 1.0 - left);
        }
    }

    #[test]
    fn disturbance_is_bounded_by_the_limit() {
        assert_eq!(observed(400, 0.5).disturbance, -0.25);
    }
}
