//! Push over a window of time: the time of the joint is split at the start and the end of the push.

use super::description::TorquePulse;

/// Tolerance of the start and the end of a push, s. If either is closer than this to the end of a
/// sample, it counts as being there.
const SAME_TIME_S: f64 = 1e-9;

/// A push, or none.
#[derive(Clone, Copy, Debug)]
pub struct Pushes(pub Option<TorquePulse>);

impl Pushes {
    /// Returns the torque (N m) from a time (s) on, and the time for which it is constant (s), at
    /// most `left_s`.
    #[inline]
    pub fn within(&self, time_s: f64, left_s: f64) -> (f64, f64) {
        let Some(push) = self.0 else { return (0.0, left_s) };
        let ends_at = |edge_s: f64| {
            let until = edge_s - time_s;
            if until < left_s - SAME_TIME_S { until } else { left_s }
        };
        if time_s < push.from_s - SAME_TIME_S {
            (0.0, ends_at(push.from_s))
        } else if time_s < push.until_s - SAME_TIME_S {
            (push.torque, ends_at(push.until_s))
        } else {
            (0.0, left_s)
        }
    }
}
