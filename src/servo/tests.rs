use super::*;
use crate::controller::ControllerConfig;
use crate::drive::{DriveConfig, PwmMode};
use crate::encoder::{CounterBits, Direction, Encoder};
use crate::parameters::{Device, Motion};
use crate::pd::PdGains;
use crate::position::Position;

const NEUTRAL: Duty = Duty { compare: 1909, reverse: false };

fn parameters(device: Device) -> Parameters {
    let drive = DriveConfig { full_scale: 5.0, lsb: 0.00488, mode: PwmMode::LockedAntiphase, pwm_top: 3818 };
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
