//! The step reference: a jump from one position to another.
//!
//! `theta_d(t) = from` before the tick of the step and `to` from that tick on. Velocity and
//! acceleration are zero throughout, so that nothing of the jump's impulse reaches the D term. The
//! thesis does not state which derivative of a step its controller used; this is our reading.

use super::Setpoint;
use crate::units::position::Position;

/// A step reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Position of the set point before the step.
    pub from: Position,
    /// Position of the set point from the step on.
    pub to: Position,
    /// The first tick at which the set point has the new position.
    pub at_tick: u32,
}

impl Step {
    /// Returns the set point at a tick.
    ///
    /// ```
    /// use stiction::{units::position::Position, control::reference::Step};
    /// let step = Step { from: Position::default(), to: Position::from_counts(2066), at_tick: 1 };
    /// assert_eq!((step.at(0).position.counts, step.at(1).position.counts), (0, 2066));
    /// ```
    pub const fn at(&self, tick: u32) -> Setpoint {
        Setpoint::at_rest(if tick < self.at_tick { self.from } else { self.to })
    }
}
