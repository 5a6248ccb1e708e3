//! The holding brake: a brake that is closed without power, for a joint that must not move while
//! its output is off.
//!
//! ```text
//!           arm                                    stop       the joint rests
//!  bridge    |~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~|____ off
//!  loop      | hold - - - - - - - - - -| motion - - |brakes - |hold - - -|
//!  brake     |closed      |open ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~|closed
//!            |-soft start-|- open_s - -|                      |- close_s |
//! ```
//!
//! The brake opens after the soft start, since before that the loop cannot hold the joint. A motion
//! that is commanded meanwhile starts once the brake is open. A stop before the brake has begun to
//! open turns the output off at once. A joint at rest is held at its set point while the brake
//! closes. Any fault but a silent link closes the brake and turns the output off in the same tick,
//! and so does a second stop.
//!
//! A course with an open loop (a ramp, a jog, an identification) does not hold the joint: the brake
//! opens while the bridge has no duty, for the same time, or until the joint moves. At the end of
//! such a course the brake closes and the output is off at once.
//!
//! Does badly: a joint that is blocked before its target is pressed on until the brake is closed.
//! There is no sensor of the brake. A brake that does not open is a stall of the first
//! motion, and one that does not close is not detected.

use super::stopping::{Phase, Transition};
use super::{BrakeCommand, Servo, State};
use crate::control::reference::{Reference, Step};
use crate::motion::Course;
use crate::parameters::Parameters;
use crate::safety::fault::LatchedFault;

/// The times of a holding brake, ticks, of which both are zero without one; and that of a short
/// brake after a fault.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BrakeTimes {
    // 2 s at 10 kHz fit 16 bits. A larger loop has fields beyond the reach of an instruction.
    open: u16,
    close: u16,
    short: u32,
}

impl BrakeTimes {
    pub fn of(parameters: &Parameters) -> Self {
        let device = &parameters.device;
        Self {
            open: parameters.ticks_at_least(device.brake_open) as u16,
            close: parameters.ticks_at_least(device.brake_close) as u16,
            short: parameters.ticks_at_least(device.short_brake),
        }
    }

    /// Returns the ticks in which the holding brake opens.
    fn open(self) -> u32 {
        self.open.into()
    }

    /// Returns the ticks of a short brake; 0: the joint coasts.
    pub const fn short(self) -> u32 {
        self.short
    }

    pub const fn has_brake(&self) -> bool {
        self.open > 0 || self.close > 0
    }
}

impl Servo {
    /// Begins to hold the joint until the brake is open. The motion waits.
    #[inline(never)]
    pub(super) fn begin_opening(&mut self) {
        let Some(control_loop) = &mut self.control_loop else { return };
        let open = control_loop.holding_brake.open();
        if !control_loop.holding_brake.has_brake() {
            return;
        }
        if control_loop.course.is_open() {
            self.wake_up.open_brake(open);
            return;
        }
        let left = control_loop.state.soft_start_left(&control_loop.controller) + open;
        if left > 0 {
            self.transition = Some(Transition { phase: Phase::Opening, left, fault: None });
            self.postpone();
        }
    }

    /// Returns whether the brake has not begun to open: the joint needs nothing that holds it.
    pub(super) fn is_still_closed(&self) -> bool {
        let open = self.control_loop.as_ref().map_or(0, |of_joint| of_joint.holding_brake.open());
        let Some(Transition { phase: Phase::Opening, left, .. }) = self.transition else {
            return false;
        };
        left >= open
    }

    const fn is_opening(&self) -> bool {
        matches!(self.transition, Some(Transition { phase: Phase::Opening, .. }))
    }

    /// Keeps the motion of the loop until the brake is open, and holds the joint meanwhile.
    pub(super) fn postpone(&mut self) {
        if let (true, Some(control_loop)) = (self.is_opening(), &mut self.control_loop) {
            self.pending = Course::default();
            core::mem::swap(&mut control_loop.course, &mut self.pending);
        }
    }

    /// Runs a tick of the opening, with `left` ticks left, this one included.
    pub(super) fn go_on_opening(&mut self, left: u32) -> BrakeCommand {
        let opens = |open| if left <= open { BrakeCommand::Open } else { BrakeCommand::Closed };
        let open = self.control_loop.as_ref().map_or(0, |of_joint| of_joint.holding_brake.open());
        if left <= 1 {
            self.end_transition();
            if let Some(control_loop) = &mut self.control_loop {
                control_loop.course.restart(0);
                if let Some(home) = &mut control_loop.home {
                    home.restart(0);
                }
                control_loop.state.begin_motion();
            }
        }
        opens(open)
    }

    /// Ends a transition. The motion that waited is that of the loop again.
    pub(super) fn end_transition(&mut self) {
        let is_waiting = self.is_opening() || self.is_testing();
        self.transition = None;
        if let (true, Some(control_loop)) = (is_waiting, &mut self.control_loop) {
            core::mem::swap(&mut control_loop.course, &mut self.pending);
        }
    }

    /// Begins to close the brake, while the loop holds the joint at its set point: a law without an
    /// integral needs the error to hold a load. `fault` is latched afterwards. Returns whether this
    /// has begun: without a brake that is open, or without a closed loop, there is nothing to hold
    /// for.
    pub(super) fn begin_closing(&mut self, fault: Option<LatchedFault>) -> bool {
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            return false;
        };
        let close = u32::from(control_loop.holding_brake.close);
        if close == 0 || control_loop.course.is_open() || self.wake_up.is_on() {
            return false;
        }
        let at = control_loop.setpoint().position;
        // Not a new motion: a law that has given up does not try again.
        control_loop.course =
            Course::Follow(Reference::Step(Step { from: at, to: at, at_tick: 0 }));
        control_loop.replaced = true;
        control_loop.watch.ignore_link();
        // The tick in which the brake begins to close is the first one.
        self.transition = Some(Transition { phase: Phase::Closing, left: close + 1, fault });
        true
    }
}
