use super::*;
use crate::control::brake_resistor::BrakeResistor;
use crate::control::controller::{ControllerConfig, EffortMode};
use crate::control::current_sensor::CurrentSensor;
use crate::control::drive::{DriveConfig, Duty, PwmMode};
use crate::control::encoder::{CounterBits, Direction, Encoder};
use crate::control::hardware::Hardware;
use crate::control::motor_encoder::MotorEncoder;
use crate::control::motor_ntc::MotorNtc;
use crate::control::pd::PdGains;
use crate::control::profile::ProfileLimits;
use crate::control::reference::{Corner, Reference, Sine, Step, Trajectory};
use crate::motion::Motion;
use crate::motion::jog::JogBounds;
use crate::parameters::{DecodeError, DeviceConfig, Parameters};
use crate::safety::monitor::Limits;
use crate::units::position::Position;
use crate::units::value::Table;

const HARDWARE: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

const NEUTRAL: Duty = Duty { compare: 1909, reverse: false };

fn parameters(device: DeviceConfig) -> Parameters {
    let drive = DriveConfig {
        full_scale: 5.0,
        lsb: 0.00488,
        mode: PwmMode::LockedAntiphase,
        pwm_hz: 22e3,
        duty_max: 1.0,
    };
    let encoder = Encoder {
        resolution: 0.01,
        counter_bits: CounterBits::ThirtyTwo,
        direction: Direction::Forward,
        ..Encoder::EXAMPLE
    };
    let controller = ControllerConfig {
        sample_time: 0.01,
        encoder,
        velocity_window: 5,
        effort: EffortMode::Voltage,
        pd: PdGains { kp: 1.0, kd: 0.0 },
        compensator: heapless::Vec::new(),
        motor: MotorEncoder::NONE,
        drive,
    };
    Parameters {
        controller,
        motion: Motion::Step(Position::from_counts(250)),
        device,
        limits: Limits::OFF,
        profile: ProfileLimits { velocity: 50.0, acceleration: 100.0, jerk: 5000.0 },
        jog: JogBounds::EXAMPLE,
        current: CurrentSensor::NONE,
        brake_resistor: BrakeResistor::NONE,
        motor_ntc: MotorNtc::NONE,
    }
}

fn servo(device: DeviceConfig) -> Servo {
    Servo::new(Ok(&parameters(device)), Boot::default(), &HARDWARE)
}

fn at_once() -> DeviceConfig {
    DeviceConfig { soft_start: 0.0, ..DeviceConfig::CAUTIOUS }
}

fn tick(servo: &mut Servo, counter: u32) -> Output {
    servo.tick(Input { counter, supply: 2048, lines: 0, ..Input::default() })
}

/// Returns an armed servo, whose joint has been at rest for long enough at `counter`.
fn armed(device: DeviceConfig, counter: u32) -> Servo {
    let mut servo = servo(device);
    for _ in 0..10 {
        tick(&mut servo, counter);
    }
    assert_eq!(servo.arm(), Ok(()));
    servo
}

#[test]
fn nothing_is_driven_until_it_is_armed() {
    let mut servo = servo(at_once());
    assert_eq!(servo.state(), State::Boot);
    assert_eq!(servo.arm(), Err(Refusal::Booting));
    for _ in 0..1000 {
        let output = tick(&mut servo, 7);
        assert_eq!((output.state, output.enable, output.duty()), (State::Stopped, false, NEUTRAL));
    }
    assert_eq!(servo.arm(), Ok(()));
    let output = tick(&mut servo, 7);
    // 2.5 deg under 1 V/deg: as the controller alone has it.
    assert_eq!((output.state, output.enable, output.tick.code), (State::Armed, true, 512));
    servo.stop();
    let output = tick(&mut servo, 7);
    assert_eq!((output.state, output.enable, output.duty()), (State::Stopped, false, NEUTRAL));
}

#[test]
fn autostart_waits_for_its_delay_and_begins_at_zero() {
    let mut servo = servo(DeviceConfig { autostart: true, autostart_delay: 0.05, ..at_once() });
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
    for &fault in Fault::ALL {
        let mut servo = armed(at_once(), 0);
        assert!(tick(&mut servo, 0).enable);
        servo.fault(fault);
        servo.fault(Fault::Panic);
        servo.stop();
        assert_eq!(servo.arm(), Err(Refusal::Faulted(fault)));
        let output = tick(&mut servo, 0);
        assert_eq!(
            (output.state, output.enable, output.duty()),
            (State::Faulted(fault), false, NEUTRAL)
        );
    }
}

#[test]
fn a_fault_from_before_the_reset_prevents_autostart() {
    let device = DeviceConfig { autostart: true, autostart_delay: 0.0, ..at_once() };
    let boot = Boot { fault: Some(Fault::Watchdog.into()), ..Boot::default() };
    let mut servo = Servo::new(Ok(&parameters(device)), boot, &HARDWARE);
    for _ in 0..100 {
        assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::Watchdog));
    }
}

#[test]
fn no_parameters_and_bad_ones_are_faults() {
    let mut servo = Servo::new(Err(DecodeError::Blank), Boot::default(), &HARDWARE);
    assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::NoParameters));
    let mut servo = Servo::new(Err(DecodeError::Checksum), Boot::default(), &HARDWARE);
    assert_eq!(tick(&mut servo, 0).state, State::Faulted(Fault::BadParameters));
    let mut bad = parameters(at_once());
    bad.controller.pd.kp = f32::NAN;
    assert_eq!(
        Servo::new(Ok(&bad), Boot::default(), &HARDWARE).state(),
        State::Faulted(Fault::BadParameters)
    );
}

#[test]
fn the_limit_rises_in_a_straight_line() {
    let mut servo = armed(DeviceConfig { soft_start: 0.1, ..DeviceConfig::CAUTIOUS }, 0);
    let codes = [(); 7].map(|()| tick(&mut servo, 0).tick.code);
    assert_eq!(codes, [0, 102, 204, 307, 409, 512, 512]);
    servo.stop();
    assert_eq!(servo.arm(), Ok(()));
    let output = tick(&mut servo, 0);
    assert_eq!((output.tick.code, output.tick.saturated, output.duty()), (0, true, NEUTRAL));
}

#[test]
fn the_output_follows_the_supply_within_a_factor_of_two() {
    let device = DeviceConfig { nominal_supply: 12.0, supply_full_scale: 24.0, ..at_once() };
    let mut servo = armed(device, 0);
    let mut code =
        |supply| servo.tick(Input { counter: 0, supply, lines: 0, ..Input::default() }).tick.code;
    // 2.5 V at the nominal supply (half of 4095); more of it at less supply.
    assert_eq!([2730, 4095, 1365, 0].map(&mut code), [384, 256, 768, 1024]);
}

#[test]
fn a_value_that_is_not_finite_is_a_fault() {
    let mut servo = armed(at_once(), 0);
    assert!(tick(&mut servo, 0).enable);
    // Only extreme parameters cause this: the check is the last line of defence.
    let to = Position { counts: 0, fraction: f32::NAN };
    let reference = Reference::Step(Step { to, ..Default::default() });
    servo.control_loop.as_mut().unwrap().course = Course::Follow(reference);
    let output = tick(&mut servo, 0);
    assert_eq!((output.enable, output.duty()), (false, NEUTRAL));
    assert_eq!(output.state, State::Faulted(Fault::NonFinite));
    assert!(output.tick.non_finite);
}

#[test]
fn silence_is_a_fault_from_the_first_request_on_that_a_link_makes_of_a_servo_that_armed_itself() {
    type Ask = fn(&mut Servo) -> Result<(), Refusal>;
    fn step(servo: &mut Servo, to: i32) -> Result<(), Refusal> {
        servo.follow(Reference::Step(Step { to: Position::from_counts(to), ..Step::default() }))
    }
    let takes_over: [Ask; 3] =
        [|servo| servo.arm_for_link(None), |servo| servo.hold(), |servo| step(servo, 0)];
    let does_not: [Ask; 2] = [
        |servo| step(servo, 5_000),
        |servo| {
            servo.heard();
            Err(Refusal::OutOfRange)
        },
    ];
    for (i, ask) in takes_over.iter().chain(&does_not).enumerate() {
        let mut parameters = parameters(DeviceConfig { autostart: true, ..at_once() });
        parameters.limits.link_timeout = 0.1;
        (parameters.limits.position_min, parameters.limits.position_max) = (-45.0, 45.0);
        let mut servo = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
        let enabled = |servo: &mut Servo| (0..200).filter(|_| tick(servo, 0).enable).count();
        enabled(&mut servo);
        assert_eq!((servo.state(), enabled(&mut servo)), (State::Armed, 200), "{i}");
        let is_over = ask(&mut servo).is_ok();
        assert_eq!(is_over, i < takes_over.len(), "{i}");
        // 0.1 s of silence are allowed.
        let (state, ticks) =
            if is_over { (State::Faulted(Fault::LinkTimeout), 10) } else { (State::Armed, 200) };
        assert_eq!((enabled(&mut servo), servo.state()), (ticks, state), "{i}");
    }
}

/// Returns a ramp of 0.5 V/s at 10 ms, held for 0.1 s.
fn ramp(device: DeviceConfig) -> Servo {
    let mut parameters = parameters(device);
    parameters.motion = Motion::Ramp { rate: 0.5, hold: 0.1 };
    Servo::new(Ok(&parameters), Boot::default(), &HARDWARE)
}

/// Returns the counter of a joint that moves by a count a tick from the fortieth tick to the
/// hundredth.
fn moved(tick: u32) -> u32 {
    tick.clamp(40, 100)
}

#[test]
fn a_ramp_stops_by_itself_and_tells_its_levels() {
    let mut servo = ramp(DeviceConfig::CAUTIOUS);
    (0..10).for_each(|_| assert!(!tick(&mut servo, moved(0)).enable));
    for _ in 0..2 {
        assert_eq!(servo.arm(), Ok(()));
        assert_eq!(servo.levels(), None);
        let mut last = 0;
        for k in 0.. {
            let output = tick(&mut servo, moved(k));
            if !output.enable {
                assert_eq!(
                    (output.state, output.duty(), output.tick.code),
                    (State::Stopped, NEUTRAL, 0)
                );
                last = k;
                break;
            }
            // The soft start would allow 20 codes a tick: the ramp is below it, from its first tick
            // on.
            let rung = if k < 42 { k + 1 } else { 42u32.saturating_sub(k.saturating_sub(52)) };
            let v = rung as f32 * 0.005;
            assert!(
                (output.tick.v - v).abs() < 1e-6 && output.tick.code == (v / 0.00488 + 0.5) as i16,
                "{k}"
            );
            assert_eq!(
                (output.tick.error, output.tick.v_pd, output.tick.saturated),
                (0.0, 0.0, false)
            );
        }
        // A count at tick 41 under the effort of tick 40; the last at tick 100, and a second
        // without any.
        assert_eq!(last, 100 + 101);
        // It is at rung 42 - 47 by then: at zero, and held there.
        assert_eq!(
            servo.levels(),
            Some(FrictionLevels { stick: Some(41.0 * 0.005), slip: Some(0.0) })
        );
        assert!((0..200).all(|_| !tick(&mut servo, moved(0)).enable));
    }
}

#[test]
fn a_fault_ends_a_ramp_without_levels() {
    let mut servo = ramp(at_once());
    (0..10).for_each(|_| assert!(!tick(&mut servo, 0).enable));
    assert_eq!(servo.arm(), Ok(()));
    assert!((0..10).all(|_| tick(&mut servo, 0).enable));
    servo.fault(Fault::BreakInput);
    let output = tick(&mut servo, 0);
    assert_eq!((output.enable, output.duty(), servo.levels()), (false, NEUTRAL, None));
}

#[test]
fn a_supply_too_low_for_the_effort_ends_a_ramp_without_levels() {
    let device = DeviceConfig { nominal_supply: 12.0, supply_full_scale: 24.0, ..at_once() };
    let mut servo = ramp(device);
    (0..10).for_each(|_| assert!(!tick(&mut servo, 0).enable));
    assert_eq!(servo.arm(), Ok(()));
    // Two thirds of the nominal supply: 3/2 of the effort, so that 3.33 V, rung 667, become 5 V.
    let ticks = (0..2000)
        .take_while(|_| {
            servo.tick(Input { counter: 0, supply: 1365, lines: 0, ..Input::default() }).enable
        })
        .count();
    assert_eq!(ticks, 666);
    assert_eq!((servo.state(), servo.levels()), (State::Stopped, Some(FrictionLevels::default())));
}

#[test]
fn a_trajectory_and_a_sine_begin_where_the_joint_is_or_are_refused() {
    let mut parameters = parameters(at_once());
    // 100 counts.
    parameters.limits.following_error = 1.0;
    parameters.motion = Motion::Hold;
    let mut servo = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
    for _ in 0..10 {
        tick(&mut servo, 0);
    }
    servo.arm_for_link(None).unwrap();
    // The joint has been moved to 50 counts by something else.
    tick(&mut servo, 50);
    let through = |first: i32| {
        let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
        let corners = [corner(100, first), corner(300, 0)];
        Reference::Trajectory(Trajectory::new(&corners, 0.25, 0.01, 0.01).unwrap())
    };
    for (first, expected) in
        [(-51, Err(Refusal::FarAway)), (-50, Ok(())), (150, Ok(())), (151, Err(Refusal::FarAway))]
    {
        assert_eq!(servo.follow(through(first)), expected, "{first}");
        let from = Position::from_counts(first);
        let sine = Reference::Sine(Sine::new(from, 20.0, 1.0, 0.01, 0.01).unwrap());
        assert_eq!(servo.follow(sine), expected, "{first}");
    }
    // The motion of the parameters ends in a fault, since no client receives a refusal.
    let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
    for (first, expected) in [(100, State::Armed), (101, State::Faulted(Fault::FollowingError))] {
        let corners = [corner(100, first), corner(300, 0)].into_iter().collect();
        parameters.motion = Motion::Trajectory { corners, half_blend: 0.25 };
        parameters.device.autostart = true;
        let mut by_itself = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
        let state = (0..200)
            .map(|_| tick(&mut by_itself, 0).state)
            .find(|state| !matches!(state, State::Boot | State::Stopped));
        assert_eq!(state, Some(expected), "{first}");
    }
    // A step is a deliberate jump.
    let step = Step { to: Position::from_counts(1000), ..Step::default() };
    assert_eq!(servo.follow(Reference::Step(step)), Ok(()));
}

/// 5 V and 1 V/deg: an error of 500 counts reaches the full scale.
#[test]
fn a_trajectory_is_no_jump_where_the_following_error_is_off_or_as_large_as_a_turn() {
    for following_error in [0.0, 360.0] {
        let mut parameters = parameters(at_once());
        parameters.limits.following_error = following_error;
        parameters.motion = Motion::Hold;
        let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
        for (first, is_near) in [(500, true), (501, false), (-500, true), (-501, false)] {
            let mut servo = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
            for _ in 0..10 {
                tick(&mut servo, 0);
            }
            servo.arm_for_link(None).unwrap();
            tick(&mut servo, 0);
            let corners = [corner(100, first), corner(300, 0)];
            let trajectory = Trajectory::new(&corners, 0.25, 0.01, 0.01).unwrap();
            let expected = if is_near { Ok(()) } else { Err(Refusal::FarAway) };
            assert_eq!(servo.follow(Reference::Trajectory(trajectory)), expected, "{first}");
        }
    }
}

#[test]
fn a_motion_of_the_parameters_that_leads_out_of_the_range_is_never_begun() {
    let autostart = DeviceConfig { autostart: true, autostart_delay: 0.0, ..at_once() };
    for (device, is_automatic) in [(at_once(), false), (autostart, true)] {
        let mut parameters = parameters(device);
        // The set point is 250 counts, 2.5 deg.
        for (position_max, leads_out) in [(2.6, false), (2.4, true)] {
            parameters.limits.position_max = position_max;
            let mut servo = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
            let drives = (0..20).any(|_| tick(&mut servo, 0).enable);
            assert_eq!(drives, is_automatic && !leads_out, "{position_max}");
            if is_automatic && leads_out {
                assert_eq!(servo.state(), State::Faulted(Fault::PositionLimit));
            } else if !is_automatic {
                assert_eq!(servo.arm().is_err(), leads_out, "{position_max}");
            }
        }
    }
}

/// 1.2 deg of amplitude turn at 2.4 deg.
#[test]
fn a_sine_whose_far_turn_is_out_of_the_range_is_refused() {
    let mut parameters = parameters(at_once());
    parameters.motion = Motion::Hold;
    for (position_max, expected) in [(2.5, Ok(())), (2.3, Err(Refusal::OutOfRange))] {
        parameters.limits.position_max = position_max;
        let mut servo = Servo::new(Ok(&parameters), Boot::default(), &HARDWARE);
        for _ in 0..10 {
            tick(&mut servo, 0);
        }
        servo.arm_for_link(None).unwrap();
        tick(&mut servo, 0);
        let sine = Sine::new(Position::default(), 120.0, 1.0, 0.01, 0.01).unwrap();
        assert_eq!(servo.follow(Reference::Sine(sine)), expected, "{position_max}");
    }
}

#[test]
fn no_closed_loop_is_reported_to_a_client_while_a_ramp_runs() {
    let mut servo = ramp(at_once());
    (0..10).for_each(|_| assert!(!tick(&mut servo, 0).enable));
    assert_eq!(servo.arm(), Ok(()));
    assert!(tick(&mut servo, 0).enable);
    assert_eq!(servo.arm_for_link(None), Err(Refusal::Armed));
    assert!(tick(&mut servo, 0).enable);
}
