//! When the joint may be driven: the state machine around the controller.
//!
//! ```text
//!             valid parameters            arm                  stop
//!   Boot ------------------------> Stopped ----> Armed ------------------> Stopped
//!     |                               |            |
//!     +-------------------------------+------------+---- any fault ------> Faulted, until the next reset
//! ```
//!
//! Nothing is driven unless the state is [`State::Armed`]. The first fault is latched; later ones do not hide
//! it. A part that comes out of a reset with a fault to tell ([`Boot`]) tells it and stays faulted: no reset that
//! nobody asked for leads to a motion, and the reset after that one starts clean.
//!
//! Arming: there is no command link yet, so [`Servo::arm`] is called by the servo itself, `autostart_delay` after the
//! first tick, if the parameters say `autostart` (off by default) and nothing went wrong before. The position in
//! which the joint is armed becomes its zero, and the motion begins with that tick.
//!
//! After arming, the limit of the output rises in a straight line from zero to the full scale (soft start): a wrong
//! sign or a large first error shows as a slow pull and not as a jerk. The gains are those of the loop from the
//! start; what is cut off is told as `saturated`.
//!
//! A ramp that identifies the friction is its own soft start, and no faster than the one that is configured. It stops
//! by itself when it is over. If the supply is too low for its effort it is over at once, without a level.

use crate::controller::{Controller, Tick};
use crate::course::{Course, CourseState};
use crate::drive::{Drive, Duty};
use crate::fault::Fault;
use crate::parameters::{DecodeError, Parameters, SUPPLY_FULL_SCALE};
use crate::saturation::saturate;

/// The state of a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Before the first tick.
    Boot,
    /// Ready, output off.
    Stopped,
    /// The loop is closed.
    Armed,
    /// Output off until the next reset.
    Faulted(Fault),
}

/// How the part came out of its last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boot {
    /// What went wrong before it.
    pub fault: Option<Fault>,
}

/// What one tick is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Input {
    /// The encoder's counter.
    pub counter: u32,
    /// The converter's reading of the supply; not looked at unless the output is scaled by it.
    pub supply: u16,
}

/// What one tick asks of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// The bridge may be on. If not, `duty` is neutral.
    pub enable: bool,
    /// What the timer is given.
    pub duty: Duty,
    /// The state after this tick.
    pub state: State,
    /// Every term; its code and duty are those that are applied. All zero unless armed, but for the tick that ends a
    /// ramp or that meets a value which is not finite.
    pub tick: Tick,
}

/// The friction levels that a ramp has found, V of effort; none: the joint did not move, or did not rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levels {
    /// At the first count of the motion.
    pub stick: Option<f32>,
    /// At the last count before rest.
    pub slip: Option<f32>,
}

/// A joint's controller with what it needs to run.
#[derive(Clone, Debug)]
struct Joint {
    controller: Controller,
    course: Course,
    state: CourseState,
    soft_start: SoftStart,
    /// Nominal supply in the converter's units; 0: the output is left alone.
    nominal_supply: f32,
}

/// A rising limit of the code, in whole ticks.
#[derive(Clone, Copy, Debug)]
struct SoftStart {
    ticks: u32,
    elapsed: u32,
}

/// The state machine. It owns the controller and its state; the board calls [`tick`](Self::tick).
#[derive(Clone, Debug)]
pub struct Servo {
    joint: Option<Joint>,
    state: State,
    /// Ticks until it arms by itself; none: it does not.
    countdown: Option<u32>,
}

impl Servo {
    /// A servo of the parameters that were found.
    pub fn new(parameters: Result<&Parameters, DecodeError>, boot: Boot) -> Self {
        let prepared = parameters.and_then(|parameters| {
            let (controller, course) = parameters.prepare().map_err(DecodeError::Value)?;
            Ok((parameters, controller, course))
        });
        let (joint, countdown, refused) = match prepared {
            Ok((parameters, controller, course)) => {
                let device = &parameters.device;
                let in_ticks = |s: f32| libm::roundf(s / parameters.controller.sample_time) as u32;
                let nominal_supply = match device.supply_full_scale {
                    full_scale if full_scale > 0.0 => {
                        device.nominal_supply / full_scale * f32::from(SUPPLY_FULL_SCALE)
                    }
                    _ => 0.0,
                };
                let soft_start = SoftStart { ticks: in_ticks(device.soft_start), elapsed: 0 };
                let state = CourseState::default();
                let countdown = device.autostart.then(|| in_ticks(device.autostart_delay));
                (Some(Joint { controller, course, state, soft_start, nominal_supply }), countdown, None)
            }
            Err(DecodeError::Blank) => (None, None, Some(Fault::NoParameters)),
            Err(_) => (None, None, Some(Fault::BadParameters)),
        };
        let mut servo = Self { joint, state: State::Boot, countdown };
        if let Some(fault) = boot.fault.or(refused) {
            servo.fault(fault);
        }
        servo
    }

    /// The present state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// What the ramp has found, once it is over.
    pub fn levels(&self) -> Option<Levels> {
        let Joint { course: Course::Ramp(ramp), state, .. } = self.joint.as_ref()? else { return None };
        let found = state.ramp().found();
        let volts = |rung: Option<u32>| rung.map(|rung| ramp.volts(rung));
        state.ramp().is_over().then(|| Levels { stick: volts(found.stick), slip: volts(found.slip) })
    }

    /// Latches a fault, unless there is one already. The next tick's output is off.
    pub const fn fault(&mut self, fault: Fault) {
        if !matches!(self.state, State::Faulted(_)) {
            self.state = State::Faulted(fault);
        }
    }

    /// Closes the loop at the next tick, with the counter at `counter`; only from [`State::Stopped`]. Whether it did.
    pub fn arm(&mut self, counter: u32) -> bool {
        let (State::Stopped, Some(joint)) = (self.state, &mut self.joint) else { return false };
        joint.state = CourseState::start(&joint.controller, counter, 0);
        joint.soft_start.elapsed = 0;
        self.state = State::Armed;
        self.countdown = None;
        true
    }

    /// Opens the loop; a fault stays.
    pub const fn stop(&mut self) {
        self.countdown = None;
        if matches!(self.state, State::Armed) {
            self.state = State::Stopped;
        }
    }

    /// One tick of the loop's sample time.
    // Not inlined: the compiler would take the output apart where it is used, and copy the tick byte by byte, which
    // costs as much as the whole rest of the interrupt.
    #[inline(never)]
    pub fn tick(&mut self, input: Input) -> Output {
        self.advance(input.counter);
        let (State::Armed, Some(joint)) = (self.state, &mut self.joint) else { return self.off() };
        let tick = joint.tick(input);
        if tick.non_finite {
            self.fault(Fault::NonFinite);
            return Output { tick, ..self.off() };
        }
        if joint.is_over() {
            self.stop();
            let off = self.off();
            return Output { tick: Tick { code: 0, duty: off.duty, ..tick }, ..off };
        }
        Output { enable: true, duty: tick.duty, state: self.state, tick }
    }

    /// Transitions that need no command.
    fn advance(&mut self, counter: u32) {
        match (self.state, self.countdown) {
            (State::Boot, _) => self.state = State::Stopped,
            (State::Stopped, Some(0)) => {
                self.arm(counter);
            }
            (State::Stopped, Some(ticks)) => self.countdown = Some(ticks - 1),
            _ => {}
        }
    }

    fn off(&self) -> Output {
        let duty = self.joint.as_ref().map_or(Duty::default(), |joint| joint.controller.drive().duty(0));
        Output { enable: false, duty, state: self.state, tick: Tick::default() }
    }
}

impl Joint {
    #[inline]
    fn tick(&mut self, input: Input) -> Tick {
        let mut tick = control(&self.course, &self.controller, &mut self.state, input.counter);
        let drive = self.controller.drive();
        let mut code = tick.code;
        if self.nominal_supply > 0.0 {
            let v = tick.v * supply_ratio(self.nominal_supply, input.supply);
            let (v, saturated) = saturate(v, self.controller.full_scale());
            tick.saturated |= saturated;
            code = drive.code(v);
        }
        let limit = match self.course {
            Course::Follow(_) => self.soft_start.limit(drive),
            Course::Ramp(_) => drive.max_code(),
        };
        let limited = code.max(-limit).min(limit);
        if limited != tick.code {
            tick.saturated |= limited != code;
            tick.code = limited;
            tick.duty = drive.duty(limited);
        }
        if let Course::Ramp(_) = self.course
            && tick.saturated
        {
            self.state.ramp_mut().abandon();
        }
        tick
    }

    /// Of a ramp only: a reference has no end.
    const fn is_over(&self) -> bool {
        matches!(self.course, Course::Ramp(_)) && self.state.ramp().is_over()
    }
}

/// The core's tick as a function of its own, so that `cargo xtask cost` can count its instructions in the flash image.
/// The call costs a dozen of them.
#[inline(never)]
fn control(course: &Course, controller: &Controller, state: &mut CourseState, counter: u32) -> Tick {
    course.tick(controller, state, counter)
}

impl SoftStart {
    /// The largest code of this tick.
    fn limit(&mut self, drive: &Drive) -> i16 {
        let max = drive.max_code();
        if self.elapsed >= self.ticks {
            return max;
        }
        // 10 s at 10 kHz, and 32 767 codes: the product fits.
        let scaled = self.elapsed.wrapping_mul(u32::from(max.unsigned_abs()));
        self.elapsed += 1;
        scaled.checked_div(self.ticks).unwrap_or(0) as i16
    }
}

/// How much more duty the present supply needs, within a factor of two either way: a broken divider must not turn
/// into full effort.
fn supply_ratio(nominal: f32, measured: u16) -> f32 {
    (nominal / f32::from(measured.max(1))).clamp(0.5, 2.0)
}

#[cfg(test)]
mod tests;
