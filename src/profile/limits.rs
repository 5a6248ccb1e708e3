//! Limits of a profiled move: `[profile]` of a machine's file.

use super::grid::{Grid, VELOCITY};
use crate::controller::ControllerConfig;
use crate::error::{Allowed, Error, HUGE};
use crate::monitor::Limits;
use crate::value::{Key, Table, key, table};

/// Damping ratio of the least damped loop that the derived acceleration is made for. The gains
/// alone do not determine the joint's acceleration a volt, K: of a joint with K, the loop
/// `s^2 + K Kd s + K Kp` has the damping ratio `zeta = Kd sqrt(K / Kp) / 2`. So `K = 4 zeta^2 Kp /
/// Kd^2`, and one that was found for more damping can do more.
const DAMPING: f32 = 0.4;

/// Share of the full scale that accelerates, at that damping. The rest is for friction and for what
/// the loop corrects.
const SHARE: f32 = 0.25;

/// Share of the overspeed limit that a move uses: what a loop overshoots, and what a velocity of a
/// few counts a tick is off, stays below the limit.
const SPEED: f32 = 0.5;

/// Without Kp or Kd nothing can be derived, nor of a Kd that looks ahead by less than a tick (Kd <
/// Kp h). The speed is then no more than this, deg/s.
const CRAWL: f32 = 10.0;
/// That speed is reached in this time, s.
const CRAWL_TIME: f32 = 1.0;
/// The acceleration is reached in this time, s.
const CRAWL_JERK_TIME: f32 = 0.1;

const OVERSPEED: Key = key(Limits::ABOUT, "overspeed");

table! {
    /// Limits of a profiled move in a user's units. None of them is ever off.
    ///
    /// The examples are those of the thesis's loop under PD (5 V, Kp 1 V/deg, Kd 0.15 V s/deg, 20
    /// ms).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ProfileLimits (profile) "profile" {
        /// Largest velocity, deg/s, no more than `overspeed_deg_per_s`. Derived: half of that,
        /// times `duty_max`.
        /// Without Kp, or with Kd below Kp times the sample time, no more than 10.
        velocity: f32 = 0x0A01 "velocity_deg_per_s", Above(0.0, HUGE), Derived(41.666_668);
        /// Largest acceleration, deg/s^2. Derived: a quarter of the full scale times `duty_max`, on
        /// a joint on which Kp and Kd have a damping ratio of 0.4, or on the file's joint if that
        /// has less gain. Without Kp and Kd, the velocity in a second.
        acceleration: f32 = 0x0A02 "acceleration_deg_per_s2", Above(0.0, 1e9), Derived(35.555_56);
        /// Largest jerk, deg/s^3. Derived: the acceleration is reached, and turned, within the
        /// loop's own time constant Kd / (2 Kp). Without them, within 0.1 s.
        jerk: f32 = 0x0A03 "jerk_deg_per_s3", Above(0.0, 1e15), Derived(948.148_2);
    }
}

impl ProfileLimits {
    /// What can be derived from the loop and its limits, for machines that say nothing of it; the
    /// sentence of each value says how. `gain` is the joint's acceleration for each volt (deg/s^2),
    /// or zero if it is not known.
    pub fn derived(controller: &ControllerConfig, limits: &Limits, gain: f32) -> Self {
        let (pd, drive) = (&controller.pd, &controller.drive);
        let overspeed = if limits.overspeed > 0.0 { limits.overspeed } else { HUGE };
        let velocity = SPEED * overspeed * drive.duty_max;
        let derived = if pd.kp > 0.0 && pd.kd >= pd.kp * controller.sample_time {
            let of_gains = 4.0 * DAMPING * DAMPING * pd.kp / (pd.kd * pd.kd);
            let gain = if gain > 0.0 && gain < of_gains { gain } else { of_gains };
            let acceleration = SHARE * drive.full_scale * drive.duty_max * gain;
            let time_constant = 0.5 * pd.kd / pd.kp;
            Self { velocity, acceleration, jerk: 2.0 * acceleration / time_constant }
        } else {
            let velocity = if velocity < CRAWL { velocity } else { CRAWL };
            let acceleration = velocity / CRAWL_TIME;
            Self { velocity, acceleration, jerk: 2.0 * acceleration / CRAWL_JERK_TIME }
        };
        derived.nearest(controller.sample_time, controller.encoder.resolution)
    }

    /// Returns the limits nearest to these that the generator can keep at a sample time (s) and an
    /// angle of a count (deg).
    pub fn nearest(&self, sample_time: f32, resolution: f32) -> Self {
        Grid::nearest(self, sample_time, resolution)
    }

    /// Refuses limits that the generator cannot keep at this sample time and encoder, and a
    /// velocity at which every move would trip the overspeed.
    ///
    /// # Errors
    /// Names the limit, and what it may be beside the others.
    pub(crate) fn check(
        &self,
        controller: &ControllerConfig,
        limits: &Limits,
    ) -> Result<(), Error> {
        if limits.overspeed > 0.0 && self.velocity > limits.overspeed {
            let allowed = Allowed::UpTo(limits.overspeed, OVERSPEED);
            return Err(Error { key: VELOCITY, found: self.velocity, allowed });
        }
        Grid::new(self, controller.sample_time, controller.encoder.resolution).map(|_| ())
    }
}
