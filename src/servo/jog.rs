//! The servo's part of a [jog](crate::motion::jog): arming, and the findings.

use super::{ControlLoop, Refusal, Servo, State};
use crate::motion::Course;
use crate::motion::jog::{Jog, JogFindings};

impl Servo {
    /// Arms the servo for a link: at the next tick a jog begins. The monitors that require a known
    /// direction of the encoder, or ratio of two, are off until the servo is armed anew. From now
    /// on, the silence of that link is a fault.
    ///
    /// # Errors
    /// Returns the reason for the refusal; an armed servo refuses a jog.
    pub fn jog(&mut self, jog: Jog) -> Result<(), Refusal> {
        self.ready_to_arm()?.begin(Course::Jog(jog));
        self.start_loop(true);
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.suppose_wiring();
        }
        Ok(())
    }

    /// Returns whether the servo is armed for a jog.
    pub fn is_jogging(&self) -> bool {
        let jogs = |control_loop: &ControlLoop| matches!(control_loop.course, Course::Jog(_));
        let is_on = self.state == State::Armed && !self.is_testing();
        is_on && self.control_loop.as_ref().is_some_and(jogs)
    }

    /// Returns the findings of a jog that is over; none if a stop or a fault ended it.
    pub fn jogged(&self) -> Option<JogFindings> {
        let ControlLoop { course: Course::Jog(_), state, .. } = self.control_loop.as_ref()? else {
            return None;
        };
        // The jog of a test at arming has no client.
        (state.jog().is_over() && !self.is_testing()).then(|| *state.jog().found())
    }
}
