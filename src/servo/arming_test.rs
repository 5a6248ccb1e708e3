//! The servo's part of the [test at arming](crate::motion::arming_test): it comes before the loop.
//!
//! ```text
//! arm -> wake-up, brake opens -> test -> rest -> the loop begins where the joint stands, which
//!                                  |             becomes the zero of the motion
//!                                  +-> fault, the output is off
//! ```
//!
//! Each motion with a closed loop waits for the test; a ramp, a jog, an identification and the
//! pulses of the winding have none. The test accepts only a stop. With a holding brake, the brake
//! is open in the test.
//!
//! The monitors that assume the direction of an encoder or the ratio of two are off in the test,
//! as in a jog, and on from its end.
//!
//! A joint that does not come to rest after the test is taken over in motion, after 0.25 s or at
//! the bound of the travel. The soft start begins then. With a holding brake, that is a following
//! error, and the brake closes: the load that it held would fall on during the soft start.

use super::control_loop::leads_out;
use super::stopping::{Phase, Transition};
use super::{BrakeCommand, Servo};
use crate::motion::Course;
use crate::safety::fault::{Fault, LatchedFault};

/// Longest time in which the joint comes to rest after the test, s.
const REST_S: f32 = 0.25;

impl Servo {
    /// Returns whether a test at arming runs or is about to run.
    pub const fn is_testing(&self) -> bool {
        matches!(self.transition, Some(Transition { phase: Phase::Testing, .. }))
    }

    /// Returns whether the latched fault came during a test at arming.
    pub const fn has_failed_test(&self) -> bool {
        self.has_failed_test
    }

    /// Begins the test at arming if there is one; the motion waits.
    // Out of line: most joints have none.
    #[inline(never)]
    pub(super) fn begin_test(&mut self) {
        let origin = self.known_origin();
        let Some(control_loop) = &mut self.control_loop else { return };
        let Some(test) = control_loop.arming_test else { return };
        if control_loop.course.is_open() {
            return;
        }
        let range = control_loop.monitors.range(origin);
        let place = self.follower.seen.position;
        let leads_out = range.check(place.wrapping_add_unsigned(test.travel()));
        self.pending = Course::Jog(test.jog(leads_out));
        core::mem::swap(&mut control_loop.course, &mut self.pending);
        control_loop.watch.suppose_wiring();
        self.transition = Some(Transition { phase: Phase::Testing, left: 0, fault: None });
    }

    /// Runs a tick of the test.
    #[cold]
    #[inline(never)]
    pub(super) fn go_on_testing(&mut self, left: u32) -> BrakeCommand {
        let rests = self.is_at_rest();
        let Some(control_loop) = &self.control_loop else { return BrakeCommand::Closed };
        let Some(test) = &control_loop.arming_test else { return BrakeCommand::Closed };
        let state = &control_loop.state;
        if !state.jog().is_over() {
            let left = (REST_S / control_loop.brakes.tick) as u32;
            self.transition = Some(Transition { phase: Phase::Testing, left, fault: None });
            return BrakeCommand::Open;
        }
        if let Some((fault, value)) = test.fault(state.jog().found()) {
            self.latch(LatchedFault { fault, tick: self.clock, value });
            return BrakeCommand::Closed;
        }
        if rests {
            self.end_test();
        } else if left <= 1 || state.counts().unsigned_abs() > test.travel() {
            if control_loop.holding_brake.has_brake() {
                // The soft start of the loop would let the load fall on, and the brake holds it.
                let value = state.counts() as f32 * control_loop.brakes.count;
                self.latch(LatchedFault { fault: Fault::FollowingError, tick: self.clock, value });
                return BrakeCommand::Closed;
            }
            self.end_test();
        }
        BrakeCommand::Open
    }

    /// Begins the motion that has waited, where the joint stands now.
    fn end_test(&mut self) {
        self.end_transition();
        let place = self.follower.seen.position;
        let Some(control_loop) = &mut self.control_loop else { return };
        control_loop.begin_at(place);
        control_loop.watch_anew();
        if leads_out(&control_loop.course, place, control_loop.watch.range()) {
            self.fault(Fault::PositionLimit);
        }
    }

    /// Ends a transition by a fault, and keeps whether it was a running test.
    pub(super) fn fail_transition(&mut self) {
        self.has_failed_test = self.is_testing() && !self.wake_up.is_on();
        self.end_transition();
    }
}
