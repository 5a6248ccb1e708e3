//! The controlled stop: the loop brakes the joint before the output goes off.
//!
//! ```text
//! a stop, or a silent link -> theta_d from where the joint is, as fast as it is, slowing down by
//!                             a = max(profile's acceleration, 1.5 |v| / stop_s)
//! the joint rests, or stop_s is over -> the output is off
//! ```
//!
//! The set point rests after two thirds of `stop_s` at the latest, so that the joint has time to
//! trail. The effort is that of the law, within the limits of the drive and of a homing. All
//! monitors stay on; a fault turns the output off at once.
//!
//! There is no controlled stop, and the joint coasts, if `stop_s` is 0, if the joint rests, if the
//! loop is open, or if the driver still wakes up. A second stop turns the output off at once.
//!
//! Does badly: it relies on the encoder. A joint driven by its load moves on once the output is
//! off, as after any stop.

use super::{Servo, State};
use crate::control::reference::{Braking, Reference};
use crate::motion::Course;
use crate::safety::fault::LatchedFault;
use crate::units::position::Position;

/// Longest time in which the set point comes to rest, as a part of `stop_s`.
const SET_POINT: f32 = 2.0 / 3.0;

/// A controlled stop under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stopping {
    /// Ticks until the output is off.
    left: u32,
    /// Fault that caused the stop; none for a commanded stop.
    fault: Option<LatchedFault>,
}

/// Settings of a controlled stop, and units of a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Brakes {
    /// Longest time of a stop, s.
    pub time: f32,
    /// Acceleration of the profile, deg/s^2.
    pub acceleration: f32,
    /// Time of a tick, s.
    pub tick: f32,
    /// Angle of a count, deg.
    pub count: f32,
}

impl Brakes {
    /// Returns the reference that brakes a joint at `counts` and `velocity` (deg/s).
    fn reference(&self, counts: i32, velocity: f32) -> Reference {
        let least = velocity.abs() / (SET_POINT * self.time);
        Reference::Braking(Braking {
            from: Position::from_counts(counts),
            velocity,
            deceleration: self.acceleration.max(least),
            tick: self.tick,
            count: self.count,
        })
    }
}

impl Servo {
    /// Brakes the joint and turns the output off, within `stop_s`. If no controlled stop is
    /// possible, or one is already under way, the output goes off at once.
    pub fn come_to_rest(&mut self) {
        if self.stopping.is_some() || !self.begin_stop(None) {
            self.stop();
        }
    }

    /// Returns whether a controlled stop is under way.
    pub const fn is_stopping(&self) -> bool {
        self.stopping.is_some()
    }

    /// Begins a controlled stop, after which `fault` is latched. Returns whether the stop has
    /// begun.
    #[inline(never)]
    pub(super) fn begin_stop(&mut self, fault: Option<LatchedFault>) -> bool {
        let rests = self.is_at_rest();
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            return false;
        };
        let brakes = control_loop.brakes;
        if rests || control_loop.course.is_open() || self.wake_up.is_on() || brakes.time <= 0.0 {
            return false;
        }
        let reference = brakes.reference(control_loop.state.counts(), self.velocity);
        control_loop.begin(Course::Follow(reference));
        // The client that requested the stop need not be connected any more.
        control_loop.watch.ignore_link();
        self.stopping = Some(Stopping { left: (brakes.time / brakes.tick) as u32, fault });
        true
    }

    /// Runs a tick of a controlled stop, and ends the stop if the joint rests or the time is over.
    #[inline(never)]
    pub(super) fn go_on_stopping(&mut self) {
        let rests = self.is_at_rest();
        let Some(stopping) = &mut self.stopping else { return };
        stopping.left = stopping.left.saturating_sub(1);
        if stopping.left > 0 && !rests {
            return;
        }
        match stopping.fault {
            Some(fault) => self.latch(fault),
            None => self.stop(),
        }
    }
}
