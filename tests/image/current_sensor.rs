//! The motor's current in the image: the timer triggers its conversion, the tick reads it, and the
//! converter's watchdog turns the bridge off.
//!
//! Blind to the noise of a switching bridge, to the time constant of an amplifier, and to the line
//! from the timer to the converter, which the emulated board adds.

use emulator::board_under_test::BoardUnderTest;
use emulator::bridge::BridgeInputs;

use experiments::current_sensor::current_sensor;
use simulator::device::parameters;
use simulator::device::simulated::{MotorWires, ShuntState};
use simulator::experiment::RunPlan;
use simulator::shunt::Shunt;
use stiction::{Fault, Parameters, Tick};

use crate::side_by_side::{self, ARMED, armed, is_armed, ticks};

/// A step under a limit of the current that acts, 0.3 s after power-on.
const SET: [&str; 8] = [
    "reference.steps_deg=[5.0]",
    "reference.trajectories=[]",
    "device.autostart=true",
    "device.autostart_after_dip=true",
    "device.autostart_delay_s=0.3",
    "device.soft_start_s=0.02",
    "current_sensor.peak_a=1.5",
    "limits.link_timeout_s=off",
];

/// Period of the PWM, ns.
const PERIOD_NS: u64 = 1_000_000_000 / 22_000;

fn plan(law: &str, set: &[&str]) -> (RunPlan, Parameters) {
    let plan = current_sensor(&[law], &[&SET[..], set].concat()).remove(0);
    let parameters = parameters(&plan).unwrap();
    (plan, parameters)
}

/// The effort depends on the measured current, from the first tick that the limit cuts.
#[test]
fn a_current_is_measured_and_limited_as_on_a_simulated_device_bit_for_bit() {
    for (law, set) in [
        ("robust", &[][..]),
        ("pd", &["motor.inductance_h=0.0126", "current_sensor.direction=reverse"]),
        // The current exceeds its limit: the winding has less resistance than the sensor's table.
        ("srnf", &["current_sensor.resistance_ohm=3.5"]),
    ] {
        let (plan, parameters) = plan(law, set);
        let mut board = side_by_side::board(&plan, &parameters);
        let mut device = side_by_side::device(&plan, &parameters);
        let (mut there, mut here) = armed(&mut board, &mut device);
        let (mut cut, mut farthest) = (0, 0);
        for tick in 0..400 {
            assert_eq!(there, here, "{law} {set:?}, tick {tick}");
            assert!(is_armed(&here), "{law} {set:?}, tick {tick}: {here:?}");
            cut += u32::from(here.saturated);
            farthest = farthest.max(here.counts);
            (there, here) = ticks(&mut board, &mut device);
        }
        assert!(cut > 20 && farthest > 500, "{law}: {cut} ticks, {farthest} counts");
    }
}

#[test]
fn a_shorted_wire_turns_the_bridge_off_within_a_period_of_the_pwm() {
    let (plan, parameters) = plan("robust", &[]);
    let mut board = side_by_side::board(&plan, &parameters);
    while !board.samples(1).unwrap().bridge.is_on() {}
    board.samples(30).unwrap();
    board.act(|halted| halted.plant().motor_wires = MotorWires::Shorted).unwrap();
    // The end of this sample has the current on the pin. A conversion comes within a period, and
    // takes 1.3 us.
    assert!(board.samples(1).unwrap().bridge.is_on());
    let now = |board: &mut BoardUnderTest| board.act(|halted| halted.now()).unwrap();
    let from_ns = now(&mut board);
    let current_a = board.act(|halted| halted.plant().current_a()).unwrap();
    assert!(current_a.abs() > 27.0, "{current_a} A");
    while board.act(|halted| BridgeInputs::read(halted.board()).is_on()).unwrap() {
        board.pass(500).unwrap();
        assert!(now(&mut board) < from_ns + PERIOD_NS + 2_500, "still on");
    }
    board.samples(1).unwrap();
    let tick = board.act(|halted| halted.last_tick()).unwrap().unwrap();
    assert_eq!(tick.status & 0xFFFF, 3 | (Fault::OverCurrent as u32) << 8);
}

#[test]
fn failures_of_wires_and_sensor_are_the_same_faults_as_on_a_simulated_device() {
    for (wires, sensor) in [
        (MotorWires::Shorted, ShuntState::Sound),
        (MotorWires::Open, ShuntState::Sound),
        (MotorWires::Sound, ShuntState::Reversed),
        (MotorWires::Sound, ShuntState::Stuck(3300)),
        (MotorWires::Sound, ShuntState::Stuck(1650)),
    ] {
        let set = ["device.dead_time_s=1e-7", "current_sensor.peak_a=13"];
        let (plan, parameters) = plan("robust", &set);
        let mut device = side_by_side::device(&plan, &parameters);
        while !device.tick().enable {}
        device.ticks(30);
        device.motor_wires = wires;
        device.shunt.as_mut().unwrap().state = sensor;
        let mut board = side_by_side::board(&plan, &parameters);
        while !board.samples(1).unwrap().bridge.is_on() {}
        board.samples(30).unwrap();
        let fail = board.act(move |halted| {
            halted.plant().motor_wires = wires;
            halted.harness.coupling.plant.shunt.as_mut().unwrap().state = sensor;
        });
        fail.unwrap();
        // The sample of the emulated board that has just begun has the old current on its pin.
        let ends = |tick: &Tick| !is_armed(tick);
        let here = (0..200i32).find_map(|tick| {
            let output = device.tick().tick;
            ends(&output).then_some((tick, output.status >> 8 & 0xFF))
        });
        let there = (0..200i32).find_map(|tick| {
            board.samples(1).unwrap();
            let output = board.act(|halted| halted.last_tick()).unwrap().unwrap();
            ends(&output).then_some((tick, output.status >> 8 & 0xFF))
        });
        let (here, there) = (here.unwrap(), there.unwrap());
        assert_eq!(there.1, here.1, "{wires:?}, {sensor:?}");
        assert!(there.0.abs_diff(here.0) <= 1, "{wires:?}, {sensor:?}: {there:?}, {here:?}");
    }
}

/// The automatic start comes 0.3 s after power-on. A fiftieth of the range are 33 mV on average.
#[test]
fn a_noisy_sensor_is_a_fault_of_the_automatic_start_as_on_a_simulated_device() {
    for (mv, expected) in [(30, ARMED), (75, 3 | (Fault::CurrentSensor as u32) << 8)] {
        let (plan, parameters) = plan("robust", &[]);
        let mut device = side_by_side::device(&plan, &parameters);
        device.shunt.as_mut().unwrap().state = ShuntState::Noisy(mv);
        let mut board = side_by_side::board(&plan, &parameters);
        let set = move |shunt: &mut Shunt| shunt.state = ShuntState::Noisy(mv);
        board.act(move |halted| halted.harness.coupling.plant.shunt.as_mut().map(set)).unwrap();
        let here = device.ticks(400).tick.status;
        board.samples(400).unwrap();
        let there = board.act(|halted| halted.last_tick()).unwrap().unwrap().status;
        assert_eq!((here & 0xFFFF, there & 0xFFFF), (expected, expected), "{mv} mV");
    }
}

/// The file has three times the resistance of the winding: a current is three times the expected
/// one, and more than twice of it with 0.2 A. Its lag of 20 ms and the 20 ms of the condition are
/// 40 ticks, and the soft start is 20.
#[test]
fn a_winding_with_a_third_of_its_resistance_is_too_much_current_as_on_a_simulated_device() {
    let set = [
        "load.constant_nm=-4.5",
        "current_sensor.resistance_ohm=7.53",
        "current_sensor.full_scale_a=10",
        "current_sensor.peak_a=2.5",
    ];
    let (plan, parameters) = plan("robust", &set);
    let mut board = side_by_side::board(&plan, &parameters);
    let mut device = side_by_side::device(&plan, &parameters);
    let (mut there, mut here) = armed(&mut board, &mut device);
    let mut passed = 0;
    while is_armed(&here) && passed < 100 {
        assert_eq!(there, here, "tick {passed}");
        (there, here) = ticks(&mut board, &mut device);
        passed += 1;
    }
    assert_eq!((there, here.status >> 8 & 0xFF), (here, Fault::MotorShorted as u32));
    assert!((20..=60).contains(&passed), "{passed} ticks");
}
