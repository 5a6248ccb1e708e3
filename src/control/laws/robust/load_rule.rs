//! The load rule: a load that drives the joint is held when the motion ends, and during it.
//!
//! While the profile moves, the rule filters `w`, the effort that the motion needs beyond the
//! model. When the profile has come to rest, the part of `w` that is not friction becomes the hold
//! effort:
//!
//! ```text
//! L1  |u_b| <= 0.8 F_hi + u_L,   |x3| <= (1.5 F_hi + u_L) / J
//! L2  at a change of s = sgn p':  w = R_i s + u_b;  each tick  w += min(1, 30 h) (-J x3 - w)
//! L3  in the first tick with p' = 0:  u_b = clamp(w - s R_0, 0.8 F_hi + u_L)
//! L4  the observer begins with x3 = -(R_i s + u_b) / J, and u has (1 - g_e)(R_i s + u_b)
//! L5  at rest x3 = -u_b / J
//! L6  lost at |r - y| > |e_b| + 64 q, and sliding with s:
//!     u_b = clamp(-J x3 - s R_0, 0.8 F_hi + u_L)
//! ```
//!
//! with `u_L` the largest configured load; zero turns the rule off, and the law is the one
//! without it.
//!
//! Why this form: without it the observer's disturbance is dropped at the end of a motion, and a
//! load above the static friction runs away with the joint until the joint is lost, again and
//! again. The rule distinguishes the load from friction by `R_0`, which follows from the
//! configuration, since the learned `R_i` includes the load. The filter of 1/30 s keeps the swings
//! of a flexible joint out of `u_b`: without it the prototype made some flexible joints spin. With
//! L4 the effort has no step between motion and rest.
//!
//! Guarantees: the hold effort stays within `0.8 F_hi + u_L`. With `u_L = 0` the law is unchanged.
//! L6 is not part of the prototype: if the hold effort is halved there, the load creeps away
//! forever. Does badly: while the joint is first released nothing holds it, and it drops until the
//! observer has learned the load, after some 20 ms; set the hold effort at enabling. Where no load
//! can drive the joint the rule leaves a hold effort that heats the motor for nothing. A few
//! flexible joints can still spin: the overspeed monitor stops them.

use crate::units::saturation::bounded;

/// The rule, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadRule {
    /// Whether a load is configured.
    pub acts: bool,
    /// The weight of a tick in w.
    rate: f32,
    /// R_0, V.
    friction: f32,
    /// The largest hold effort, V.
    most: f32,
}

impl LoadRule {
    /// Prepares the rule for a `load` (V; zero: off), a first sliding friction (V), the largest
    /// hold effort (V) and ticks of `sample_time` (s).
    pub fn new(load: f32, friction: f32, most: f32, sample_time: f32) -> Self {
        Self { acts: load > 0.0, rate: (30.0 * sample_time).min(1.0), friction, most }
    }

    /// Filters the effort w that the motion needs beyond the model (L2), V.
    #[inline]
    pub fn follow(&self, effort: &mut f32, disturbance: f32) {
        *effort += self.rate * (disturbance - *effort);
    }

    /// Returns the hold effort after a motion in the direction of `sign` (L3), V.
    #[inline]
    pub fn held(&self, effort: f32, sign: f32) -> f32 {
        bounded(effort - sign * self.friction, self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: LoadRule = LoadRule { acts: true, rate: 0.03, friction: 4.0, most: 20.0 };

    #[test]
    fn prepared_rule_is_the_one_of_these_tests() {
        let of = |load: f32, h: f32| LoadRule::new(load, 4.0, 20.0, h);
        assert!((of(10.0, 0.001).rate - RULE.rate).abs() < 1e-6);
        assert_eq!(LoadRule { rate: RULE.rate, ..of(10.0, 0.001) }, RULE);
        assert_eq!((of(0.0, 0.001).acts, of(10.0, 0.05).rate), (false, 1.0));
    }

    #[test]
    fn load_is_what_the_motion_needed_beyond_friction_in_either_direction() {
        // A load of 10 V, friction 4 V.
        assert_eq!([RULE.held(14.0, 1.0), RULE.held(6.0, -1.0)], [10.0, 10.0]);
        assert_eq!([RULE.held(30.0, 1.0), RULE.held(-30.0, -1.0)], [20.0, -20.0]);
    }

    #[test]
    fn effort_of_a_motion_is_followed_like_a_first_order_lag() {
        let mut effort = 4.0;
        (0..50).for_each(|_| RULE.follow(&mut effort, 14.0));
        assert!((effort - (14.0 - 10.0 * 0.97f32.powi(50))).abs() < 1e-4);
    }
}
