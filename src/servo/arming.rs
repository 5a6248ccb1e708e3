//! Arming, by a command or automatically, and turning the output off again.

use super::control_loop::{leads_out, leads_too_far};
use super::current_path::CurrentPath;
use super::{BrakeCommand, ControlLoop, Follower, Output, Refusal, Servo, State};
use crate::control::signal::Tick;
use crate::identification::Ramp;
use crate::motion::Course;
use crate::safety::encoder_proof::EncoderProofs;
use crate::safety::fault::Fault;

impl Servo {
    /// Arms the servo: the motion of the parameters begins at the next tick. If the servo is armed
    /// already, nothing happens.
    ///
    /// # Errors
    /// Returns the reason for the refusal.
    pub fn arm(&mut self) -> Result<(), Refusal> {
        if self.is_stopping() {
            return Err(Refusal::Stopping);
        }
        if let State::Armed = self.state {
            return Ok(());
        }
        let (here, origin) = (self.follower.seen.position, self.known_origin());
        let control_loop = self.ready_to_close()?;
        if control_loop.monitors.is_friction_unknown() {
            return Err(Refusal::FrictionUnknown);
        }
        if control_loop.replaced {
            return Err(Refusal::Replaced);
        }
        if leads_out(&control_loop.course, here, control_loop.monitors.range(origin)) {
            return Err(Refusal::OutOfRange);
        }
        // Arming makes the place of the joint zero.
        if leads_too_far(&control_loop.course, 0) {
            return Err(Refusal::TooFar);
        }
        if control_loop.begins_far_from(&control_loop.course, 0) {
            return Err(Refusal::FarAway);
        }
        self.start_loop(false);
        Ok(())
    }

    /// Arms the servo for a link. At the next tick the ramp begins; without a ramp, the joint holds
    /// its place. From then on, the silence of that link is a fault. If the servo is already armed,
    /// only the watch over the link begins, and a ramp is refused. While a ramp, a jog, an
    /// identification or a homing runs, the call is refused.
    ///
    /// # Errors
    /// Returns the reason for the refusal.
    pub fn arm_for_link(&mut self, ramp: Option<Ramp>) -> Result<(), Refusal> {
        if self.is_stopping() {
            return Err(Refusal::Stopping);
        }
        if self.is_testing() {
            return Err(Refusal::Testing);
        }
        if let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) {
            // The loop of a ramp and of a jog is open, and must not be reported as closed. A homing
            // is not at the place that a client moves to.
            if ramp.is_some() || control_loop.ends_by_itself() {
                return Err(Refusal::Armed);
            }
            control_loop.watch.listen();
            return Ok(());
        }
        let control_loop = self.ready_to_close()?;
        if ramp.is_none() && control_loop.monitors.is_friction_unknown() {
            return Err(Refusal::FrictionUnknown);
        }
        control_loop.begin(ramp.map_or_else(Course::default, Course::Ramp));
        self.start_loop(true);
        Ok(())
    }

    /// Returns the control loop if it can be armed, the encoder is not in doubt, and a joint with a
    /// range of positions is referenced.
    pub(super) fn ready_to_close(&mut self) -> Result<&mut ControlLoop, Refusal> {
        let (is_in_doubt, is_referenced) = (self.is_encoder_in_doubt(), self.is_referenced());
        let control_loop = self.ready_to_arm()?;
        if is_in_doubt {
            return Err(Refusal::EncoderInDoubt);
        }
        if control_loop.monitors.has_range() && !is_referenced {
            return Err(Refusal::NotReferenced);
        }
        Ok(control_loop)
    }

    /// Returns the control loop if it can be armed: the servo is stopped, the joint is at rest, the
    /// test for open lines has passed, and no monitor would trip at once.
    pub(super) fn ready_to_arm(&mut self) -> Result<&mut ControlLoop, Refusal> {
        match self.state {
            State::Boot => return Err(Refusal::Booting),
            State::Faulted(fault) => return Err(Refusal::Faulted(fault)),
            State::Armed => return Err(Refusal::Armed),
            State::Stopped => {}
        }
        if let Some(fault) = self.motor_temperature.forbids_arming() {
            return Err(Refusal::WouldTrip(fault));
        }
        let origin = self.known_origin();
        #[cfg(feature = "two-encoders")]
        if self.follower.missing > 0 {
            return Err(Refusal::WouldTrip(Fault::EncoderSilent));
        }
        let (Some(control_loop), Follower { encoder: Some(_), seen, supply, .. }) =
            (&mut self.control_loop, self.follower)
        else {
            return Err(Refusal::Booting);
        };
        // A test for open lines is over before the joint is at rest, or a few long ticks later.
        let is_due = control_loop.open_line.is_due(&self.open_line);
        #[cfg(feature = "two-encoders")]
        let is_due = is_due
            || control_loop.load_line.as_ref().is_some_and(|test| test.is_due(&self.load_line));
        if !control_loop.monitors.is_at_rest(&seen) || is_due {
            return Err(Refusal::Moving);
        }
        if !control_loop.knows_offset() {
            return Err(Refusal::Moving);
        }
        let ControlLoop { monitors, watch, current, .. } = &*control_loop;
        if current.as_ref().is_some_and(CurrentPath::is_off) {
            return Err(Refusal::WouldTrip(Fault::CurrentSensor));
        }
        match monitors.forbids_arming(watch, monitors.range(origin), &seen, supply) {
            Some(fault) => Err(Refusal::WouldTrip(fault)),
            None => Ok(control_loop),
        }
    }

    /// Arms the servo: the prepared course begins where the joint is now, after the driver's
    /// wake-up.
    pub(super) fn start_loop(&mut self, by_link: bool) {
        let origin = self.known_origin();
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.arm(self.follower.seen.position, by_link, origin);
            self.wake_up.begin(&control_loop.driver_times);
            self.state = State::Armed;
            self.velocity = 0.0;
            self.countdown = None;
            self.begin_test();
            self.begin_opening();
        }
    }

    /// Turns the output off, also in a short brake. A fault stays latched.
    #[inline(never)]
    pub fn stop(&mut self) {
        self.countdown = None;
        self.end_transition();
        if matches!(self.state, State::Armed) {
            self.state = State::Stopped;
            self.encoder_proof = self.encoder_proof.after_drive();
            if let Some(control_loop) = &mut self.control_loop {
                control_loop.rest();
            }
        }
    }

    /// Turns the output off at the end of a course that ends automatically, or closes the holding
    /// brake first if the loop is closed. A homing that found its stop sets the reference; a jog in
    /// which all encoders agree proves them.
    // Not in the tick, which it would make longer.
    #[inline(never)]
    pub(super) fn end_course(&mut self, tick: Tick) -> Output {
        self.take_home();
        let proves = self.jogged().is_some_and(|found| found.agrees());
        if !self.begin_closing(None) {
            self.stop();
        }
        if proves {
            self.encoder_proof = EncoderProofs::default();
        }
        self.held(tick, BrakeCommand::Open)
    }

    /// Runs a tick with the output off. If autostart is due, arms the servo for the next tick.
    // Arming and a tick of the loop in one interrupt would be the longest of all.
    #[inline(never)]
    pub(super) fn stopped(&mut self) -> Output {
        let output = self.off(Tick::default());
        if let (State::Stopped, Some(0)) = (self.state, self.countdown) {
            match self.arm() {
                // It would never arm, and never report why.
                Err(Refusal::FarAway) => self.fault(Fault::FollowingError),
                Err(Refusal::OutOfRange) => self.fault(Fault::PositionLimit),
                Err(Refusal::WouldTrip(Fault::CurrentSensor)) => self.fault(Fault::CurrentSensor),
                // A command that sets the reference must not start the joint.
                Err(Refusal::NotReferenced) => self.countdown = None,
                // If the joint is not at rest yet, or the supply is not up, the next tick tries
                // again.
                _ => {}
            }
        }
        output
    }
}
