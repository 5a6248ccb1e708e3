//! Limits of a move from rest to rest: `[profile]` of a first file, and the move by which an
//! ensemble judges every law.
//!
//! ```text
//! v_max = min(0.075 u_m / B, 86 deg/s, 1.25 u_m / Kd)
//! a_max = 0.125 u_m / J, reached in min(0.1 s, 200 h)
//! ```
//!
//! `robust` makes its own profile of 0.15 u_m / B, no more than 3 rad/s, and 0.25 u_m / J. A move
//! from outside uses no more than half of both, so that the inner profile only acts at the landing.
//! The limit 1.25 u_m / Kd also keeps its velocity below half of the speed at which the default
//! monitor of the other laws trips. All three limits are then adjusted to values of four digits
//! that the core's generator can keep.

use stiction::ProfileLimits;

use super::{JointBounds, PdLoop, four_digits, four_digits_single};

/// Highest speed of a move, deg/s: half of 3 rad/s, the highest that the law `robust` chooses.
const FASTEST: f64 = 86.0;

/// Shares of the largest effort: for viscous friction at the largest velocity, and for the
/// acceleration of the nominal inertia. Both are half of those of `robust`.
const SHARES: [f64; 2] = [0.075, 0.125];

/// Largest effort of the damping Kd in a move, as a multiple of the largest effort: half of the
/// value at which the default overspeed monitor trips.
const OF_DAMPING: f64 = 1.25;

/// Longest time in which a move reaches its acceleration, s.
const JERK_TIME_S: f64 = 0.1;
/// The same in ticks; the generator averages over no more than 256.
const JERK_TICKS: f64 = 200.0;

/// Largest number of passes: rounding to four digits can move a limit out of the range that the
/// core can keep, and the next pass corrects that.
const PASSES: u32 = 4;

/// Limits of a move from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveProfile {
    /// The limits, which the core's generator keeps as they are.
    pub limits: ProfileLimits,
    /// Term that decides the velocity, in words.
    pub limited_by: &'static str,
}

impl MoveProfile {
    /// Returns the limits for a joint.
    pub fn of(joint: &JointBounds) -> Self {
        let largest_effort = joint.sampled.largest_effort;
        let kd = PdLoop::of(joint).kd;
        let [of_speed, of_inertia] = SHARES;
        // Of a joint without viscous friction, or a loop without Kd, a share is infinite.
        let of_kd = if kd > 0.0 { OF_DAMPING * largest_effort / kd } else { f64::INFINITY };
        let (velocity, limited_by) = [
            (FASTEST, "half of the 3 rad/s of robust at most"),
            (
                of_speed * largest_effort / (joint.viscous + joint.induced),
                "half of the inner profile of robust",
            ),
            (of_kd, "half of what trips the other controllers"),
        ]
        .into_iter()
        .fold((f64::INFINITY, ""), |least, one| if one.0 < least.0 { one } else { least });
        let acceleration = of_inertia * largest_effort / joint.inertia;
        let jerk_time_s = JERK_TIME_S.min(JERK_TICKS * joint.sampled.sample_time);
        let jerk = 2.0 * acceleration / jerk_time_s;
        let limits = [velocity, acceleration, jerk];
        Self::kept(limits, limited_by, [joint.sampled.sample_time, joint.sampled.count])
    }

    /// Returns the limits nearest to these that have four digits and that the core's generator can
    /// keep, at a sample time (s) and an angle of a count (deg): the generator counts in whole
    /// units, and a tick has a limited number of them.
    fn kept(limits: [f64; 3], limited_by: &'static str, [sample_time_s, count]: [f64; 2]) -> Self {
        let single = |[velocity, acceleration, jerk]: [f64; 3]| ProfileLimits {
            velocity: velocity as f32,
            acceleration: acceleration as f32,
            jerk: jerk as f32,
        };
        let mut kept = single(limits.map(four_digits));
        let mut limited_by = limited_by;
        for _ in 0..PASSES {
            let near = kept.nearest(sample_time_s as f32, count as f32);
            if near == kept {
                break;
            }
            if near.velocity != kept.velocity {
                limited_by = "as the core counts";
            }
            let change = |of: fn(&ProfileLimits) -> f32| {
                let (from, to) = (of(&kept), of(&near));
                if to == from { from } else { one_sided(to.into(), to > from) }
            };
            kept = ProfileLimits {
                velocity: change(|limits| limits.velocity),
                acceleration: change(|limits| limits.acceleration),
                jerk: change(|limits| limits.jerk),
            };
        }
        Self { limits: kept, limited_by }
    }
}

/// Rounds a value to four digits: up if `no_less`, otherwise down.
fn one_sided(value: f64, no_less: bool) -> f32 {
    let digit = 10f64.powf(value.abs().log10().floor() - 3.0);
    let digits = value / digit;
    four_digits_single(if no_less { digits.ceil() } else { digits.floor() } * digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slow limits are raised to what the core counts, and fast ones lowered.
    #[test]
    fn limits_of_a_first_file_are_ones_that_the_core_keeps_as_they_are_written() {
        let mut changed = [0; 2];
        let velocities = (-6..4).map(|power| 3.7 * 10f64.powi(power));
        for velocity in velocities {
            for (sample_time_s, count) in [(1e-4, 1e-3), (1e-3, 3.6e-3), (0.02, 1.8e-4)] {
                for (a, j) in [(2.0, 10.0), (40.0, 20.0)] {
                    let required = [velocity, a * velocity, j * a * velocity];
                    let kept = MoveProfile::kept(required, "", [sample_time_s, count]).limits;
                    let near = kept.nearest(sample_time_s as f32, count as f32);
                    assert_eq!(near, kept, "{required:?} at {sample_time_s} s, {count} deg");
                    let kept = f64::from(kept.velocity);
                    changed[0] += u32::from(kept > 1.001 * velocity);
                    changed[1] += u32::from(kept < 0.999 * velocity);
                }
            }
        }
        assert!(changed.iter().all(|cases| *cases > 0), "raised and lowered: {changed:?}");
    }
}
