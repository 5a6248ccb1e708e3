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
//! tripped it; later ones do not hide it. A part that comes out of a reset with a fault to tell
//! ([`Boot`]) tells it and stays faulted: no reset that nobody asked for leads to a motion. The
//! reset after that one starts clean.
//!
//! To be armed, the servo has to be stopped, with a fault cleared if there was one. The joint has
//! to be at rest for 50 ms, and supply, position and motor must be such that no monitor would trip
//! at once. The position in which the servo is armed becomes the joint's zero. A command arms the
//! servo ([`Servo::arm`]). If the parameters say `autostart` (off by default) and nothing went
//! wrong before, the servo arms itself, `autostart_delay` after the first tick. The motion of the
//! parameters begins with the tick after that.
//!
//! After arming, the limit of the output rises in a straight line from zero to the full scale (soft
//! start): a wrong sign or a large first error shows as a slow pull and not as a jerk. The loop has
//! its own gains from the start; what the limit cuts off is told as `saturated`.
//!
//! If the bridge's driver takes time to wake up (`wake_up_s`), it is enabled for so long before the
//! first tick of the loop, in the state [`State::Armed`] (`servo/wake_up.rs`).
//!
//! A ramp that identifies the friction is its own soft start, and no faster than the one that is
//! configured. While it runs, the servo obeys nothing but a stop. The ramp stops the servo by
//! itself when it is over. If the supply is too low for its effort, it is over at once, without a
//! level. A [jog](crate::jog) is obeyed and ended likewise.

mod control_loop;
mod follower;
mod jog;
mod moves;
mod wake_up;

use crate::controller::{Controller, Reading};
use crate::drive::Duty;
use crate::fault::{Fault, FaultLog, Latched};
use crate::hardware::Hardware;
use crate::identification::Ramp;
use crate::monitor::Standstill;
use crate::motion::{Course, CourseState};
use crate::parameters::{DecodeError, Parameters};
use crate::signal::Tick;
pub use control_loop::ControlLoop;
use follower::Follower;
use serde::{Deserialize, Serialize};
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

/// The boot: how the part came out of its last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boot {
    /// The fault that the part comes up with, if any; its time is that of the run in which it
    /// happened.
    pub fault: Option<Latched>,
    /// Whether a slot of the parameters is damaged: the parameters may not be those that were saved
    /// last, so nothing arms by itself.
    pub is_damaged: bool,
    /// Whether the reset may have been a dip of the supply, which nobody can tell from power-on.
    /// Nothing arms by itself then, unless the parameters say so (`autostart_after_dip`).
    pub may_be_dip: bool,
}

/// The reason why the servo does not do what it is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The servo has not had its first tick.
    Booting,
    /// A fault is latched.
    Faulted(Fault),
    /// The fault cannot be cleared by a command.
    NotClearable(Fault),
    /// The servo is armed, and does this only while it is stopped.
    Armed,
    /// The servo is not armed, and does this only while it is.
    NotArmed,
    /// The joint moves, and has to be at rest.
    Moving,
    /// Arming would end in this fault at once.
    WouldTrip(Fault),
    /// The motion leads out of the range of positions.
    OutOfRange,
    /// The trajectory begins too far from the joint.
    FarAway,
    /// The position is 2^30 counts away from the set point, or farther.
    TooFar,
    /// The set point is too fast to come to rest within the range of positions.
    TooFast,
    /// The motion of the parameters has given way to one that a link asked for.
    Replaced,
}

/// The readings that one tick of the servo is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Input {
    /// The reading of the encoder's counter.
    pub counter: u32,
    /// The converter's reading of the supply: for the supply's monitor, and for an output that is
    /// scaled by the supply.
    pub supply: u16,
}

/// The output of one tick of the servo: what it asks of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Whether the bridge may be on. If not, the duty is neutral.
    pub enable: bool,
    /// Whether the bridge's driver is enabled without a duty, so that it wakes up.
    pub wakes: bool,
    /// The servo's state after this tick.
    pub state: State,
    /// Every signal of the tick; code and duty are those that are applied. Without a motion only
    /// duty and status are set, except in the tick that ends a ramp or in which a fault trips.
    pub tick: Tick,
    /// Ticks since power-on, this one included.
    pub clock: u32,
    /// Whether the compensator holds effort at standstill.
    pub wound_up: bool,
}

impl Output {
    /// Returns the PWM setting that the timer is given.
    pub const fn duty(&self) -> Duty {
        self.tick.duty()
    }
}

/// The friction levels that a ramp has found, in volts of effort. A level is none if the joint did
/// not move, or did not rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Levels {
    /// Effort at the first count of the motion, V: the stick level.
    pub stick: Option<f32>,
    /// Effort at the last count before rest, V: the slip level.
    pub slip: Option<f32>,
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
    latched: Option<Latched>,
    log: FaultLog,
}

impl Servo {
    /// Makes a servo of the parameters that were found, or of the reason why there are none.
    pub fn new(
        parameters: Result<&Parameters, DecodeError>,
        boot: Boot,
        hardware: &Hardware,
    ) -> Self {
        let mut servo = Self::blank();
        servo.boot(parameters, boot, hardware);
        servo
    }

    /// Returns a servo without parameters, which [`boot`](Self::boot) gives it.
    pub fn blank() -> Self {
        Self {
            control_loop: None,
            countdown: None,
            state: State::Boot,
            clock: 0,
            follower: Follower::default(),
            wake_up: WakeUp::default(),
            latched: None,
            log: FaultLog::default(),
        }
    }

    /// Does what [`new`](Self::new) does, in the place of a blank servo.
    pub fn boot(
        &mut self,
        parameters: Result<&Parameters, DecodeError>,
        boot: Boot,
        hardware: &Hardware,
    ) {
        let prepared = parameters.and_then(|parameters| {
            ControlLoop::prepare(&mut self.control_loop, parameters, hardware)
                .map_err(DecodeError::Value)
        });
        let autostart = self.control_loop.as_ref().and_then(|control_loop| control_loop.autostart);
        let after_dip = parameters.is_ok_and(|parameters| parameters.device.autostart_after_dip);
        let is_sure = !boot.is_damaged && (!boot.may_be_dip || after_dip);
        self.countdown = autostart.filter(|_| is_sure);
        let refused = match prepared {
            Ok(()) => None,
            Err(DecodeError::Blank) => Some(Fault::NoParameters),
            Err(_) => Some(Fault::BadParameters),
        };
        if let Some(latched) = boot.fault.or(refused.map(Latched::from)) {
            self.latch(latched);
        }
    }

    /// Returns the present state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Returns the levels that the ramp has found, once it is over.
    pub fn levels(&self) -> Option<Levels> {
        let ControlLoop { course: Course::Ramp(ramp), state, .. } = self.control_loop.as_ref()?
        else {
            return None;
        };
        let found = state.ramp().findings();
        let volts = |rung: Option<u32>| rung.map(|rung| ramp.volts(rung));
        state
            .ramp()
            .is_over()
            .then(|| Levels { stick: volts(found.stick), slip: volts(found.slip) })
    }

    /// Returns the fault that is latched, if there is one.
    pub const fn latched(&self) -> Option<Latched> {
        self.latched
    }

    /// Returns the last faults.
    pub const fn log(&self) -> &FaultLog {
        &self.log
    }

    /// Returns the number of ticks since power-on.
    pub const fn clock(&self) -> u32 {
        self.clock
    }

    /// Returns the position since power-on, counts.
    pub const fn position(&self) -> i32 {
        self.follower.seen.position
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

    /// Returns the steady effort that would heat the motor as much as it is heated, V.
    pub fn thermal_effort(&self) -> f32 {
        self.control_loop
            .as_ref()
            .map_or(0.0, |control_loop| control_loop.watch.effort(&control_loop.monitors))
    }

    /// Latches a fault that has no value; see [`latch`](Self::latch).
    pub fn fault(&mut self, fault: Fault) {
        self.latch(Latched { tick: self.clock, ..Latched::from(fault) });
    }

    /// Latches a fault, unless one is latched already. The next tick's output is off, and the loop
    /// forgets its state.
    pub fn latch(&mut self, latched: Latched) {
        if matches!(self.state, State::Faulted(_)) {
            return;
        }
        self.state = State::Faulted(latched.fault);
        self.latched = Some(latched);
        self.log.push(latched);
        self.countdown = None;
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.rest();
        }
    }

    /// Clears the latched fault, which leaves the servo stopped. Without a fault, nothing happens.
    ///
    /// # Errors
    /// Refuses if only valid parameters or a reset end the fault.
    pub fn clear(&mut self) -> Result<(), Refusal> {
        let State::Faulted(fault) = self.state else { return Ok(()) };
        if !fault.is_clearable() || self.control_loop.is_none() {
            return Err(Refusal::NotClearable(fault));
        }
        self.state = State::Stopped;
        self.latched = None;
        Ok(())
    }

    /// Arms the servo: the motion of the parameters begins at the next tick. If the servo is armed
    /// already, nothing happens.
    ///
    /// # Errors
    /// Says what is in the way.
    pub fn arm(&mut self) -> Result<(), Refusal> {
        if let State::Armed = self.state {
            return Ok(());
        }
        let here = self.follower.seen.position;
        let control_loop = self.ready_to_arm()?;
        if control_loop.replaced {
            return Err(Refusal::Replaced);
        }
        if control_loop.leads_out(&control_loop.course, here) {
            return Err(Refusal::OutOfRange);
        }
        // Arming makes the place of the joint zero.
        if control_loop.begins_far_from(&control_loop.course, 0) {
            return Err(Refusal::FarAway);
        }
        self.start_loop(false);
        Ok(())
    }

    /// Arms the servo for a link: at the next tick a ramp begins, or, without one, the joint holds
    /// its place. From then on, the silence of that link is a fault. If the servo is armed already,
    /// only the watch over the link begins; a ramp is refused then, and so is everything while a
    /// ramp or a jog runs.
    ///
    /// # Errors
    /// Says what is in the way.
    pub fn arm_for_link(&mut self, ramp: Option<Ramp>) -> Result<(), Refusal> {
        if let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) {
            // The loop of a ramp and of a jog is open: nobody shall be told that it is closed.
            if ramp.is_some() || matches!(control_loop.course, Course::Ramp(_) | Course::Jog(_)) {
                return Err(Refusal::Armed);
            }
            control_loop.watch.listen();
            return Ok(());
        }
        self.ready_to_arm()?.begin(ramp.map_or_else(Course::default, Course::Ramp));
        self.start_loop(true);
        Ok(())
    }

    /// Returns the control loop that is to be armed, unless something is in the way.
    fn ready_to_arm(&mut self) -> Result<&mut ControlLoop, Refusal> {
        match self.state {
            State::Boot => return Err(Refusal::Booting),
            State::Faulted(fault) => return Err(Refusal::Faulted(fault)),
            State::Armed => return Err(Refusal::Armed),
            State::Stopped => {}
        }
        let (Some(control_loop), Follower { encoder: Some(_), seen, supply, .. }) =
            (&mut self.control_loop, self.follower)
        else {
            return Err(Refusal::Booting);
        };
        if !control_loop.monitors.is_at_rest(&seen) {
            return Err(Refusal::Moving);
        }
        match control_loop.monitors.forbids_arming(&control_loop.watch, &seen, supply) {
            Some(fault) => Err(Refusal::WouldTrip(fault)),
            None => Ok(control_loop),
        }
    }

    /// Starts the control loop where the joint is now: closed, or open for a ramp.
    fn start_loop(&mut self, by_link: bool) {
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.arm(self.follower.seen.position, by_link);
            self.wake_up.begin(&control_loop.driver_times);
            self.state = State::Armed;
            self.countdown = None;
        }
    }

    /// Turns the output off. A fault stays latched.
    pub fn stop(&mut self) {
        self.countdown = None;
        if matches!(self.state, State::Armed) {
            self.state = State::Stopped;
            if let Some(control_loop) = &mut self.control_loop {
                control_loop.rest();
            }
        }
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
        }
        // Not `take`, which would put a third kilobyte on the stack.
        core::mem::swap(&mut self.control_loop, control_loop);
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
        if let Some(control_loop) = &self.control_loop {
            self.follower.update(control_loop.controller.encoder(), input);
        }
        self.advance();
        let (State::Armed, Some(control_loop)) = (self.state, &mut self.control_loop) else {
            if let Some(control_loop) = &mut self.control_loop {
                control_loop.monitors.idle(&mut control_loop.watch, &self.follower.seen);
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
            self.latch(Latched { fault: trip.fault, tick: self.clock, value: trip.value });
            return self.off(tick);
        }
        if control_loop.is_over() {
            self.stop();
            return self.off(tick);
        }
        let wound_up = control_loop.watch.warning();
        self.output(tick, true, wound_up)
    }

    /// Runs a tick of the driver's wake-up.
    // Not in the tick, which it would make longer.
    #[inline(never)]
    fn wake(&mut self, supply: u16) -> Output {
        let Some(control_loop) = &mut self.control_loop else { return self.off(Tick::default()) };
        let seen = &self.follower.seen;
        let trip = control_loop.monitors.waking(&mut control_loop.watch, seen, supply);
        if let Some(trip) = trip {
            self.latch(Latched { fault: trip.fault, tick: self.clock, value: trip.value });
            return self.off(Tick::default());
        }
        // The joint may be turned meanwhile: the loop begins where it rests.
        control_loop.begin_at(seen.position);
        let wakes = self.wake_up.step(control_loop.monitors.is_at_rest(seen));
        Output { wakes, ..self.off(Tick::default()) }
    }

    /// Runs a tick with the output off, and arms for the next one if the servo arms itself.
    // Arming and a tick of the loop in one interrupt would be the longest of all.
    #[inline(never)]
    fn stopped(&mut self) -> Output {
        let output = self.off(Tick::default());
        if let (State::Stopped, Some(0)) = (self.state, self.countdown) {
            match self.arm() {
                // It would never arm, and nobody would be told why.
                Err(Refusal::FarAway) => self.fault(Fault::FollowingError),
                Err(Refusal::OutOfRange) => self.fault(Fault::PositionLimit),
                // If the joint is not at rest yet, or the supply is not up, the next tick tries
                // again.
                _ => {}
            }
        }
        output
    }

    /// Makes the transitions that need no command.
    fn advance(&mut self) {
        match (self.state, self.countdown) {
            (State::Boot, _) => self.state = State::Stopped,
            (State::Stopped, Some(ticks)) => self.countdown = Some(ticks.saturating_sub(1)),
            _ => {}
        }
    }

    fn neutral(&self) -> Duty {
        self.control_loop
            .as_ref()
            .map_or(Duty::default(), |running| running.controller.drive().duty(0))
    }

    /// Returns the output of a tick in which nothing is driven.
    fn off(&self, tick: Tick) -> Output {
        let Duty { compare, reverse } = self.neutral();
        self.output(Tick { v_applied: 0.0, code: 0, compare, reverse, ..tick }, false, false)
    }

    #[inline]
    fn output(&self, mut tick: Tick, enable: bool, wound_up: bool) -> Output {
        let (state, clock) = (self.state, self.clock);
        tick.status = status(state, enable, tick.saturated, wound_up);
        Output { enable, wakes: false, state, tick, clock, wound_up }
    }
}

/// Returns the bits of [`Tick::status`].
#[inline]
fn status(state: State, enable: bool, saturated: bool, wound_up: bool) -> u32 {
    let (state, fault) = match state {
        State::Boot => (0, 0),
        State::Stopped => (1, 0),
        State::Armed => (2, 0),
        State::Faulted(fault) => (3, fault as u32),
    };
    let bit = |set: bool, place: u32| u32::from(set) << place;
    state | fault << 8 | bit(saturated, 16) | bit(wound_up, 17) | bit(enable, 18)
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
