//! The controlled stop: the loop brakes the joint before the output goes off.
//!
//! ```text
//! a stop, or a silent link -> theta_d from where the joint is, as fast as it is, slowing down by
//!                             a = max(profile's acceleration, 1.5 |v| / stop_s)
//! the joint rests, or stop_s is over -> the holding brake closes, then the output is off
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

use super::{BrakeCommand, Output, Servo, State};
use crate::control::reference::{Braking, Reference};
use crate::control::signal::Tick;
use crate::motion::Course;
use crate::safety::fault::LatchedFault;
use crate::units::position::Position;

/// Longest time in which the set point comes to rest, as a part of `stop_s`.
const SET_POINT: f32 = 2.0 / 3.0;

/// What the loop does before a motion starts, or before the output goes off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transition {
    pub phase: Phase,
    /// Ticks until the phase is over.
    pub left: u32,
    /// Fault that caused the stop; none for a commanded stop.
    pub fault: Option<LatchedFault>,
}

/// Phase of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// The joint is held until the holding brake is open.
    Opening,
    /// A test at arming runs.
    Testing,
    /// A controlled stop brakes the joint.
    Stopping,
    /// The joint is held until the holding brake is closed.
    Closing,
    /// After a fault, the output is at zero volts (`servo/short_brake.rs`).
    ShortBrake,
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
    /// Brakes the joint and turns the output off, within `stop_s` and the time of a holding brake.
    /// If no controlled stop is possible, or one is already under way, the output goes off at once.
    pub fn come_to_rest(&mut self) {
        if self.is_stopping() || !self.begin_to_rest(None) {
            self.stop();
        }
    }

    /// Returns whether a controlled stop is under way.
    pub const fn is_stopping(&self) -> bool {
        matches!(self.transition, Some(Transition { phase: Phase::Stopping | Phase::Closing, .. }))
    }

    /// Begins a controlled stop of a joint that moves, or closes the holding brake of a joint at
    /// rest. `fault` is latched afterwards. Returns whether either has begun.
    #[inline(never)]
    pub(super) fn begin_to_rest(&mut self, fault: Option<LatchedFault>) -> bool {
        if self.is_still_closed() {
            return false;
        }
        if self.is_at_rest() { self.begin_closing(fault) } else { self.begin_stop(fault) }
    }

    /// Begins a controlled stop, after which `fault` is latched. Returns whether the stop has
    /// begun.
    fn begin_stop(&mut self, fault: Option<LatchedFault>) -> bool {
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            return false;
        };
        let brakes = control_loop.brakes;
        if control_loop.course.is_open() || self.wake_up.is_on() || brakes.time <= 0.0 {
            return false;
        }
        let reference = brakes.reference(control_loop.state.counts(), self.velocity);
        control_loop.begin(Course::Follow(reference));
        // The client that requested the stop need not be connected any more.
        control_loop.watch.ignore_link();
        let left = (brakes.time / brakes.tick) as u32;
        self.transition = Some(Transition { phase: Phase::Stopping, left, fault });
        true
    }

    /// Runs a tick of a transition, and ends its phase if it is over.
    #[inline(never)]
    pub(super) fn go_on(&mut self, tick: Tick) -> Output {
        let brake = self.update_transition();
        if let State::Faulted(_) = self.state {
            return self.tripped(&tick);
        }
        self.held(tick, brake)
    }

    /// Returns the output of a tick that can have turned the output off.
    pub(super) fn held(&self, tick: Tick, brake: BrakeCommand) -> Output {
        match &self.control_loop {
            Some(control_loop) if self.state == State::Armed => {
                self.output(tick, true, control_loop.watch.warning()).with_brake(brake)
            }
            _ => self.off(tick),
        }
    }

    /// Counts a tick of a transition, and returns the command for the holding brake.
    fn update_transition(&mut self) -> BrakeCommand {
        let rests = self.is_at_rest();
        let Some(Transition { phase, left, fault }) = &mut self.transition else {
            return BrakeCommand::Open;
        };
        let (phase, before, fault) = (*phase, *left, *fault);
        *left = before.saturating_sub(1);
        let is_over = before <= 1;
        match phase {
            Phase::Opening => return self.go_on_opening(before),
            Phase::Testing => return self.go_on_testing(before),
            Phase::Stopping if !is_over && !rests => return BrakeCommand::Open,
            Phase::Stopping => {
                if self.begin_closing(fault) {
                    // This tick is the first one.
                    return self.update_transition();
                }
                self.end_stop(fault);
            }
            Phase::Closing if is_over => self.end_stop(fault),
            // A fault has begun the second one, and an armed servo is not in it.
            Phase::Closing | Phase::ShortBrake => {}
        }
        BrakeCommand::Closed
    }

    /// Turns the output off at the end of a stop that `fault` has caused, or a command.
    fn end_stop(&mut self, fault: Option<LatchedFault>) {
        match fault {
            Some(fault) => self.latch(fault),
            None => self.stop(),
        }
    }
}
