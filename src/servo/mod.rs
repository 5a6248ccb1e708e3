//! The servo: the state machine around the control loop. It decides when the joint may be driven.
//!
//! ```text
//!             valid parameters       arm            stop
//!   Boot -------------------> Stopped ----> Armed ---------> Stopped
//!     |                          |            |
//!     +--------------------------+------------+- any fault -> Faulted -- clear -> Stopped
//! ```
//!
//! The joint is driven only while the state is [`State::Armed`]. A fault detected in a tick turns
//! that tick's output off. The first fault is latched with its time and the value that tripped it;
//! later faults do not replace it. A microcontroller that comes out of a reset with a fault
//! ([`Boot`]) reports the fault and stays faulted: an unrequested reset causes no motion. Further
//! resets report the fault again until a command clears it.
//!
//! Arming requires a stopped servo without a latched fault. After a stall, a jump, a reversal or
//! another fault that puts the encoder in doubt, the encoder needs a
//! [proof](crate::safety::encoder_proof). A joint with a range of positions has to be
//! [referenced](Servo::set_reference). A jog requires neither the proof nor the reference; a homing
//! requires only the proof. The joint has to be at rest for 50 ms, and supply, position and heat of
//! the motor have to be within their limits, so that no monitor would trip at once. The position at
//! arming becomes the zero of the motion. A command arms the servo ([`Servo::arm`]). If the
//! parameters enable `autostart` (off by default) and neither the boot nor a fault forbids it, the
//! servo arms automatically, `autostart_delay` after the first tick. The motion of the parameters
//! begins with the tick after that.
//!
//! After a stop command or a silent link, the loop brakes a moving joint before the output goes off
//! (`servo/stopping.rs`). After any other fault the joint coasts, or its winding brakes it for a
//! configured time ([`Fault::reaction`], `servo/short_brake.rs`). The contact of an emergency stop
//! ends the output in hardware, and is reported here (`servo/emergency_stop.rs`).
//!
//! A configured test at arming comes before the motion (`servo/arming_test.rs`).
//!
//! A holding brake opens before the motion starts, and closes before the output goes off
//! (`servo/holding_brake.rs`).
//!
//! After arming, the limit of the output rises in a straight line from zero to the full scale (soft
//! start): a wrong sign or a large first error shows as a slow pull and not as a jerk. The gains
//! are unchanged meanwhile. A tick whose effort the limit cuts is reported as `saturated`.
//!
//! If the bridge's driver takes time to wake up (`wake_up_s`), it is enabled for that time before
//! the first tick of the loop, in the state [`State::Armed`] (`servo/wake_up.rs`).
//!
//! The effort of a ramp, which identifies the friction, rises no faster than the configured soft
//! start. While the ramp runs, the servo accepts only a stop. When the ramp is over, the servo
//! stops automatically. If the supply is too low for the effort, the ramp ends at once and finds no
//! level. A [jog](crate::motion::jog), a [homing](crate::motion::home) and a
//! [measurement of the winding](crate::motion::winding) also accept only a stop and end
//! automatically.

#[cfg(feature = "two-encoders")]
mod absolute_load;
mod arming;
mod arming_test;
mod boot;
mod control_loop;
mod current_path;
mod emergency_stop;
mod encoder_index;
mod faults;
mod follower;
mod holding_brake;
mod homing;
mod identification;
mod jog;
mod motor_temperature;
mod moves;
mod output;
mod ramp;
mod referenced;
mod refusal;
mod short_brake;
mod stopping;
mod wake_up;
mod winding;

use crate::control::controller::{Controller, Reading};
use crate::control::signal::Tick;
use crate::motion::{Course, CourseState};
use crate::safety::encoder_index::IndexState;
use crate::safety::encoder_proof::EncoderProofs;
use crate::safety::fault::{Fault, FaultLog, LatchedFault};
use crate::safety::motor_temperature::MotorTemperatureState;
use crate::safety::open_line::OpenLineState;
pub use boot::Boot;
pub use control_loop::ControlLoop;
use follower::Follower;
#[cfg(feature = "two-encoders")]
pub use output::EncoderReading;
pub use output::{BrakeCommand, Input, Output};
pub use ramp::FrictionLevels;
use referenced::Referenced;
pub use refusal::Refusal;
use stopping::Transition;
use wake_up::WakeUp;

/// The state of a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The servo has not had its first tick.
    Boot,
    /// The output is off; the servo may be armed.
    Stopped,
    /// The output is on: the loop is closed, or runs open for a ramp or a jog.
    Armed,
    /// The output is off until the fault is cleared, or until the next reset; in a short brake it
    /// is at zero volts before (`servo/short_brake.rs`).
    Faulted(Fault),
}

/// The state machine that owns the control loop. The board calls [`tick`](Self::tick) once a sample
/// time.
#[derive(Clone, Debug)]
pub struct Servo {
    control_loop: Option<ControlLoop>,
    state: State,
    /// Ticks until the servo arms automatically; none if it does not.
    countdown: Option<u32>,
    /// Ticks since power-on. The number wraps after five days at 10 kHz.
    clock: u32,
    follower: Follower,
    wake_up: WakeUp,
    encoder_proof: EncoderProofs,
    open_line: OpenLineState,
    #[cfg(feature = "two-encoders")]
    load_line: OpenLineState,
    /// Check of the counts by the encoder's index.
    index: IndexState,
    /// Velocity of the last tick with output, deg/s.
    velocity: f32,
    transition: Option<Transition>,
    /// Whether the contact of the emergency stop was open in the last tick with the output off.
    is_contact_open: bool,
    /// Whether the contact has been open while another fault was latched.
    is_stop_behind: bool,
    motor_temperature: MotorTemperatureState,
    referenced: Referenced,
    /// The joint's zero, counts since power-on.
    origin: i32,
    latched: Option<LatchedFault>,
    log: FaultLog,
    /// Whether the latched fault came during a test at arming.
    has_failed_test: bool,
    /// Motion that starts once the holding brake is open or the test at arming has passed; without
    /// effect otherwise.
    pending: Course,
}

impl Servo {
    /// Returns the present state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Returns the number of ticks since power-on.
    pub const fn clock(&self) -> u32 {
        self.clock
    }

    /// Returns the position, counts: from the place of power-on, or from the zero that a
    /// [reference](Self::set_reference) has set.
    pub const fn position(&self) -> i32 {
        self.follower.seen.position.wrapping_sub(self.origin)
    }

    /// Returns whether the joint is at rest. A load whose encoder does not answer is not known to
    /// be. A stopped joint with a sensor of its current is at rest once the sensor's offset is
    /// known.
    pub fn is_at_rest(&self) -> bool {
        #[cfg(feature = "two-encoders")]
        if self.follower.missing > 0 {
            return false;
        }
        self.control_loop.as_ref().is_some_and(|control_loop| {
            control_loop.monitors.is_at_rest(&self.follower.seen)
                && (self.state == State::Armed || control_loop.knows_offset())
        })
    }

    /// Returns whether the compensator holds effort at standstill, which the motor turns into heat.
    pub fn is_wound_up(&self) -> bool {
        self.control_loop.as_ref().is_some_and(|control_loop| control_loop.watch.warning())
    }

    /// Returns whether the joint swings to and fro around a set point that rests.
    pub fn is_oscillating(&self) -> bool {
        let oscillates =
            |control_loop: &ControlLoop| control_loop.watch.oscillates(&control_loop.monitors);
        self.state == State::Armed && self.control_loop.as_ref().is_some_and(oscillates)
    }

    /// Returns whether the law has ended its attempts to reach the set point because something
    /// blocks the joint. With a new motion, the law tries again.
    pub fn has_given_up(&self) -> bool {
        let given_up = |control_loop: &ControlLoop| {
            control_loop.controller.has_given_up(control_loop.state.controller())
        };
        self.state == State::Armed && self.control_loop.as_ref().is_some_and(given_up)
    }

    /// Returns whether the resistors of the encoder's input pull down until the next tick, for the
    /// [test for open lines](crate::safety::open_line). They pull up otherwise.
    #[inline]
    pub const fn pulls_down(&self) -> bool {
        self.open_line.pulls_down()
    }

    /// Returns the same as [`pulls_down`](Self::pulls_down) for the load's encoder, if there are
    /// two.
    #[cfg(feature = "two-encoders")]
    #[inline]
    pub const fn pulls_load_down(&self) -> bool {
        self.load_line.pulls_down()
    }

    /// Returns whether the encoder is in doubt, so that only a jog may drive the joint; see
    /// [`encoder_proof`](crate::safety::encoder_proof).
    pub const fn is_encoder_in_doubt(&self) -> bool {
        self.encoder_proof.is_due()
    }

    /// Returns the heat of the motor, as the steady effort that would cause it, V.
    pub fn thermal_effort(&self) -> f32 {
        self.control_loop
            .as_ref()
            .map_or(0.0, |control_loop| control_loop.watch.effort(&control_loop.monitors))
    }

    /// Replaces the control loop by one that was made from other parameters. The old loop is left
    /// in `control_loop`. A fault of missing or invalid parameters ends.
    ///
    /// # Errors
    /// Refuses while the servo is armed.
    pub fn install(&mut self, control_loop: &mut Option<ControlLoop>) -> Result<(), Refusal> {
        if matches!(self.state, State::Armed) {
            return Err(Refusal::Armed);
        }
        let Some(after) = control_loop else { return Ok(()) };
        if let Some(before) = &self.control_loop {
            // A warm motor stays warm. Otherwise, new parameters would bypass the thermal model.
            after.watch = after.monitors.taken_over(&before.watch, &before.monitors);
            #[cfg(feature = "two-encoders")]
            let (measures_another, has_other_angle) =
                (self.follower.change(before, after), before.angle() != after.angle());
            #[cfg(not(feature = "two-encoders"))]
            let (measures_another, has_other_angle) = (false, false);
            // A proof is that of a counter, which measures another side from now on.
            if measures_another && self.encoder_proof.is_due() {
                self.encoder_proof = EncoderProofs::IN_DOUBT;
            }
            let has_other_encoder = after.controller.encoder() != before.controller.encoder();
            if measures_another || has_other_angle || has_other_encoder {
                self.referenced = Referenced::No;
            }
        }
        self.index = IndexState::default();
        // Not `take`, which would put a third kilobyte on the stack.
        core::mem::swap(&mut self.control_loop, control_loop);
        // The ticks so far may have been of another length.
        self.wake_up.forget();
        self.end_transition();
        self.retest_lines();
        self.forget_temperature();
        self.countdown = None;
        self.unsettle();
        if let State::Faulted(fault) = self.state
            && fault.ends_with_parameters()
        {
            self.end_fault();
        }
        Ok(())
    }

    /// Restarts the count of ticks at standstill, for example after missed ticks. The joint has to
    /// come to rest anew before the servo can be armed.
    pub fn unsettle(&mut self) {
        self.follower.unsettle();
    }

    /// Restarts the test for open lines: the next arming waits for it.
    fn retest_lines(&mut self) {
        self.open_line = OpenLineState::default();
        #[cfg(feature = "two-encoders")]
        {
            self.load_line = OpenLineState::default();
        }
    }

    /// Returns whether a test for open lines runs.
    const fn tests_lines(&self) -> bool {
        #[cfg(feature = "two-encoders")]
        if self.load_line.is_running() {
            return true;
        }
        self.open_line.is_running()
    }

    /// Returns whether the servo is armed and the silence of a link would be a fault.
    pub fn is_driven_for_a_link(&self) -> bool {
        let watched = |control_loop: &ControlLoop| control_loop.watch.is_watched();
        self.state == State::Armed && self.control_loop.as_ref().is_some_and(watched)
    }

    /// Restarts the time of the link's silence, after a sign of life of the link.
    pub fn heard(&mut self) {
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.heard();
        }
    }

    /// Runs one tick, and returns the output for the board. The board calls this once a sample
    /// time.
    // Not inlined: the compiler would take the output apart where it is used, and copy the tick
    // byte by byte. That costs as much as the whole rest of the interrupt.
    #[inline(never)]
    pub fn tick(&mut self, input: Input) -> Output {
        self.clock = self.clock.wrapping_add(1);
        let mut open_lines = 0;
        if let Some(control_loop) = &self.control_loop {
            self.follower.update(&control_loop.controller, input);
            let standstill = self.follower.seen.driven().standstill;
            open_lines =
                control_loop.open_line.update(&mut self.open_line, input.lines, standstill);
            #[cfg(feature = "two-encoders")]
            if let Some(test) = &control_loop.load_line {
                let Input { load: EncoderReading { lines, .. }, .. } = input;
                let standstill = self.follower.seen.standstill;
                open_lines |= test.update(&mut self.load_line, lines, standstill) << LOAD_LINES;
            }
            open_lines |= control_loop.contact & !input.lines;
        }
        self.advance();
        #[cfg(feature = "two-encoders")]
        if self.has_absolute_load() {
            self.check_absolute_load();
        }
        if open_lines > 0 {
            self.latch_open(open_lines);
        }
        let is_testing_lines = self.tests_lines();
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            self.is_contact_open = open_lines & Input::CONTACT != 0;
            if self.transition.is_some() {
                return self.brake_short(input);
            }
            if let Some(control_loop) = &mut self.control_loop {
                let seen = &self.follower.seen;
                control_loop.monitors.idle(&mut control_loop.watch, seen);
                if let Some(path) = &mut control_loop.current {
                    path.idle(input.current, control_loop.monitors.is_at_rest(seen));
                }
                if is_testing_lines {
                    // Two open lines count during a test without a motion: these counts are no
                    // proof.
                    self.encoder_proof = self.encoder_proof.after_drive();
                } else {
                    let is_at_rest = control_loop.monitors.is_at_rest(seen);
                    self.encoder_proof.update(seen, is_at_rest);
                }
            }
            self.wake_up.rest();
            return self.stopped();
        };
        if self.wake_up.is_on() {
            return self.wake(input.supply);
        }
        let seen = &self.follower.seen;
        let trip = match control_loop.current {
            None => None,
            Some(_) => control_loop.measure(seen, input.current, self.velocity),
        };
        let tick = control_loop.tick(seen, input.supply);
        if let Some((fault, value)) = trip {
            self.latch(LatchedFault { fault, tick: self.clock, value });
            return self.tripped(&tick);
        }
        if tick.non_finite {
            self.fault(Fault::NonFinite);
            return self.tripped(&tick);
        }
        if let Some(trip) =
            control_loop.monitors.check(&mut control_loop.watch, seen, &tick, input.supply)
        {
            let latched = LatchedFault { fault: trip.fault, tick: self.clock, value: trip.value };
            let brakes = trip.fault == Fault::LinkTimeout && self.begin_to_rest(Some(latched));
            if !brakes {
                self.latch(latched);
                return self.tripped(&tick);
            }
        }
        self.velocity = tick.velocity;
        if self.transition.is_some() {
            return self.go_on(tick);
        }
        let Some(control_loop) = &mut self.control_loop else { return self.off(tick) };
        if control_loop.ends(&tick, input.lines) {
            return self.end_course(tick);
        }
        let wound_up = control_loop.watch.warning();
        self.output(tick, true, wound_up)
    }

    /// Advances the state after the first tick, and counts the autostart delay down by a tick.
    fn advance(&mut self) {
        match (self.state, self.countdown) {
            (State::Boot, _) => self.state = State::Stopped,
            (State::Stopped, Some(ticks)) => self.countdown = Some(ticks.saturating_sub(1)),
            _ => {}
        }
    }
}

/// Place of the first line of the load's encoder among the open lines of a fault.
#[cfg(feature = "two-encoders")]
const LOAD_LINES: u8 = 2;

/// Runs the core's tick as a function of its own, so that `cargo xtask cost` can count its
/// instructions in the flash image. The call costs a dozen of them.
#[inline(never)]
fn control(
    course: &mut Course,
    controller: &Controller,
    state: &mut CourseState,
    reading: Reading,
) -> Tick {
    course.tick(controller, state, reading)
}

#[cfg(test)]
mod tests;
