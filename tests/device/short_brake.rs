//! The short brake after a fault: how far the joint goes on, how long the bridge stays on, and what
//! ends it. And the current of a controlled stop.
//!
//! The joint is the typical one with a harmonic drive, with a sensor of its current. Travel is true
//! travel.

use experiments::current_sensor::current_sensor;
use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::servo::{BrakeCommand, State};

use crate::current_sensor::{STEP_A, heard, moves};

/// Of the file: rotor and arm, kg m^2; slip friction, N m; viscous friction of the mechanics, N m
/// s/rad; torque constant at the joint, N m/A or V s/rad; resistance, ohm.
const J: f64 = 1.348e-4 * 2500.0 + 0.1;
const F: f64 = 4.10;
const B: f64 = 1.30;
const K: f64 = 50.0 * 0.0909;
const R: f64 = 2.51;

/// Speed at the fault, deg/s. The back-EMF has a current of 2.84 A.
const SPEED: f64 = 90.0;

/// Ticks of 1 ms of the short brake.
const BRAKE: u32 = 300;

/// The drives of the tests: a voltage, and a current loop.
const EFFORTS: [&[&str]; 2] =
    [&[], &["loop.effort=current", "drive.pwm_hz=21000", "motor.inductance_h=0.0001"]];

/// A device that is armed with its joint at a speed, before the fault.
fn at_speed(set: &[&str], speed: f64) -> SimulatedDevice {
    let set = [&["device.short_brake_s=0.3"], set].concat();
    let mut device = SimulatedDevice::new(&current_sensor(&["pd"], &set)[0]).unwrap();
    device.ticks(200);
    device.device.servo().arm_for_link(None).unwrap();
    for _ in 0..600 {
        assert_eq!(heard(&mut device).state, State::Armed);
    }
    let position = device.position_deg();
    device.push(position, speed);
    device
}

/// Runs the ticks after a fault until the joint rests and the bridge is off. Returns the travel,
/// deg, and the number of ticks with the bridge on.
fn after(device: &mut SimulatedDevice, fault: Fault) -> (f64, u32) {
    let from = device.position_deg();
    device.device.servo().fault(fault);
    let mut on = 0;
    for _ in 0..1000 {
        let output = device.tick();
        assert_eq!(output.state, State::Faulted(fault));
        assert_eq!((output.tick.code, output.brake()), (0, BrakeCommand::Closed), "{fault:?}");
        on += u32::from(output.enable);
    }
    assert_eq!(device.velocity_deg_per_s(), 0.0);
    ((device.position_deg() - from).abs(), on)
}

/// `J v' = -F - B v` from a speed (rad/s): the way to rest, rad.
fn way(speed: f64, viscous: f64) -> f64 {
    J / viscous * (speed - F / viscous * (viscous * speed / F).ln_1p())
}

/// The same after a time, s: way and speed.
fn after_time(speed: f64, viscous: f64, time_s: f64) -> (f64, f64) {
    let (end, decay) = (F / viscous, (-viscous * time_s / J).exp());
    let way = (speed + end) * J / viscous * (1.0 - decay) - end * time_s;
    (way, (speed + end) * decay - end)
}

#[test]
fn a_short_brake_and_a_coast_go_as_far_as_friction_and_back_emf_leave() {
    let speed = SPEED.to_radians();
    let shorted = B + K * K / R;
    for effort in EFFORTS {
        // The winding of the current loop has a time constant of 40 us: 1.6 rad/s for that time.
        let near = |found: f64, expected: f64| (found - expected.to_degrees()).abs() < 0.01;
        let (coasted, on) = after(&mut at_speed(effort, SPEED), Fault::Overrun);
        assert!(near(coasted, way(speed, B)) && on == 0, "{coasted} deg, {on} ticks");
        let (braked, on) = after(&mut at_speed(effort, SPEED), Fault::Overspeed);
        assert!(near(braked, way(speed, shorted)) && on == BRAKE, "{braked} deg, {on} ticks");
        assert!(braked < 0.5 * coasted, "{effort:?}: {braked}, {coasted} deg");
        // 30 ms of brake, and the joint coasts.
        let set = [effort, &["device.short_brake_s=0.03"]].concat();
        let (both, on) = after(&mut at_speed(&set, SPEED), Fault::Stall);
        let (first, left) = after_time(speed, shorted, 0.03);
        assert!(near(both, first + way(left, B)) && on == 30, "{both} deg, {on} ticks");
    }
}

/// The page has a column of the reactions. A silent link that is latched without a controlled stop
/// has a short brake.
#[test]
fn each_fault_has_the_reaction_of_its_row_on_the_page() {
    let page = include_str!("../../docs/reference/faults.md");
    for fault in Fault::ALL {
        let begins = format!("| {} | [", *fault as u8);
        let row = page.lines().find(|line| line.starts_with(&begins)).unwrap();
        let reaction = row.trim_end_matches(" |").rsplit(" | ").next().unwrap();
        let expected = match reaction.split_once(": ").unwrap().0 {
            "off" => 0,
            "short brake" | "controlled stop" => BRAKE,
            other => panic!("{fault:?}: {other}"),
        };
        for effort in EFFORTS {
            let (_, on) = after(&mut at_speed(effort, SPEED), *fault);
            assert_eq!(on, expected, "{fault:?}, {effort:?}");
        }
    }
}

#[test]
fn a_stop_a_clearing_and_a_fault_of_the_bridge_end_a_short_brake_at_once() {
    type End = fn(&mut SimulatedDevice);
    let ends: [(&str, End); 6] = [
        ("stop", |device| device.device.servo().come_to_rest()),
        ("clear", |device| device.device.servo().clear().unwrap()),
        ("break input", |device| device.device.servo().fault(Fault::BreakInput)),
        ("over-current", |device| device.device.servo().over_current(4000)),
        ("overrun", |device| device.device.servo().fault(Fault::Overrun)),
        ("emergency stop", |device| device.is_contact_open = true),
    ];
    for (name, end) in ends {
        let mut device = at_speed(&["device.emergency_stop=true"], SPEED);
        device.device.servo().fault(Fault::EncoderJump);
        for _ in 0..10 {
            assert!(device.tick().enable, "{name}");
        }
        // Another fault with a short brake neither ends nor prolongs it.
        device.device.servo().fault(Fault::Overspeed);
        assert!(device.tick().enable, "{name}");
        end(&mut device);
        assert!((0..BRAKE).all(|_| !device.tick().enable), "{name}");
        assert_eq!(device.device.servo().log().count(), 1, "{name}: the first one");
    }
}

/// A fault before the first duty: the driver still wakes up.
#[test]
fn a_joint_that_is_not_driven_has_no_short_brake() {
    let mut device = at_speed(&["device.wake_up_s=0.5"], 0.0);
    device.device.servo().stop();
    device.ticks(300);
    device.device.servo().arm_for_link(None).unwrap();
    assert!(device.tick().wakes);
    device.device.servo().fault(Fault::Overspeed);
    assert!(!device.tick().enable);
    device.device.servo().clear().unwrap();
    device.device.servo().fault(Fault::Overspeed);
    assert!(!device.tick().enable);
}

/// At 90 deg/s the back-EMF of 7.14 V has a current of 2.84 A.
#[test]
fn a_braking_current_beyond_its_peak_by_a_quarter_lets_the_joint_coast() {
    let current = K * SPEED.to_radians() / R;
    for effort in EFFORTS {
        for (peak, is_beyond) in [("2.0", true), ("2.5", false), ("off", false)] {
            let key = format!("current_sensor.peak_a={peak}");
            let mut device = at_speed(&[effort, &[key.as_str()]].concat(), SPEED);
            device.device.servo().fault(Fault::EncoderJump);
            assert!(device.tick().enable);
            let second = device.tick();
            assert_eq!(second.enable, !is_beyond, "{effort:?}, {peak}");
            // A tick of brake costs the speed (9.5 1.57 + 4.1) / 0.437 1 ms = 0.04 rad/s.
            let measured = f64::from(second.tick.current.abs());
            let slower = 0.05 * current;
            assert!((current - slower..current + STEP_A).contains(&measured), "{measured} A");
            let on = (0..BRAKE).filter(|_| device.tick().enable).count();
            assert_eq!(on, if is_beyond { 0 } else { BRAKE as usize - 2 }, "{effort:?}, {peak}");
        }
    }
}

/// A stop within 0.05 s from 50 deg/s takes 1.5 times 0.87 rad/s / 0.05 s of the inertia, 11.4 N m
/// less the friction of 4.1 N m and more: 1.6 A and less, and more as the joint trails.
#[test]
fn a_controlled_stop_keeps_the_limit_of_the_current() {
    for effort in EFFORTS {
        let most = |peak: &str| {
            let key = format!("current_sensor.peak_a={peak}");
            let keys = ["device.stop_s=0.05", "profile.velocity_deg_per_s=60", key.as_str()];
            let set = [effort, &keys].concat();
            let mut device = SimulatedDevice::new(&current_sensor(&["pd"], &set)[0]).unwrap();
            device.ticks(200);
            moves(&mut device, 90.0);
            while device.velocity_deg_per_s() < 50.0 {
                assert_eq!(heard(&mut device).state, State::Armed, "{effort:?}, {peak}");
            }
            device.device.servo().come_to_rest();
            let mut most: f64 = 0.0;
            while device.tick().enable {
                let of_periods = device.currents_a().iter().copied();
                most = of_periods.chain([device.current_a()]).fold(most, |a, b| a.max(b.abs()));
            }
            most
        };
        let (bounded, free) = (most("1.5"), most("off"));
        assert!(free > 1.2 * 1.5, "{effort:?}: {free} A without a limit");
        assert!(bounded < 1.1 * 1.5, "{effort:?}: {bounded} A");
    }
}

/// At zero volts the current ripples through zero, and the dead time takes nothing from the brake.
#[test]
fn a_short_brake_loses_nothing_by_the_dead_time_of_its_bridge() {
    let set = ["motor.dead_time_s=1e-6", "drive.mode=locked-antiphase", "drive.pwm_hz=20000"];
    let (braked, _) = after(&mut at_speed(&set, SPEED), Fault::Overspeed);
    let expected = way(SPEED.to_radians(), B + K * K / R).to_degrees();
    assert!((braked - expected).abs() < 0.01, "{braked} deg, not {expected} deg");
}

/// The heat is `K^2 int v^2 dt / tau`. Friction and winding take the energy of the joint:
/// `D int v^2 dt = J v^2 / 2 - F way`. The first tick is a whole one at the speed of the fault, 1
/// ms of 15 ms.
#[test]
fn the_current_of_a_short_brake_heats_the_winding_with_and_without_a_sensor() {
    let speed = SPEED.to_radians();
    let shorted = B + K * K / R;
    let squares = (0.5 * J * speed * speed - F * way(speed, shorted)) / shorted;
    let expected = (K * K * squares / 100.0).sqrt();
    for has_sensor in [true, false] {
        let mut device = at_speed(&["limits.thermal_s=100"], SPEED);
        if !has_sensor {
            let mut parameters = device.device.parameters().unwrap().clone();
            parameters.current = stiction::control::current_sensor::CurrentSensor::NONE;
            let plan = &current_sensor(&["pd"], &[])[0];
            let boot = stiction::servo::Boot::at_zero();
            device = SimulatedDevice::running(plan, &parameters, boot).unwrap();
            device.ticks(200);
            device.device.servo().arm_for_link(None).unwrap();
            (0..600).for_each(|_| assert_eq!(heard(&mut device).state, State::Armed));
            device.push(device.position_deg(), SPEED);
        }
        let before = f64::from(device.device.servo().thermal_effort());
        let (_, on) = after(&mut device, Fault::Overspeed);
        assert_eq!(on, BRAKE);
        let found = f64::from(device.device.servo().thermal_effort());
        assert!(before < 0.05 * expected, "{before} V before the fault");
        // The root of 1 ms of heat more or less, and cooling for 1 s of 100 s.
        let apart = found / expected - 1.0;
        assert!(apart.abs() < 0.05, "{has_sensor}: {found} V, not {expected} V");
    }
}
