//! The PD loop, to which a compensator adds its output.
//!
//! Eq. 28 without its compensator term:
//!
//! ```text
//! v_PD = Kp (theta_d - theta_a) + Kd (theta_d' - theta_a')
//! ```
//!
//! Guarantees: on a joint with viscous friction alone, and with gains for which the sampled loop is
//! stable, the joint comes to rest on target. Does badly: with stick friction the joint rests
//! anywhere within `v_stick / Kp` of the target, forever and with effort applied; at constant speed
//! it trails by `(v_slip + b theta_d') / Kp`.

use crate::units::error::HUGE;
use crate::units::value::table;

table! {
    /// Gains of the PD loop.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct PdGains (pd) "controller" {
        /// Proportional gain Kp, V/deg.
        kp: f32 = 0x0401 "kp_v_per_deg", Between(0.0, HUGE), Needed(1.0);
        /// Derivative gain Kd, V/(deg/s).
        kd: f32 = 0x0402 "kd_v_per_deg_per_s", Between(0.0, HUGE), Needed(0.15);
    }
}

impl PdGains {
    /// Returns v_PD, V, for a position error (deg) and a velocity error (deg/s).
    ///
    /// ```
    /// let pd = stiction::control::pd::PdGains { kp: 1.0, kd: 0.25 };
    /// assert_eq!(pd.update(2.0, -4.0), 1.0);
    /// ```
    pub fn update(&self, error: f32, velocity_error: f32) -> f32 {
        self.kp * error + self.kd * velocity_error
    }
}
