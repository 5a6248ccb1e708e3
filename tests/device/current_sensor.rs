//! A device with a sensor of its motor's current: what it measures, what it limits, and which fault
//! is which.

use std::f64::consts::E;

use experiments::current_sensor::current_sensor;
use simulator::device::parameters;
use simulator::device::simulated::{MotorWires, ShuntState, SimulatedDevice};
use stiction::motion::Motion;
use stiction::servo::{Boot, Output, Refusal, State};
use stiction::units::position::Position;
use stiction::{Fault, Parameters};

use crate::dead_encoder::step;

/// Laws of an image, of which the file of the joint has gains.
const LAWS: [&str; 3] = ["robust", "srnf", "pd"];

/// Current of a step of the converter: 30 A / 2047.5, and a millivolt of the pin.
pub const STEP_A: f64 = 30.0 / 2047.5 + 30.0 / 1650.0;

fn device(law: &str, set: &[&str]) -> SimulatedDevice {
    let mut device = SimulatedDevice::new(&current_sensor(&[law], set)[0]).unwrap();
    device.ticks(200);
    device
}

/// Arms the device, and begins a move.
pub fn moves(device: &mut SimulatedDevice, to_deg: f64) {
    let parameters = device.device.parameters().unwrap().clone();
    device.device.servo().arm_for_link(None).unwrap();
    // The soft start.
    (0..600).for_each(|_| {
        heard(device);
    });
    let counts = to_deg / f64::from(parameters.controller.encoder.resolution);
    let motion = Motion::Profiled(Position::from_counts(counts.round() as i32));
    let course = motion.course(&parameters.controller, &parameters.profile).unwrap();
    let stiction::Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
    device.device.servo().go_to(profile).unwrap();
}

/// Runs a tick of a link that goes on talking.
pub fn heard(device: &mut SimulatedDevice) -> Output {
    device.device.servo().heard();
    device.tick()
}

#[test]
fn the_measured_current_is_that_of_the_winding_under_every_law() {
    for law in LAWS {
        for set in [&[][..], &["motor.inductance_h=0.0126"], &["current_sensor.direction=reverse"]]
        {
            let mut device = device(law, set);
            moves(&mut device, 20.0);
            let mut most: f64 = 0.0;
            for tick in 0..1500 {
                let current_a = device.current_a();
                let output = heard(&mut device);
                assert_eq!(output.state, State::Armed, "{law} {set:?} {tick}");
                let measured = f64::from(output.tick.current);
                assert!((measured - current_a).abs() < STEP_A, "{law}: {measured}, {current_a}");
                most = most.max(current_a.abs());
            }
            assert!(most > 0.9, "{law} {set:?}: {most} A");
            assert!((device.position_deg() - 20.0).abs() < 0.5, "{}", device.position_deg());
        }
    }
}

/// What failed on the way of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Failure {
    Open,
    Shorted,
    Unpowered,
    Sensor(ShuntState),
}

/// Returns the fault of a failure, the ticks until it was latched, and the travel meanwhile, deg.
fn fails(law: &str, failure: Failure) -> (Fault, u32, f64) {
    let set = ["device.dead_time_s=1e-7", "current_sensor.full_scale_a=10"];
    let mut device = device(law, &set);
    moves(&mut device, 40.0);
    while device.position_deg() < 5.0 {
        assert_eq!(heard(&mut device).state, State::Armed, "{law}");
    }
    match failure {
        Failure::Open => device.motor_wires = MotorWires::Open,
        Failure::Shorted => device.motor_wires = MotorWires::Shorted,
        Failure::Unpowered => device.is_unpowered = true,
        Failure::Sensor(state) => device.shunt.as_mut().unwrap().state = state,
    }
    let from_deg = device.position_deg();
    let found = (1..1000).find_map(|tick| match heard(&mut device).state {
        State::Faulted(fault) => Some((fault, tick)),
        _ => None,
    });
    let (fault, ticks) = found.unwrap();
    (fault, ticks, device.position_deg() - from_deg)
}

/// The dead time of 0.1 us may cost 0.2 V, and brushes 1 V: with 0.2 A of the sensor's 10 A, an
/// effort of 1.7 V is judged. On the way the effort is that of friction and speed: 4.1 N
/// m / 4.545 N m/A = 0.9 A and more, and 2.3 V. An open wire takes 20 ms to 50 ms of the
/// conditions, and the lag of 20 ms before, in which the current has to fall to a quarter: 20 ms ln
/// 4 = 28 ms.
#[test]
fn each_failure_of_wires_supply_and_sensor_is_its_own_fault_within_its_time() {
    use Failure::{Open, Sensor, Shorted, Unpowered};
    use ShuntState::{Reversed, Stuck};
    for law in LAWS {
        for (failure, expected, most) in [
            (Shorted, Fault::OverCurrent, 2),
            (Open, Fault::MotorOpen, 90),
            (Unpowered, Fault::MotorOpen, 90),
            (Sensor(Stuck(0)), Fault::OverCurrent, 2),
            (Sensor(Stuck(3300)), Fault::OverCurrent, 2),
            (Sensor(Reversed), Fault::CurrentSensor, 90),
        ] {
            let (fault, ticks, travel_deg) = fails(law, failure);
            assert_eq!(fault, expected, "{law}, {failure:?}, after {ticks} ticks");
            assert!(ticks <= most, "{law}, {failure:?}: {ticks}");
            assert!(travel_deg < 1.0, "{law}, {failure:?}: {travel_deg} deg");
        }
        // A sensor that says nothing while the joint moves on.
        let (fault, ticks, _) = fails(law, Sensor(Stuck(1650)));
        assert_eq!(fault, Fault::CurrentSensor, "{law}: {ticks}");
        assert!(ticks <= 90, "{law}: {ticks}");
    }
}

/// The file has three times the resistance of the winding. Friction and a load of 4.5 N m take 1.9
/// A, 4.7 V: of the file's resistance 0.6 A, and some more for the back-EMF. Twice of it and 0.2 A
/// are less.
#[test]
fn a_winding_with_a_third_of_its_resistance_is_too_much_current_under_a_load() {
    let set = [
        "load.constant_nm=-4.5",
        "current_sensor.resistance_ohm=7.53",
        "current_sensor.full_scale_a=10",
    ];
    let mut device = device("robust", &set);
    moves(&mut device, 40.0);
    let fault = (0..1000).find_map(|_| match heard(&mut device).state {
        State::Faulted(fault) => Some(fault),
        _ => None,
    });
    assert_eq!(fault, Some(Fault::MotorShorted));
}

#[test]
fn a_sensor_whose_offset_is_off_forbids_arming_and_one_within_its_bounds_is_calibrated() {
    // A twentieth of 1650 mV are 82.5 mV.
    for (mv, is_allowed) in [(1650, true), (1570, true), (1730, true), (1560, false), (1740, false)]
    {
        let mut device = device("robust", &[]);
        device.shunt.as_mut().unwrap().state = ShuntState::Stuck(mv);
        device.ticks(100);
        let found = device.device.servo().arm_for_link(None);
        let expected =
            if is_allowed { Ok(()) } else { Err(Refusal::WouldTrip(Fault::CurrentSensor)) };
        assert_eq!(found, expected, "{mv} mV");
    }
}

/// A fiftieth of 1650 mV are 33 mV; two of three readings have the noise, so 30 mV are 20 mV, and
/// 75 mV are 50 mV.
#[test]
fn a_noisy_sensor_forbids_arming_until_the_noise_is_gone() {
    let mut device = device("robust", &[]);
    for (mv, is_allowed) in [(30, true), (75, false), (30, true), (3, true)] {
        device.shunt.as_mut().unwrap().state = ShuntState::Noisy(mv);
        device.ticks(200);
        let found = device.device.servo().arm_for_link(None);
        let expected =
            if is_allowed { Ok(()) } else { Err(Refusal::WouldTrip(Fault::CurrentSensor)) };
        assert_eq!(found, expected, "{mv} mV");
        heard(&mut device);
        device.device.servo().stop();
    }
}

/// A step of 20 deg with three times the noise of the ensembles.
#[test]
fn a_noise_of_9_mv_is_no_fault_in_motion_under_any_law() {
    for law in LAWS {
        let mut device = device(law, &[]);
        device.shunt.as_mut().unwrap().state = ShuntState::Noisy(9);
        device.ticks(100);
        moves(&mut device, 20.0);
        for tick in 0..2000 {
            assert_eq!(heard(&mut device).state, State::Armed, "{law}, {tick}");
        }
        assert!((device.position_deg() - 20.0).abs() < 0.5, "{law}: {}", device.position_deg());
    }
}

/// Returns parameters whose loop holds a step of 90 deg against a block, without the monitors that
/// would end it, and the joint with another resistance.
fn blocked(resistance: f64, peak_a: &str) -> SimulatedDevice {
    let set = [
        peak_a,
        "limits.stall_v=off",
        "limits.following_error_deg=off",
        "limits.progress_gain_deg_per_s2_per_v=off",
        "limits.breakaway_min_v=1000",
        "limits.breakaway_v=40",
        "limits.stall_impulse_vs=off",
        "limits.thermal_s=1",
        "limits.continuous_v=5.02",
        "current_sensor.resistance_ohm=2.51",
        "device.soft_start_s=0",
    ];
    let configured = parameters(&current_sensor(&["pd"], &set)[0]).unwrap();
    let resistance = format!("motor.resistance_ohm={}", resistance * 2.51);
    let joint = &current_sensor(&["pd"], &[&set[..], &[&resistance]].concat())[0];
    let mut device = SimulatedDevice::running(joint, &configured, Boot::at_zero()).unwrap();
    device.ticks(200);
    device.brake_v = 1000.0;
    device
}

/// The law asks for all of its 48 V: 19 A without a limit.
#[test]
fn a_blocked_motor_has_the_limit_of_its_current_at_most_and_that_heats_it() {
    for resistance in [0.7, 1.0, 1.4] {
        let mut device = blocked(resistance, "current_sensor.peak_a=8");
        device.device.servo().arm_for_link(None).unwrap();
        heard(&mut device);
        step(&mut device, 90.0);
        // The first tick is that of the configured resistance.
        let most = 8.0_f64.max(8.0 / resistance);
        let mut ticks = 0u32;
        let fault = loop {
            let output = heard(&mut device);
            ticks += 1;
            let current_a = device.current_a();
            let bound = if ticks < 3 { most } else { 8.0 };
            assert!(current_a < 1.01 * bound + STEP_A, "{resistance}, {ticks}: {current_a} A");
            if let State::Faulted(fault) = output.state {
                break fault;
            }
            assert!(ticks < 3 || output.tick.saturated);
        };
        assert_eq!(fault, Fault::Overheat, "{resistance}");
        // 2 A are tolerated forever; 8 A, or less through a hot winding, for
        // tau ln(1 / (1 - (2 / i)^2)).
        let current_a: f64 = if resistance > 1.0 { 8.0 / resistance } else { 8.0 };
        let expected = (1.0 / (1.0 - (2.0 / current_a).powi(2))).log(E) * 1000.0;
        assert!((f64::from(ticks) / expected - 1.0).abs() < 0.05, "{ticks}, not {expected}");
    }
}

#[test]
fn a_record_keeps_the_sensor_with_the_limits_that_follow_from_its_range() {
    let with = parameters(&current_sensor(&["robust"], &[])[0]).unwrap();
    let sensor = with.current;
    let expected = [30.0, 27.0, 13.5, 2.51];
    let found = [sensor.full_scale, sensor.trip, sensor.peak, sensor.resistance];
    assert_eq!(found, expected);
    let mut room = [0; stiction::parameters::ROOM];
    let record = with.encode(1, &mut room).unwrap();
    assert_eq!(Parameters::decode(record).unwrap().0, with);
}
