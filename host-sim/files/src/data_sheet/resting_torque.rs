//! The largest torque against which a joint can rest. The limits of its monitors are derived from
//! it: `limits.breakaway_v`, `stall_v`, `stall_impulse_vs`, `wind_up_v` and the limits of `[jog]`.
//!
//! ```text
//! T = max(F_s+, F_s-) + |d| + U      V = T / G
//! ```
//!
//! F_s is the static friction of either direction, d the constant load, U the unbalance (its torque
//! in the horizontal position), G the effort gain. An effort above V moves the joint from any
//! position, in either direction.
//!
//! Limits: where the load helps, V is more than the joint needs. A dead encoder is then detected
//! later, by a factor of at most (F_s + |d| + U) / F_s.

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
