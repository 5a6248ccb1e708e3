//! A stop, and a link that falls silent, while the joint moves: how far it goes on.
//!
//! The joint is the thesis's robot, in the middle of a step of 20 deg. Travel is true travel.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::servo::{Refusal, State};

use crate::dead_encoder::{armed_with, step};
use experiments::controllers;

/// Ticks of 20 ms in the default `stop_s`.
const STOP: u32 = 50;

/// Ticks until a silent link trips: 0.5 s.
const SILENT: u32 = 25;

/// How far the set point of a stop goes on from a speed, deg: `v^2 / 2 a`, with the acceleration of
/// the thesis's profile, or to rest within two thirds of a second.
fn set_point(speed: f64) -> f64 {
    0.5 * speed * speed / (1.5 * speed).max(35.555_56)
}

/// The joint brakes with its set point: friction shortens the way by up to a quarter, and the
/// measured speed is a tick or two old.
fn is_braked(travel: f64, speed: f64) -> bool {
    (0.7 * set_point(speed)..set_point(speed) + 0.06 * speed).contains(&travel)
}

/// A device in the middle of a step, and the joint's position and speed, deg and deg/s.
fn moving(law: &str, set: &[&str], ticks: u32) -> (SimulatedDevice, [f64; 2]) {
    let mut device = armed_with(law, 1.0, set);
    step(&mut device, 20.0);
    for _ in 0..ticks {
        device.device.servo().heard();
        assert_eq!(device.tick().state, State::Armed, "{law}");
    }
    let now = [device.position_deg(), device.velocity_deg_per_s()];
    (device, now)
}

/// Runs until the joint rests, and returns how far it went from `from`, and after how many ticks
/// the output was off.
fn rested(device: &mut SimulatedDevice, from: f64) -> (f64, u32) {
    let mut off = None;
    for tick in 1..1000 {
        let output = device.tick();
        if !output.enable && off.is_none() {
            off = Some(tick);
        }
        if off.is_some() && device.velocity_deg_per_s() == 0.0 {
            break;
        }
    }
    ((device.position_deg() - from).abs(), off.unwrap())
}

#[test]
fn a_stop_brakes_the_joint_before_the_output_is_off() {
    for law in controllers() {
        let (mut device, [from, speed]) = moving(law, &[], 30);
        device.device.servo().come_to_rest();
        assert!(device.device.servo().is_stopping(), "{law}: {speed} deg/s");
        let (travel, off) = rested(&mut device, from);
        let (mut coasts, [begin, _]) = moving(law, &["device.stop_s=0"], 30);
        coasts.device.servo().come_to_rest();
        let (coasted, at_once) = rested(&mut coasts, begin);
        reliability!(
            "controlled-stop",
            law,
            speed_deg_per_s = format!("{speed:.1}"),
            travel_deg = format!("{travel:.2}"),
            coasting_deg = format!("{coasted:.2}")
        );
        assert_eq!(device.device.servo().state(), State::Stopped, "{law}");
        assert!(off <= STOP && at_once == 1, "{law}: {off}, {at_once}");
        assert!(is_braked(travel, speed), "{law}: {travel} deg from {speed} deg/s");
        assert!(travel < 0.5 * coasted, "{law}: {travel} deg, without brakes {coasted} deg");
    }
}

#[test]
fn a_link_that_falls_silent_brakes_the_joint_and_is_a_fault() {
    for law in controllers() {
        let (mut device, _) = moving(law, &[], 8);
        let mut from = device.position_deg();
        let mut speed = 0.0;
        for _ in 0..SILENT {
            (from, speed) = (device.position_deg(), device.velocity_deg_per_s());
            assert_eq!(device.tick().state, State::Armed, "{law}");
        }
        let (travel, off) = rested(&mut device, from);
        assert!(is_braked(travel, speed), "{law}: {travel} deg from {speed} deg/s");
        assert!(off <= STOP + 1, "{law}: {off}");
        let servo = device.device.servo();
        assert_eq!(servo.state(), State::Faulted(Fault::LinkTimeout), "{law}");
        assert_eq!(servo.log().count(), 1, "{law}");
    }
}

#[test]
fn a_second_stop_is_at_once_and_nothing_moves_a_joint_that_stops() {
    let (mut device, _) = moving("pd", &[], 30);
    device.device.servo().come_to_rest();
    device.tick();
    let servo = device.device.servo();
    assert_eq!(servo.arm(), Err(Refusal::Stopping));
    assert_eq!(servo.arm_for_link(None), Err(Refusal::Stopping));
    assert_eq!(servo.hold(), Err(Refusal::Stopping));
    assert_eq!(servo.state(), State::Armed);
    servo.come_to_rest();
    assert!(servo.state() == State::Stopped && !servo.is_stopping());
    assert!(!device.tick().enable);
}

/// A joint that rests is let go at once, and so is an open loop.
#[test]
fn what_does_not_move_in_a_closed_loop_is_turned_off_at_once() {
    let mut device = armed_with("pd", 1.0, &[]);
    device.ticks(10);
    device.device.servo().come_to_rest();
    assert_eq!(device.device.servo().state(), State::Stopped);
    let jog = device.device.parameters().unwrap().jog(&Default::default()).unwrap();
    device.ticks(10);
    device.device.servo().jog(jog).unwrap();
    while device.velocity_deg_per_s() == 0.0 {
        device.device.servo().heard();
        device.tick();
    }
    device.device.servo().come_to_rest();
    assert_eq!(device.device.servo().state(), State::Stopped);
}

/// A fault that is not of the link lets the joint coast, also while it stops.
#[test]
fn another_fault_ends_a_stop_at_once() {
    let (mut device, _) = moving("pd", &[], 30);
    device.device.servo().come_to_rest();
    device.tick();
    device.device.servo().fault(Fault::BreakInput);
    let output = device.tick();
    assert!(!output.enable && output.state == State::Faulted(Fault::BreakInput));
    // The encoder's wires are cut while it brakes.
    let (mut device, [from, _]) = moving("pd", &[], 30);
    device.wires = Wires::Cut;
    device.device.servo().come_to_rest();
    let (_, off) = rested(&mut device, from);
    assert!(off < 4, "{off}");
    assert_eq!(device.device.servo().state(), State::Faulted(Fault::Stall));
}
