//! A push over time: the joint's time is split where it begins and ends.

use super::description::TorquePulse;

/// A window or a sample that ends closer than this ends together with it, s.
const SAME_TIME_S: f64 = 1e-9;

/// A push, or none.
#[derive(Clone, Copy, Debug)]
pub struct Pushes(pub Option<TorquePulse>);

impl Pushes {
    /// The torque from a time on, and how long it stays so, at most `left_s`.
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
