//! The current loop in the image: the converter's interrupt runs it once a period of the PWM, above
//! the control task.
//!
//! Blind to the noise of a switching bridge, and to the line from the timer to the converter, which
//! the emulated board adds.

use emulator::wire::EmulatedWire;
use experiments::current_sensor::current_sensor;
use simulator::device::client::Client;
use simulator::device::parameters;
use simulator::experiment::RunPlan;
use stiction::Parameters;
use stiction::control::controller::EffortMode;
use stiction::link::StateCode;

use crate::common::firmware;
use crate::side_by_side::{self, armed, is_armed, ticks};

/// A step by a current loop, 0.3 s after power-on.
const SET: [&str; 9] = [
    "loop.effort=current",
    "drive.pwm_hz=21000",
    "reference.steps_deg=[5.0]",
    "reference.trajectories=[]",
    "device.autostart=true",
    "device.autostart_after_dip=true",
    "device.autostart_delay_s=0.3",
    "device.soft_start_s=0.02",
    "limits.link_timeout_s=off",
];

fn plan(law: &str, set: &[&str]) -> (RunPlan, Parameters) {
    let plan = current_sensor(&[law], &[&SET[..], set].concat()).remove(0);
    let parameters = parameters(&plan).unwrap();
    (plan, parameters)
}

/// Position, effort and measured current depend on every duty of every period.
#[test]
fn an_image_with_a_current_loop_does_what_a_simulated_device_does_bit_for_bit() {
    for (law, set) in [
        ("robust", &["motor.inductance_h=0.001255"][..]),
        ("pd", &["motor.inductance_h=0.0126", "current_sensor.direction=reverse"]),
        ("srnf", &["motor.inductance_h=0.001255", "current_sensor.peak_a=1.5"]),
    ] {
        let (plan, parameters) = plan(law, set);
        let mut board = side_by_side::board(&plan, &parameters);
        let mut device = side_by_side::device(&plan, &parameters);
        let (mut there, mut here) = armed(&mut board, &mut device);
        let (mut farthest, mut most) = (0, 0.0f32);
        for tick in 0..400 {
            assert_eq!(there, here, "{law} {set:?}, tick {tick}");
            assert!(is_armed(&here), "{law} {set:?}, tick {tick}: {here:?}");
            farthest = farthest.max(here.counts);
            most = most.max(here.current.abs());
            (there, here) = ticks(&mut board, &mut device);
        }
        assert!(farthest > 500 && most > 1.0, "{law}: {farthest} counts, {most} A");
    }
}

/// ADC1's CR1. In it: the end of a conversion of the current is an interrupt.
const ADC1_CR1: u64 = 0x4001_2004;
const CONVERTED: u32 = 1 << 7;

/// From current to voltage and back over the link, with a stop at speed between.
#[test]
fn what_an_effort_is_may_change_at_run_time_and_a_motion_begins_anew() {
    let set = ["loop.effort=current", "drive.pwm_hz=21000", "motor.inductance_h=0.001255"];
    let regulated = current_sensor(&["robust"], &set).remove(0);
    let current = parameters(&regulated).unwrap();
    let mut voltage = current.clone();
    voltage.controller.effort = EffortMode::Voltage;
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &regulated).unwrap()).unwrap();
    let deg = |client: &mut Client<EmulatedWire>| {
        client.wire().board.act(|halted| halted.plant().position_deg()).unwrap()
    };
    for of in [&current, &voltage, &current, &current] {
        client.set_parameters(of).unwrap();
        for stops_at_speed in [false, true] {
            client.wire().board.samples(200).unwrap();
            client.arm().unwrap();
            let from = deg(&mut client);
            client.move_to(5.0).unwrap();
            let mut moved = 0.0;
            for _ in 0..150 {
                client.wire().board.samples(10).unwrap();
                let status = client.status().unwrap();
                assert_eq!(status.state, StateCode::Armed, "{:?}", status.fault);
                moved = deg(&mut client) - from;
                if stops_at_speed && moved > 2.5 {
                    break;
                }
            }
            assert!(stops_at_speed || (moved - 5.0).abs() < 0.01, "{moved} deg");
            let control = client.wire().board.act(|halted| halted.register(ADC1_CR1)).unwrap();
            let is_regulated = control.unwrap() & CONVERTED != 0;
            assert_eq!(is_regulated, of.controller.effort == EffortMode::Current);
            client.stop().unwrap();
        }
    }
}
