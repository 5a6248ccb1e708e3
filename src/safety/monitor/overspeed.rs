//! Speed beyond what the loop was made for: an overhauling load, or a loop that runs away.
//!
//! The speed of each tick is that of the regression. A law that ends its own swings defines a time
//! T in which the joint may swing ([`Law::swing_time`](crate::control::laws::Law::swing_time)). If
//! the window of the regression is shorter than T, the speed is the mean over the last T:
//!
//! ```text
//! v = (n_1 + n_2) count / T       n_1, n_2: travel in the last two pieces of T / 2, counts
//! ```
//!
//! A motor that swings against its elastic gear goes to and fro within T, and a joint that runs
//! away does not. So the mean distinguishes them, and the peak of the speed does not.
//!
//! By the regression, a jump in speed is detected within the regression's window. By the mean, it
//! is detected at most 1.5 T later, and earlier the faster the joint is.

use super::limits::{Limits, Units};

/// Monitor of the measured speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overspeed {
    fastest: f32,
    /// Ticks of half the averaging time; zero: no mean is used.
    ticks: u32,
    /// Mean speed for each count in both pieces, deg/s.
    per_count: f32,
}

/// Travel in the last two pieces of time, counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct OverspeedState {
    ticks: u32,
    now: i32,
    before: i32,
}

impl Overspeed {
    /// Makes the monitor for a regression over `window` positions. `swing_time` is the averaging
    /// time if the law ends swings itself, s; otherwise zero.
    pub fn new(limits: &Limits, window: u32, swing_time: f32, units: &Units) -> Self {
        let fastest = if limits.overspeed > 0.0 { limits.overspeed } else { f32::INFINITY };
        let regressed = window.saturating_sub(1) as f32 * units.tick;
        let ticks =
            if swing_time > regressed { Units::whole(0.5 * swing_time, units.tick) } else { 0 };
        let per_count = units.count / (2.0 * ticks.max(1) as f32 * units.tick);
        Self { fastest, ticks, per_count }
    }

    /// Updates the state with the speed of the regression (deg/s) and the travel of this tick
    /// (counts). Returns the speed (deg/s) if it is too large.
    #[inline]
    pub fn check(&self, state: &mut OverspeedState, velocity: f32, travel: i32) -> Option<f32> {
        if self.ticks == 0 {
            return (velocity.abs() > self.fastest).then_some(velocity);
        }
        state.now = state.now.saturating_add(travel);
        state.ticks += 1;
        if state.ticks < self.ticks {
            return None;
        }
        let mean = state.before.saturating_add(state.now) as f32 * self.per_count;
        *state = OverspeedState { ticks: 0, now: 0, before: state.now };
        (mean.abs() > self.fastest).then_some(mean)
    }
}
