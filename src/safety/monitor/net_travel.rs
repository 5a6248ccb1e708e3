//! Effort beyond the breakaway on average, and no net travel in its direction.
//!
//! ```text
//! |sum u| > N B    and    -64 < sign(sum u) (p2 - p1) < 4 counts      over N ticks, 5 s
//! ```
//!
//! u is the effort of a tick and B is `breakaway_v`. p1 and p2 are the mean positions (counts) of
//! the first and of the second half of the N ticks. A joint that stays where it is needs no more
//! than its breakaway effort on average, however much it hunts. So the counts come from elsewhere:
//! a line that picks up noise and counts while the loop holds its set point drives the joint the
//! other way.
//!
//! [`super::stall_impulse`] accepts any two counts as a sign of a working encoder, and a loop that
//! works against false counts has them all the time. This monitor judges only the net travel that
//! remains of them. Its period is longer than the time in which [`super::stall_impulse`] trips, so
//! a joint that rests under too much effort trips no sooner than without this monitor. If the net
//! travel against the effort is more than 64 counts, the joint is being braked, and the monitor
//! does not trip.
//!
//! Guarantees: an encoder that counts while the joint creeps under more than B on average is
//! detected at the end of a period whose two means agree within four counts.
//!
//! Does badly: a creeping joint needs an effort of its slip friction F plus its viscous friction b
//! times the speed, which may be less than B. Up to a speed of (B - F) / b, 1 deg/s on the thesis's
//! joint, no effort contradicts the counts. Only a second encoder detects that. A loop that hunts
//! by many counts has means that differ by chance, and needs several periods. A moving set point is
//! net travel. A hub that slips looks like a joint with more inertia.

use super::limits::{Limits, Units};

/// Length of a period, s. The least excess of the impulse trips after eight times its 0.5 s, and an
/// excess of whole codes takes up to a quarter longer.
const PERIOD: f32 = 5.0;

/// Net travel that is due, as a difference of the means, counts. A joint that creeps evenly travels
/// twice this difference in a period.
const DUE: f32 = 4.0;

/// Net travel against the effort from which a joint counts as braked, counts.
const BRAKED: f32 = 64.0;

/// Monitor of the mean effort and the net travel.
#[derive(Clone, Copy, Debug)]
pub(super) struct NetTravel {
    /// Ticks of half a period.
    half: u32,
    /// Largest sum of the effort in a period, codes times ticks.
    most: u32,
}

/// State of the present period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NetTravelState {
    /// Ticks of this half.
    ticks: u32,
    /// Sum of the effort, codes times ticks.
    sum: i32,
    /// Position at the start of the period, counts.
    start: i32,
    /// Travel since then, added up over the ticks of this half, counts.
    travels: f32,
    /// The same of the first half, once it is over.
    first: Option<f32>,
}

impl NetTravel {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        // Disabled together with the stall monitor.
        let is_on = limits.breakaway_effort > 0.0 && limits.stall_effort > 0.0;
        let half = Units::whole(0.5 * PERIOD, units.tick);
        // Towards zero: the largest code that is no more than the breakaway.
        let code = (limits.breakaway_effort / units.code) as u32;
        Self { half, most: if is_on { code.saturating_mul(2 * half) } else { u32::MAX } }
    }

    /// Updates the state with the code that is about to be applied and the position (counts).
    /// Returns whether the monitor trips.
    #[inline]
    pub fn check(&self, state: &mut NetTravelState, code: i32, position: i32) -> bool {
        state.sum = state.sum.saturating_add(code);
        state.travels += position.wrapping_sub(state.start) as f32;
        state.ticks += 1;
        state.ticks >= self.half && self.end_half(state, position)
    }

    /// Ends a half of the period. After the second half, judges the period and begins the next one.
    #[cold]
    #[inline(never)]
    fn end_half(&self, state: &mut NetTravelState, position: i32) -> bool {
        let Some(first) = state.first else {
            *state =
                NetTravelState { ticks: 0, travels: 0.0, first: Some(state.travels), ..*state };
            return false;
        };
        let made = (state.travels - first) / self.half as f32 * state.sum.signum() as f32;
        let is_beyond = state.sum.unsigned_abs() > self.most;
        *state = NetTravelState::at(position);
        is_beyond && -BRAKED < made && made < DUE
    }
}

impl NetTravelState {
    /// Returns a period that begins at a position, counts.
    pub fn at(start: i32) -> Self {
        Self { start, ..Self::default() }
    }
}
