//! The servo: the state machine around the control loop, which says when the joint may be driven.
//!
//! ```text
//!             valid parameters       arm            stop
//!   Boot -------------------> Stopped ----> Armed ---------> Stopped
//!     |                          |            |
//!     +--------------------------+------------+- any fault -> Faulted -- clear -> Stopped
//! ```
//!
//! The joint is driven only while the state is [`State::Armed`]. A fault that is seen in a tick
//! turns that tick's output off. The first fault is latched with its time and the value that
//! tripped it; later ones do not hide it. A microcontroller that comes out of a reset with a fault
//! ([`Boot`]) reports it and stays faulted: no unrequested reset leads to a motion. Further resets
//! report it again until a command clears it.
//!
//! To be armed, the servo has to be stopped, with a fault cleared if there was one. After a stall,
//! a jump or a reversal the encoder has to [prove itself](crate::safety::encoder_proof). A joint
//! with a range of positions has to be [referenced](Servo::set_reference); for a jog both need not
//! be, and for a homing the reference need not. The joint has to be at rest for 50 ms, and supply, position and motor must be such that no
//! monitor would trip at once. The position in which the servo is armed becomes the joint's zero. A
//! command arms the servo ([`Servo::arm`]). If the parameters say `autostart` (off by default) and
//! nothing went wrong before, the servo arms itself, `autostart_delay` after the first tick. The
//! motion of the parameters begins with the tick after that.
//!
//! A stop and a silent link brake a joint that moves before the output is off
//! (`servo/stopping.rs`). Every other fault lets it coast.
//!
//! After arming, the limit of the output rises in a straight line from zero to the full scale (soft
//! start): a wrong sign or a large first error shows as a slow pull and not as a jerk. The loop has
//! its own gains from the start; what the limit cuts off is reported as `saturated`.
//!
//! If the bridge's driver takes time to wake up (`wake_up_s`), it is enabled for that time before
//! the first tick of the loop, in the state [`State::Armed`] (`servo/wake_up.rs`).
//!
//! A ramp that identifies the friction is its own soft start, and no faster than the one that is
//! configured. While it runs, the servo obeys nothing but a stop. The ramp stops the servo by
//! itself when it is over. If the supply is too low for its effort, it is over at once, without a
//! level. A [jog](crate::motion::jog) and a [homing](crate::motion::home) are obeyed and ended
//! likewise.

mod arming;
mod boot;
mod control_loop;
mod faults;
mod follower;
mod homing;
mod identification;
mod jog;
mod moves;
mod output;
mod ramp;
mod referenced;
mod refusal;
mod stopping;
mod wake_up;

use crate::control::controller::{Controller, Reading};
use crate::control::signal::Tick;
use crate::motion::{Course, CourseState};
use crate::safety::encoder_proof::EncoderProof;
use crate::safety::fault::{Fault, FaultLog, LatchedFault};
use crate::safety::monitor::Standstill;
use crate::safety::open_line::OpenLineState;
pub use boot::Boot;
pub use control_loop::ControlLoop;
use follower::Follower;
pub use output::{Input, Output};
pub use ramp::FrictionLevels;
use referenced::Referenced;
pub use refusal::Refusal;
use stopping::Stopping;
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
    /// The output is off until the fault is cleared, or until the next reset.
    Faulted(Fault),
}

/// The state machine around the control loop, which it owns. The board calls [`tick`](Self::tick)
/// once a sample time.
#[derive(Clone, Debug)]
pub struct Servo {
    control_loop: Option<ControlLoop>,
    state: State,
    /// Ticks until the servo arms itself; none: it does not.
    countdown: Option<u32>,
    /// Ticks since power-on. Wraps, after five days at 10 kHz.
    clock: u32,
    follower: Follower,
    wake_up: WakeUp,
    encoder_proof: EncoderProof,
    open_line: OpenLineState,
    /// Velocity of the last tick with output, deg/s.
    velocity: f32,
    stopping: Option<Stopping>,
    referenced: Referenced,
    /// The joint's zero, counts since power-on.
    origin: i32,
    latched: Option<LatchedFault>,
    log: FaultLog,
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

    /// Takes the position of the motor for the next tick, counts of its own encoder since power-on,
    /// of a joint that has an encoder on the load as well. The counter of [`Input`] is the load's
    /// then.
    #[cfg(feature = "two-encoders")]
    pub fn see_motor(&mut self, counts: i32) {
        self.follower.see_motor(counts);
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.motor_counts = counts;
        }
    }

    /// Returns whether the joint is at rest.
    pub fn is_at_rest(&self) -> bool {
        self.control_loop
            .as_ref()
            .is_some_and(|control_loop| control_loop.monitors.is_at_rest(&self.follower.seen))
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

    /// Returns whether the law has ended its attempts to reach the set point: something is in the
    /// way. A new motion tries again.
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

    /// Returns whether the encoder is in doubt, so that only a jog may drive the joint; see
    /// [`encoder_proof`](crate::safety::encoder_proof).
    pub const fn is_encoder_in_doubt(&self) -> bool {
        self.encoder_proof.is_due()
    }

    /// Returns the steady effort that would heat the motor as much as it is heated, V.
    pub fn thermal_effort(&self) -> f32 {
        self.control_loop
            .as_ref()
            .map_or(0.0, |control_loop| control_loop.watch.effort(&control_loop.monitors))
    }

    /// Takes a control loop that was made of other parameters. That ends a fault of the parameters
    /// before them.
    ///
    /// # Errors
    /// Refuses while the servo is armed.
    pub fn install(&mut self, control_loop: &mut Option<ControlLoop>) -> Result<(), Refusal> {
        if matches!(self.state, State::Armed) {
            return Err(Refusal::Armed);
        }
        let Some(after) = control_loop else { return Ok(()) };
        if let Some(before) = &self.control_loop {
            // A motor that is warm stays warm. Otherwise, a set of parameters would be the way
            // around the thermal model.
            after.watch = after.monitors.taken_over(&before.watch, &before.monitors);
            if after.controller.encoder() != before.controller.encoder() {
                self.referenced = Referenced::No;
            }
        }
        // Not `take`, which would put a third kilobyte on the stack.
        core::mem::swap(&mut self.control_loop, control_loop);
        // The ticks so far may have been of another length.
        self.wake_up.forget();
        self.open_line = OpenLineState::default();
        self.countdown = None;
        self.unsettle();
        if let State::Faulted(fault) = self.state
            && fault.ends_with_parameters()
        {
            self.state = State::Stopped;
            self.latched = None;
        }
        Ok(())
    }

    /// Forgets whether the joint is at rest, since ticks have been missed. The joint has to rest
    /// anew before the servo is armed.
    pub fn unsettle(&mut self) {
        self.follower.standstill = Standstill::default();
        self.follower.seen.standstill = 0;
        #[cfg(feature = "two-encoders")]
        {
            self.follower.motor = None;
        }
    }

    /// Returns whether the motor is driven for a link, whose silence is watched.
    pub fn is_driven_for_a_link(&self) -> bool {
        let watched = |control_loop: &ControlLoop| control_loop.watch.is_watched();
        self.state == State::Armed && self.control_loop.as_ref().is_some_and(watched)
    }

    /// Takes a sign of life of the link.
    pub fn heard(&mut self) {
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.heard();
        }
    }

    /// Runs one tick, and returns what the board has to do. The board calls it once a sample time.
    // Not inlined: the compiler would take the output apart where it is used, and copy the tick
    // byte by byte. That costs as much as the whole rest of the interrupt.
    #[inline(never)]
    pub fn tick(&mut self, input: Input) -> Output {
        self.clock = self.clock.wrapping_add(1);
        let mut open_lines = 0;
        if let Some(control_loop) = &self.control_loop {
            self.follower.update(control_loop.controller.encoder(), input);
            let standstill = self.follower.seen.standstill;
            open_lines =
                control_loop.open_line.update(&mut self.open_line, input.lines, standstill);
        }
        self.advance();
        if open_lines > 0 {
            self.latch_open(open_lines);
        }
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            if let Some(control_loop) = &mut self.control_loop {
                let seen = &self.follower.seen;
                control_loop.monitors.idle(&mut control_loop.watch, seen);
                if self.open_line.is_running() {
                    // What two open lines count in a test, no hand has moved.
                    self.encoder_proof = self.encoder_proof.after_drive();
                } else {
                    let is_at_rest = control_loop.monitors.is_at_rest(seen);
                    self.encoder_proof.update(seen.position, is_at_rest);
                }
            }
            self.wake_up.rest();
            return self.stopped();
        };
        if self.wake_up.is_on() {
            return self.wake(input.supply);
        }
        let seen = &self.follower.seen;
        let tick = control_loop.tick(seen.position, input.supply);
        if tick.non_finite {
            self.fault(Fault::NonFinite);
            return self.off(tick);
        }
        if let Some(trip) =
            control_loop.monitors.check(&mut control_loop.watch, seen, &tick, input.supply)
        {
            let latched = LatchedFault { fault: trip.fault, tick: self.clock, value: trip.value };
            let brakes = trip.fault == Fault::LinkTimeout && self.begin_stop(Some(latched));
            if !brakes {
                self.latch(latched);
                return self.off(tick);
            }
        }
        self.velocity = tick.velocity;
        if self.is_stopping() {
            self.go_on_stopping();
            if self.state != State::Armed {
                return self.off(tick);
            }
        }
        let Some(control_loop) = &mut self.control_loop else { return self.off(tick) };
        if control_loop.ends(&tick) {
            self.end_course();
            return self.off(tick);
        }
        let wound_up = control_loop.watch.warning();
        self.output(tick, true, wound_up)
    }

    /// Makes the transitions that need no command.
    fn advance(&mut self) {
        match (self.state, self.countdown) {
            (State::Boot, _) => self.state = State::Stopped,
            (State::Stopped, Some(ticks)) => self.countdown = Some(ticks.saturating_sub(1)),
            _ => {}
        }
    }
}

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
