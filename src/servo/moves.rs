//! Moves while the servo is armed: another reference, a profile to a position, and a hold.

use super::control_loop::{is_too_far, leads_out, leads_too_far};
use super::{ControlLoop, Refusal, Servo, State};
use crate::control::profile::Profile;
use crate::control::reference::{Reference, Step};
use crate::motion::Course;
use crate::units::position::Position;

impl Servo {
    /// Replaces the reference that the joint follows, from the next tick on. Its positions count
    /// from the zero of arming. The loop keeps running. From then on, the silence of the requesting
    /// link is a fault.
    ///
    /// # Errors
    /// Refuses unless the servo is armed, and the reference stays within the range of positions and
    /// less than 2^30 counts from the joint. A trajectory or a sine has to begin near the joint:
    /// within the limit of the following error, and within the error at which the law reaches the
    /// full scale. Otherwise its first point would be a jump. A step may begin with a jump.
    pub fn follow(&mut self, reference: Reference) -> Result<(), Refusal> {
        let control_loop = self.armed_loop()?;
        let course = Course::Follow(reference);
        if leads_out(&course, control_loop.zero, control_loop.watch.range()) {
            return Err(Refusal::OutOfRange);
        }
        if leads_too_far(&course, control_loop.state.counts()) {
            return Err(Refusal::TooFar);
        }
        if control_loop.begins_far_from(&course, control_loop.state.counts()) {
            return Err(Refusal::FarAway);
        }
        control_loop.begin(course);
        self.postpone();
        Ok(())
    }

    /// Moves the set point to the target of a profile, from its present position and velocity. A
    /// running profile continues to the new target. A set point at rest starts after the soft
    /// start, since the limits of a profile assume the full output. From then on, the silence of
    /// the requesting link is a fault.
    ///
    /// # Errors
    /// Refuses unless the servo is armed, and the target is within the range of positions and less
    /// than 2^30 counts from the set point. A moving set point has to be slow enough to come to
    /// rest within the range with the acceleration of the profile. A refused call changes nothing.
    pub fn go_to(&mut self, profile: Profile) -> Result<(), Refusal> {
        let control_loop = self.armed_loop()?;
        let target = profile.target();
        if control_loop.is_out_of_range(target) {
            return Err(Refusal::OutOfRange);
        }
        let from = control_loop.setpoint().position;
        if is_too_far(target, from.counts) {
            return Err(Refusal::TooFar);
        }
        control_loop.begin_profile(profile)?;
        self.postpone();
        Ok(())
    }

    /// Stops the joint and holds it. A moving profile slows down within its limits and rests on the
    /// first count that they allow. Otherwise the set point becomes the present position of the
    /// joint. From then on, the silence of the requesting link is a fault.
    ///
    /// # Errors
    /// Refuses unless the servo is armed.
    pub fn hold(&mut self) -> Result<(), Refusal> {
        let control_loop = self.armed_loop()?;
        if !control_loop.stops_profile() {
            let here = Position::from_counts(control_loop.state.counts());
            let step = Step { from: here, to: here, at_tick: 0 };
            control_loop.begin(Course::Follow(Reference::Step(step)));
        }
        self.postpone();
        Ok(())
    }

    fn armed_loop(&mut self) -> Result<&mut ControlLoop, Refusal> {
        if self.is_stopping() {
            return Err(Refusal::Stopping);
        }
        if self.is_testing() {
            return Err(Refusal::Testing);
        }
        match (self.state, &mut self.control_loop) {
            // A ramp and a jog measure the response to their own effort alone, and a homing ends
            // with a reference that no move may shift.
            (State::Armed, Some(control_loop)) if control_loop.ends_by_itself() => {
                Err(Refusal::Armed)
            }
            (State::Armed, Some(control_loop)) => Ok(control_loop),
            (State::Faulted(fault), _) => Err(Refusal::Faulted(fault)),
            _ => Err(Refusal::NotArmed),
        }
    }
}
