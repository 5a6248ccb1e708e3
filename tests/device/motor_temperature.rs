//! The motor's NTC: what it measures, its two faults, and how it corrects the modelled heat.
//!
//! The simulated NTC has the winding's temperature at once, or one that the test sets.

use experiments::controllers;
use simulator::device::simulated::SimulatedDevice;
use simulator::motor_ntc::NtcState;
use stiction::Fault;
use stiction::servo::{Refusal, State};

use crate::dead_encoder::{armed_with, step};
use crate::fixture::plans;

/// An NTC of 10 kOhm in a winding of 120 deg C at most, whose rated current is for 20 deg C.
const NTC: [&str; 3] =
    ["motor_ntc.resistance_25_ohm=10000", "motor_ntc.limit_c=120", "motor_ntc.ambient_c=20"];
const LIMIT_C: f64 = 120.0;

/// Ticks of 20 ms in a mean of 0.1 s.
const MEAN: u32 = 5;

const HOT: State = State::Faulted(Fault::MotorHot);
const SENSOR: State = State::Faulted(Fault::MotorSensor);

/// A device at rest, after two means.
fn at_rest(set: &[&str]) -> SimulatedDevice {
    let plan = &plans("step-response", &[&NTC, set].concat())[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.ticks(2 * MEAN);
    device
}

/// Lets the sensor be in a state for a time, ticks; the link goes on talking.
fn pass(device: &mut SimulatedDevice, state: NtcState, ticks: u32) -> State {
    device.ntc.as_mut().unwrap().state = state;
    for _ in 0..ticks {
        device.device.servo().heard();
        device.tick();
    }
    device.device.servo().state()
}

/// A millivolt of the pin is 0.04 K at 25 deg C and 0.16 K at 120 deg C, and a step of the
/// converter is 0.8 mV.
#[test]
fn the_measured_temperature_is_that_of_the_ntc() {
    let mut device = at_rest(&[]);
    for celsius in [-10.0, 25.0, 60.0, 115.0] {
        assert_eq!(pass(&mut device, NtcState::At(celsius), 2 * MEAN), State::Stopped);
        let found = f64::from(device.device.servo().motor_temperature().unwrap());
        assert!((found - celsius).abs() < 0.3, "{celsius} C: {found}");
    }
    pass(&mut device, NtcState::Open, 2 * MEAN);
    assert_eq!(device.device.servo().motor_temperature(), None);
}

#[test]
fn a_motor_beyond_its_limit_is_off_within_a_fifth_of_a_second_under_every_law() {
    for law in controllers() {
        let mut device = armed_with(law, 1.0, &[&NTC[..], &["limits.continuous_v=off"]].concat());
        step(&mut device, 5.0);
        let warm = pass(&mut device, NtcState::At(LIMIT_C - 1.0), 4 * MEAN);
        assert_eq!(warm, State::Armed, "{law}");
        assert_eq!(pass(&mut device, NtcState::At(LIMIT_C + 1.0), 2 * MEAN), HOT, "{law}");
        assert!(!device.tick().enable, "{law}");
    }
}

#[test]
fn a_hot_motor_cannot_be_armed_until_it_is_cool() {
    let mut device = at_rest(&[]);
    assert_eq!(pass(&mut device, NtcState::At(LIMIT_C + 1.0), 2 * MEAN), HOT);
    device.device.servo().clear().unwrap();
    let arm = |device: &mut SimulatedDevice| device.device.servo().arm_for_link(None);
    assert_eq!(arm(&mut device), Err(Refusal::WouldTrip(Fault::MotorHot)));
    assert_eq!(pass(&mut device, NtcState::At(LIMIT_C + 1.0), 2 * MEAN), HOT, "it is still hot");
    pass(&mut device, NtcState::At(LIMIT_C - 1.0), 2 * MEAN);
    device.device.servo().clear().unwrap();
    assert_eq!(pass(&mut device, NtcState::At(LIMIT_C - 1.0), 2 * MEAN), State::Stopped);
    assert_eq!(arm(&mut device), Ok(()));
    device.device.servo().stop();
    // The first mean with an open sensor is no fault yet.
    assert_eq!(pass(&mut device, NtcState::Open, 2 * MEAN), State::Stopped);
    assert_eq!(arm(&mut device), Err(Refusal::WouldTrip(Fault::MotorSensor)));
}

#[test]
fn an_open_and_a_shorted_sensor_are_faults_and_a_disturbance_is_none() {
    for state in [NtcState::Open, NtcState::Shorted] {
        let mut device = at_rest(&[]);
        // Three means in a row are a fault. Each disturbance has one or two of them: the first may
        // begin with other readings.
        for _ in 0..3 {
            pass(&mut device, state, 2 * MEAN);
            assert_eq!(pass(&mut device, NtcState::Sound, 2 * MEAN), State::Stopped, "{state:?}");
        }
        assert_eq!(pass(&mut device, state, 4 * MEAN), SENSOR, "{state:?}");
    }
}

/// The coldest and the hottest one that the divider of the parameters can be used for.
#[test]
fn an_intact_sensor_at_the_ends_of_its_range_is_no_open_or_shorted_one() {
    // A step of the converter is 3 K at the ends. R(-20 C) / 511 and 511 R(120 C) of this NTC:
    // 206.2 ohm and 207.9 kOhm.
    for (divider, celsius) in [("207", -20.0), ("207000", LIMIT_C - 10.0)] {
        let mut device = at_rest(&[&format!("motor_ntc.divider_ohm={divider}")]);
        let state = pass(&mut device, NtcState::At(celsius), 8 * MEAN);
        assert_eq!(state, State::Stopped, "{divider} ohm");
    }
}

/// A blocked joint trips after `tau ln((V^2 - h) / (V^2 - c^2))`, where h is the heat that it has
/// from the beginning on: here the part (T - 20) / 100 of c^2 that its NTC shows. The vibration of
/// 4 counts is that of heat.rs.
#[test]
fn a_motor_that_is_warm_when_power_returns_has_less_time_for_an_overload() {
    let set =
        [&NTC[..], &["limits.continuous_v=0.5", "limits.breakaway_v=0.7", "device.soft_start_s=0"]]
            .concat();
    for celsius in [20.0, 70.0, 95.0] {
        let mut device = armed_with("pd", 1.0, &set);
        pass(&mut device, NtcState::At(celsius), 2 * MEAN);
        // From here on the sensor is too slow to show what happens.
        device.ntc.as_mut().unwrap().state = NtcState::At(20.0);
        device.brake_v = 100.0;
        step(&mut device, 0.7);
        let ticks = (0..3000).find(|k| {
            device.device.servo().heard();
            device.jump(if k % 2 == 0 { 4 } else { -4 });
            device.tick().state == State::Faulted(Fault::Overheat)
        });
        let (most, effort) = (0.5f64.powi(2), 0.695f64.powi(2));
        let heat = most * (celsius - 20.0) / (LIMIT_C - 20.0);
        let expected = 10.0 / 0.02 * ((effort - heat) / (effort - most)).ln();
        let found = f64::from(ticks.unwrap());
        assert!((found / expected - 1.0).abs() < 0.03, "{celsius} C: {found}, not {expected}");
    }
}

/// It has come off its place, and shows the room.
#[test]
fn a_cold_sensor_does_not_cool_the_model() {
    let heat = |set: &[&str], state| {
        let mut device = armed_with("pd", 1.0, &[&["limits.continuous_v=4"], set].concat());
        step(&mut device, 5.0);
        (0..50).for_each(|_| {
            device.device.servo().heard();
            if let (Some(ntc), Some(state)) = (&mut device.ntc, state) {
                ntc.state = state;
            }
            device.tick();
        });
        device.device.servo().thermal_effort().to_bits()
    };
    assert_eq!(heat(&NTC, Some(NtcState::At(-10.0))), heat(&[], None));
}
