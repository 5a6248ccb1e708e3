//! Parameters of `robust-dual`, and the rules for those that are not set.
//!
//! A user sets the same properties of a joint as for `robust`. The counts of both encoders are
//! those of the loop. No property of the gear is required. If the gear's stiffness or the motor's
//! inertia is set, the first bumps end closer to the target.
//!
//! Bandwidths, profile, guard and times are those of [`robust`](super::super::robust) with the
//! encoder on the motor, except the wait after an attempt, which is 20 ms: a period of the part
//! that swings behind the encoder.

use super::super::Loop;
use super::super::robust::{EncoderSide, RobustGains, Rules};
use crate::units::error::HUGE;
use crate::units::value::{Table, table};

table! {
    /// Parameters of the joint under `robust-dual`. The examples are a joint of 0.34 kg m^2 with a
    /// drive of 12 N m/V, and encoders of 100,000 counts a turn of the joint on both sides.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RobustDualGains (law) "controller" {
        /// Moment of inertia J, motor and load, as the effort of an acceleration, V s^2/deg.
        inertia: f32 = 0x1901 "inertia_v_s2_per_deg", Above(0.0, HUGE), Needed(4.945e-4);
        /// Viscous friction B, V s/deg.
        viscous: f32 = 0x1902 "viscous_v_s_per_deg", Between(0.0, HUGE), Needed(1.891e-3);
        /// Lowest breakaway effort of the joint over all positions, F_lo, V.
        breakaway_low: f32 = 0x1903 "breakaway_low_v", Above(0.0, HUGE), Needed(0.1667);
        /// Highest breakaway effort of the joint over all positions, F_hi, V.
        breakaway_high: f32 = 0x1904 "breakaway_high_v",
            Between(law.breakaway_low, HUGE), Needed(1.0);
        /// Counts by which the load's encoder changes at rest; 2 for noise of a count to either
        /// side.
        jitter: f32 = 0x1905 "jitter_counts", Between(0.0, 100.0), Default(0.0);
        /// Counts by which the motor's encoder changes at rest, beside one on the load.
        motor_jitter: f32 = 0x1906 "motor_jitter_counts", Between(0.0, 100.0), Default(0.0);
        /// Largest load that drives the joint u_L, V. Off: no load does.
        load: f32 = 0x1907 "load_v", OrOff(0.0, HUGE), Default(0.0);
        /// Effort that holds the joint where it is armed, V.
        hold_effort: f32 = 0x1908 "hold_effort_v", Between(-HUGE, HUGE), Default(0.0);
        /// Largest error at rest that is left alone, counts of the load.
        stop_band: f32 = 0x1909 "stop_band_counts", Between(0.0, HUGE), Default(1.25);
        /// After eight times this number of attempts the law gives up; after twice, it stops at a
        /// rest close to the target. 0: it never does.
        attempts: u32 = 0x190A "give_up_attempts", Between(0.0, 60000.0), Default(50);
        /// Stiffness K of the gear between two encoders, V/deg. 0: unknown.
        stiffness: f32 = 0x190B "stiffness_v_per_deg", Between(0.0, HUGE), Default(0.0);
        /// Moment of inertia of the motor alone J_m, V s^2/deg, for a joint with two encoders. 0: a
        /// fifth of all to begin with.
        motor_inertia: f32 = 0x190C "motor_inertia_v_s2_per_deg",
            Between(0.0, HUGE), Default(0.0);
        /// Speed of the inner profile v_m, deg/s. 0: that of the rule.
        speed: f32 = 0x190D "speed_deg_per_s", Between(0.0, HUGE), Default(0.0);
    }
}

impl RobustDualGains {
    /// Returns the parameters of the same joint for `robust`, with the motor's encoder alone.
    pub const fn of_motor(&self) -> RobustGains {
        RobustGains {
            inertia: self.inertia,
            viscous: self.viscous,
            breakaway_low: self.breakaway_low,
            breakaway_high: self.breakaway_high,
            encoder_side: EncoderSide::Motor,
            jitter: self.motor_jitter,
            load: self.load,
            hold_effort: self.hold_effort,
            stop_band: self.stop_band,
            attempts: self.attempts,
            speed: self.speed,
            coast_time: COAST_S,
            ..<RobustGains as Table>::EXAMPLE
        }
    }

    /// Returns the values by the rules of `robust`.
    pub(super) fn rules(&self, around: &Loop) -> Rules {
        Rules::new(&self.of_motor(), around)
    }

    /// Returns the twist under the largest breakaway effort and load, deg. An unknown gear counts
    /// as the softest one that the law is made for: with the motor held still, a load of a fifth of
    /// the inertia swings at 5 Hz.
    pub(super) fn largest_twist(&self) -> f32 {
        let softest = core::f32::consts::TAU * 5.0;
        let stiffness = if self.stiffness > 0.0 {
            self.stiffness
        } else {
            0.2 * self.inertia * softest * softest
        };
        (self.breakaway_high + self.load) / stiffness
    }

    /// Returns half the width of the range of twists before anything was seen, deg: a quarter of
    /// the twist of the middle breakaway effort, or four counts.
    pub(super) fn first_level(&self, count: f32) -> f32 {
        if self.stiffness > 0.0 {
            0.25 * libm::sqrtf(self.breakaway_low * self.breakaway_high) / self.stiffness
        } else {
            4.0 * count
        }
    }
}

/// Wait and rest after an attempt, and the rest that the twist levels need, s.
pub(super) const COAST_S: f32 = 0.02;
