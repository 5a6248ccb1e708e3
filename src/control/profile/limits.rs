//! Limits of a profiled move: `[profile]` of a machine's file.

use crate::units::error::HUGE;
use crate::units::value::table;

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
