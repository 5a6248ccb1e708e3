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

use crate::controller::{Controller, ControllerState, Tick};
use crate::drive::{Drive, Duty};
use crate::fault::Fault;
use crate::parameters::{DecodeError, Parameters, SUPPLY_FULL_SCALE};
use crate::reference::Reference;

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
    /// Every term; its code and duty are those that are applied. All zero unless armed.
    pub tick: Tick,
}

/// A joint's controller with what it needs to run.
#[derive(Clone, Debug)]
struct Joint {
    controller: Controller,
    reference: Reference,
    state: ControllerState,
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
            let (controller, reference) = parameters.prepare().map_err(DecodeError::Value)?;
            Ok((parameters, controller, reference))
        });
        let (joint, countdown, refused) = match prepared {
            Ok((parameters, controller, reference)) => {
                let device = &parameters.device;
                let in_ticks = |s: f32| libm::roundf(s / parameters.controller.sample_time) as u32;
                let nominal_supply = match device.supply_full_scale {
                    full_scale if full_scale > 0.0 => {
                        device.nominal_supply / full_scale * f32::from(SUPPLY_FULL_SCALE)
                    }
                    _ => 0.0,
                };
                let soft_start = SoftStart { ticks: in_ticks(device.soft_start), elapsed: 0 };
                let state = ControllerState::default();
                let countdown = device.autostart.then(|| in_ticks(device.autostart_delay));
                (Some(Joint { controller, reference, state, soft_start, nominal_supply }), countdown, None)
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

    /// Latches a fault, unless there is one already. The next tick's output is off.
    pub const fn fault(&mut self, fault: Fault) {
        if !matches!(self.state, State::Faulted(_)) {
            self.state = State::Faulted(fault);
        }
    }

    /// Closes the loop at the next tick, with the counter at `counter`; only from [`State::Stopped`]. Whether it did.
    pub fn arm(&mut self, counter: u32) -> bool {
        let (State::Stopped, Some(joint)) = (self.state, &mut self.joint) else { return false };
        joint.state = joint.controller.start(counter, 0);
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
    #[inline]
    pub fn tick(&mut self, input: Input) -> Output {
        self.advance(input.counter);
        let (State::Armed, Some(joint)) = (self.state, &mut self.joint) else { return self.off() };
        let tick = joint.tick(input);
        if tick.non_finite {
            self.fault(Fault::NonFinite);
            return Output { tick, ..self.off() };
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
        let mut tick = self.controller.tick(&mut self.state, input.counter, &self.reference);
        let drive = self.controller.drive();
        let mut code = tick.code;
        if self.nominal_supply > 0.0 {
            code = drive.code(tick.v * supply_ratio(self.nominal_supply, input.supply));
        }
        let limit = self.soft_start.limit(drive);
        let limited = code.max(-limit).min(limit);
        if limited != tick.code {
            tick.saturated |= limited != code;
            tick.code = limited;
            tick.duty = drive.duty(limited);
        }
        tick
    }
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
mod tests {
    use super::*;
    use crate::controller::ControllerConfig;
    use crate::drive::{DriveConfig, PwmMode};
    use crate::encoder::{CounterBits, Direction, Encoder};
    use crate::parameters::{Device, Motion};
    use crate::pd::PdGains;
    use crate::position::Position;

    const NEUTRAL: Duty = Duty { compare: 1909, reverse: false };

    fn parameters(device: Device) -> Parameters {
        let drive =
            DriveConfig { full_scale: 5.0, lsb: 0.00488, mode: PwmMode::LockedAntiphase, pwm_top: 3818 };
        let encoder =
            Encoder { resolution: 0.01, counter_bits: CounterBits::ThirtyTwo, direction: Direction::Forward };
        let controller = ControllerConfig {
            sample_time: 0.01,
            encoder,
            velocity_window: 5,
            pd: PdGains { kp: 1.0, kd: 0.0 },
            compensator: heapless::Vec::new(),
            drive,
        };
        Parameters { controller, motion: Motion::Step(Position::from_counts(250)), device }
    }

    fn servo(device: Device) -> Servo {
        Servo::new(Ok(&parameters(device)), Boot::default())
    }

    fn at_once() -> Device {
        Device { soft_start: 0.0, ..Device::CAUTIOUS }
    }

    fn tick(servo: &mut Servo, counter: u32) -> Output {
        servo.tick(Input { counter, supply: 2048 })
    }

    #[test]
    fn nothing_is_driven_until_it_is_armed() {
        let mut servo = servo(at_once());
        assert_eq!(servo.state(), State::Boot);
        assert!(!servo.arm(0));
        for _ in 0..1000 {
            let output = tick(&mut servo, 7);
            assert_eq!((output.state, output.enable, output.duty), (State::Stopped, false, NEUTRAL));
        }
        assert!(servo.arm(7));
        let output = tick(&mut servo, 7);
        // 2.5 deg under 1 V/deg: as the controller alone has it.
        assert_eq!((output.state, output.enable, output.tick.code), (State::Armed, true, 512));
        servo.stop();
        let output = tick(&mut servo, 7);
        assert_eq!((output.state, output.enable, output.duty), (State::Stopped, false, NEUTRAL));
    }

    #[test]
    fn autostart_waits_for_its_delay_and_begins_at_zero() {
        let mut servo = servo(Device { autostart: true, autostart_delay: 0.05, ..at_once() });
        for _ in 0..6 {
            assert!(!tick(&mut servo, 900).enable);
        }
        let output = tick(&mut servo, 900);
        assert_eq!((output.enable, output.tick.tick, output.tick.counts), (true, 0, 0));
        servo.stop();
        assert!((0..100).all(|_| !tick(&mut servo, 900).enable));
    }

    #[test]
    fn the_first_fault_is_latched() {
        for fault in Fault::ALL {
            let mut servo = servo(at_once());
            tick(&mut servo, 0);
            servo.arm(0);
            assert!(tick(&mut servo, 0).enable);
            servo.fault(fault);
            servo.fault(Fault::Panic);
            servo.stop();
            assert!(!servo.arm(0));
            let output = tick(&mut servo, 0);
            assert_eq!((output.state, output.enable, output.duty), (State::Faulted(fault), false, NEUTRAL));
        }
    }

    #[test]
    fn a_fault_from_before_the_reset_prevents_autostart() {
        let device = Device { autostart: true, autostart_delay: 0.0, ..at_once() };
        let boot = Boot { fault: Some(Fault::Watchdog) };
        let mut servo = Servo::new(Ok(&parameters(device)), boot);
        for _ in 0..100 {
            assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::Watchdog));
        }
    }

    #[test]
    fn no_parameters_and_bad_ones_are_faults() {
        let mut servo = Servo::new(Err(DecodeError::Blank), Boot::default());
        assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::NoParameters));
        let mut servo = Servo::new(Err(DecodeError::Checksum), Boot::default());
        assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::BadParameters));
        let mut bad = parameters(at_once());
        bad.controller.pd.kp = f32::NAN;
        assert_eq!(Servo::new(Ok(&bad), Boot::default()).state(), State::Faulted(Fault::BadParameters));
    }

    #[test]
    fn the_limit_rises_in_a_straight_line() {
        let mut servo = servo(Device { soft_start: 0.1, ..Device::CAUTIOUS });
        tick(&mut servo, 0);
        servo.arm(0);
        let codes = [(); 7].map(|()| tick(&mut servo, 0).tick.code);
        assert_eq!(codes, [0, 102, 204, 307, 409, 512, 512]);
        servo.stop();
        servo.arm(0);
        let output = tick(&mut servo, 0);
        assert_eq!((output.tick.code, output.tick.saturated, output.duty), (0, true, NEUTRAL));
    }

    #[test]
    fn the_output_follows_the_supply_within_a_factor_of_two() {
        let device = Device { nominal_supply: 12.0, supply_full_scale: 24.0, ..at_once() };
        let mut servo = servo(device);
        tick(&mut servo, 0);
        servo.arm(0);
        let mut code = |supply| servo.tick(Input { counter: 0, supply }).tick.code;
        // 2.5 V at the nominal supply (half of 4095); more of it at less supply.
        assert_eq!([2730, 4095, 1365, 0].map(&mut code), [384, 256, 768, 1024]);
    }

    #[test]
    fn a_value_that_is_not_finite_is_a_fault() {
        let mut servo = servo(at_once());
        tick(&mut servo, 0);
        servo.arm(0);
        assert!(tick(&mut servo, 0).enable);
        // No parameters that are accepted lead here: this is the last line of defence.
        let to = Position { counts: 0, fraction: f32::NAN };
        servo.joint.as_mut().unwrap().reference =
            Reference::Step(crate::reference::Step { to, ..Default::default() });
        let output = tick(&mut servo, 0);
        assert_eq!((output.enable, output.duty), (false, NEUTRAL));
        assert_eq!(output.state, State::Faulted(Fault::NonFinite));
        assert!(output.tick.non_finite);
    }
}
