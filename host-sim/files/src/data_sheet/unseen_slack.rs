//! Slack between the encoder and the load: backlash and wind-up of the gear that an encoder on the
//! motor cannot measure.
//!
//! With the encoder on the motor, the load's angle differs from the measured one by
//!
//! ```text
//! |x_l - x_m| <= backlash + T / k      T <= F_l + |d|
//! ```
//!
//! T is the torque in the gear at rest, k the gear's stiffness, F_l the load's share of the static
//! friction, d the load's torque (constant and unbalance). The whole backlash counts, not its half:
//! the encoder is zeroed with the load on either flank. In motion, the load's inertia adds to T.

use std::fmt;

use super::axis::MOTOR_SHARE;
use super::sheet::DataSheet;
use super::tables::EncoderPlace;
use crate::error::rounded;

/// Slack of a gear that the encoder cannot measure.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct UnseenSlack {
    /// Backlash at the joint, deg.
    pub backlash_deg: f64,
    /// Backlash in counts of the encoder.
    pub backlash_counts: f64,
    /// Largest wind-up of the gear at rest, deg.
    pub wind_up_deg: f64,
}

impl UnseenSlack {
    /// Returns the slack of a data sheet's gear; none if the position loop has an encoder on the
    /// load, or the gear is rigid. One count is `count_deg`, deg.
    pub fn of(sheet: &DataSheet, count_deg: f64) -> Option<Self> {
        let stiffness =
            sheet.stiffness().filter(|_| sheet.position_side() == Some(EncoderPlace::Motor))?;
        let backlash_deg = sheet.backlash().unwrap_or(0.0).to_degrees();
        let [forward, backward] = sheet.stick();
        let load_share = 1.0 - sheet.friction.motor_share.unwrap_or(MOTOR_SHARE);
        let torque = load_share * forward.max(backward)
            + sheet.load.constant_nm.abs()
            + sheet.load.unbalance_nm;
        Some(Self {
            backlash_deg,
            backlash_counts: backlash_deg / count_deg,
            wind_up_deg: (torque / stiffness).to_degrees(),
        })
    }
}

impl fmt::Display for UnseenSlack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { backlash_deg, backlash_counts, wind_up_deg } = *self;
        let wind_up = rounded(wind_up_deg);
        if backlash_deg == 0.0 {
            return write!(
                f,
                "this encoder cannot see the wind-up of the gear; the load can be up to \
                 {wind_up} deg off at rest"
            );
        }
        write!(
            f,
            "this encoder cannot see {backlash_counts:.0} counts of backlash; the load can be \
             up to {} deg off, plus the wind-up of the gear (up to {wind_up} deg at rest)",
            rounded(backlash_deg)
        )
    }
}
