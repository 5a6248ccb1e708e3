//! The limits of a move that follow from the gains of the loop.

use super::limits::ProfileLimits;
use crate::control::controller::ControllerConfig;
use crate::units::error::HUGE;

/// Damping ratio of the least damped loop that the derived acceleration is made for. The gains
/// alone do not determine K, the joint's acceleration for each volt. The loop `s^2 + K Kd s + K Kp`
/// has the damping ratio `zeta = Kd sqrt(K / Kp) / 2`. So `K = 4 zeta^2 Kp / Kd^2`, and a loop with
/// more damping can accelerate more.
const DAMPING: f32 = 0.4;

/// Share of the full scale that accelerates, at that damping. The rest is for friction and for the
/// corrections of the loop.
const SHARE: f32 = 0.25;

/// Share of the overspeed limit that a move uses: the overshoot of a loop, and the error of a
/// velocity of a few counts a tick, stay below the limit.
const SPEED: f32 = 0.5;

/// Largest speed if nothing can be derived, deg/s: without Kp or Kd, or with a Kd that looks ahead
/// by less than a tick (Kd < Kp h).
const CRAWL: f32 = 10.0;
/// Time in which that speed is reached, s.
const CRAWL_TIME: f32 = 1.0;
/// Time in which the acceleration is reached, and reversed, s.
const CRAWL_JERK_TIME: f32 = 0.1;

impl ProfileLimits {
    /// Returns the limits that follow from the loop, for a machine's file without them; the
    /// declaration of each value has its rule. `overspeed` is the limit of the speed (deg/s; 0:
    /// off). `gain` is the joint's acceleration for each volt (deg/s^2; 0: unknown).
    pub fn derived(controller: &ControllerConfig, overspeed: f32, gain: f32) -> Self {
        let (pd, drive) = (&controller.pd, &controller.drive);
        let overspeed = if overspeed > 0.0 { overspeed } else { HUGE };
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
}
