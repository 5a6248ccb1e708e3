//! A reference that slows a joint down, from its present position and velocity to rest.
//!
//! ```text
//! theta_d(t) = p + v t - sgn(v) a t^2 / 2     t <= |v| / a; then it rests there
//! ```

use super::Setpoint;
use crate::units::position::Position;

/// A reference that slows down at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Braking {
    /// Position at the start.
    pub from: Position,
    /// Velocity at the start, deg/s.
    pub velocity: f32,
    /// Deceleration, deg/s^2; above zero.
    pub deceleration: f32,
    /// Time of a tick, s.
    pub tick: f32,
    /// Angle of a count, deg.
    pub count: f32,
}

impl Braking {
    /// Returns the set point `tick` ticks after the start.
    ///
    /// ```
    /// use stiction::control::reference::Braking;
    /// use stiction::units::position::Position;
    /// let from = Position::from_counts(100);
    /// let braking = Braking { from, velocity: -8.0, deceleration: 4.0, tick: 0.5, count: 0.1 };
    /// let at = |tick| (braking.at(tick).position.counts, braking.at(tick).velocity);
    /// assert_eq!([0, 2, 4, 9].map(at), [(100, -8.0), (40, -4.0), (20, 0.0), (20, 0.0)]);
    /// ```
    // A stop is rare: its code is not part of every reference's.
    #[inline(never)]
    pub fn at(&self, tick: u32) -> Setpoint {
        let Self { velocity, deceleration, count, .. } = *self;
        let acceleration = -deceleration * velocity.signum();
        let time = self.tick * tick as f32;
        let ends = velocity.abs() / deceleration;
        let t = time.min(ends);
        let way = (velocity + 0.5 * acceleration * t) * t;
        let position = self.from.displaced(way / count);
        if time >= ends {
            return Setpoint::at_rest(position);
        }
        Setpoint { position, velocity: velocity + acceleration * t, acceleration }
    }
}
