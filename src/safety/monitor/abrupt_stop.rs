//! Counts that stop faster than effort and friction can stop a joint: the encoder has died in
//! motion, or the joint has hit something hard.
//!
//! ```text
//! deceleration <= g (F - u)              u: effort with the motion, F: stall_v, g: stop_gain
//! A = g (F - u) T^2 / count              what that takes off in a time T, counts per T
//! n <= 2.5 A + 2                         counts in a time T, if a time T later there are none
//! ```
//!
//! Time is divided into pieces of T = 20 ms, or of a tick if that is longer. The monitor trips when
//! a piece has had more counts than the bound, one way, and the second piece after it has had one
//! count at most. The stop lies in the piece between them, at any time. `u` is the least effort of
//! all three.
//!
//! The bound, with `a` for `A`: a joint that makes a count or less (less than two, rounded) in the
//! last piece begins it with no more than `sqrt(4 a)`; it begins the piece before with `a` more;
//! and in the first piece, `a` faster still at its begin, it makes `1.5 a + sqrt(4 a)`. That is at
//! most `2.5 a + 1`, since `2 sqrt(a) <= a + 1`, and rounding adds a count. The bound leaves
//! viscous friction out. If the joint's own time constant is 0.1 s or more, viscous friction
//! reduces the speed by less than half in two pieces; the factor of two in the derived `stop_gain`
//! covers that.
//!
//! This monitor detects an encoder that dies in motion at any effort, even between the levels of
//! friction, which [`super::stall_impulse`] does not add up. Does badly: a joint that creeps may
//! stop at once, and so does not trip this monitor. tests/evidence/reliability.md has the speeds of
//! such joints.

use super::limits::{Limits, Units};

/// Length of the pieces of time in which the monitor adds up the counts, s. A piece is at least a
/// tick long.
const PIECE: f32 = 0.02;

/// Monitor of counts that stop within two pieces of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct AbruptStop {
    /// Ticks of a piece.
    ticks: i32,
    /// Effort beyond any friction, F, codes.
    friction: i32,
    /// Counts per code, 2.5 g T^2.
    counts: f32,
}

/// A piece of time: what the joint has travelled, and the least effort with the motion, codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Piece {
    travel: i32,
    least: i32,
}

/// The last three pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct AbruptStopState {
    /// Whether the joint moved in the negative direction when it last made two counts or more in a
    /// piece.
    backwards: bool,
    /// Ticks of the present piece; below zero it has not begun yet.
    ticks: i32,
    now: Piece,
    before: Piece,
    first: Piece,
}

impl AbruptStopState {
    /// Suspends the monitor for an expected stop of the joint: no piece begins for 2^31 ticks, two
    /// days at 10 kHz, or until the state is reset. A flag would cost time in every tick.
    pub const fn expect(&mut self) {
        self.ticks = i32::MIN;
    }
}

impl AbruptStop {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        // Disabled together with the stall monitor.
        // 200 at most, at 10 kHz.
        let ticks = Units::whole(PIECE, units.tick).min(1 << 16) as i32;
        let piece = ticks as f32 * units.tick;
        let counts = match limits.stop_gain {
            gain if gain > 0.0 && limits.stall_effort > 0.0 => {
                2.5 * gain * units.code * piece * piece / units.count
            }
            _ => f32::INFINITY,
        };
        Self { ticks, friction: (limits.stall_effort / units.code) as i32, counts }
    }

    /// Updates the state with the travel of this tick (counts) and the code that was applied
    /// meanwhile. Returns whether the monitor trips.
    #[inline]
    pub fn check(&self, state: &mut AbruptStopState, code: i32, travel: i32) -> bool {
        let with = if state.backwards { code.saturating_neg() } else { code };
        state.now.travel = state.now.travel.saturating_add(travel);
        state.now.least = if state.ticks == 0 { with } else { state.now.least.min(with) };
        state.ticks += 1;
        if state.ticks < self.ticks {
            return false;
        }
        let AbruptStopState { backwards, now, before, first, .. } = *state;
        let next = AbruptStopState {
            ticks: 0,
            now: Piece::default(),
            before: now,
            first: before,
            backwards,
        };
        *state = next;
        if now.travel.unsigned_abs() > 1 {
            if (now.travel < 0) != backwards {
                // Its efforts were taken with the other sign: it is not judged.
                let now = Piece { least: i32::MIN, ..now };
                *state = AbruptStopState {
                    backwards: !backwards,
                    before: now,
                    ..AbruptStopState::default()
                };
            }
            return false;
        }
        let least = now.least.min(before.least).min(first.least);
        let most = self.counts * self.friction.saturating_sub(least).max(1) as f32 + 2.0;
        first.travel.unsigned_abs() as f32 > most
    }
}
