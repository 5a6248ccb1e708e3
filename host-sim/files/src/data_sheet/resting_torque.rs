//! The largest torque against which a joint can rest: the rule from which the limits of its
//! monitors are derived (`limits.breakaway_v`, and with it `stall_v`, `stall_impulse_vs`,
//! `wind_up_v` and the bounds of `[jog]`).
//!
//! ```text
//! T = max(F_s+, F_s-) + |d| + U      V = T / G
//! ```
//!
//! F_s is the static friction of either direction, d the constant load, U the unbalance (its torque
//! where it lies level), G the effort gain. A joint that is held against its load rests under any
//! effort up to V, wherever it stands; more than V moves it, whichever way that is.
//!
//! Does badly: where the load helps, V is more than the joint needs. A dead encoder is then detected
//! later, after at most (F_s + |d| + U) / F_s of the time.

use super::sheet::DataSheet;

/// Returns the largest torque (N m) against which a joint with this static friction, constant load
/// and unbalance (N m each) can rest.
pub fn resting_torque(stick: f64, constant: f64, unbalance: f64) -> f64 {
    stick + constant.abs() + unbalance.abs()
}

impl DataSheet {
    /// Returns the largest torque against which the joint can rest, N m.
    pub fn resting_torque(&self) -> f64 {
        let [forward, backward] = self.stick();
        resting_torque(forward.max(backward), self.load.constant_nm, self.load.unbalance_nm)
    }
}
