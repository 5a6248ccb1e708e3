//! A law that holds effort at rest: what is rest, what is a warning, what is a stall, and what is
//! heat.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::servo::{Output, State};

use crate::dead_encoder::{EXACT, armed, step};
use crate::fixture::plans;
use experiments::controllers;

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// Runs with a client until the servo is no longer armed; returns the ticks, the tick
/// of the first warning, and the last output.
fn held(device: &mut SimulatedDevice, ticks: u32) -> (u32, Option<u32>, Output) {
    let mut warned = None;
    let mut output = device.tick();
    let mut tick = 1;
    while tick < ticks && output.state == State::Armed {
        device.device.servo().heard();
        output = device.tick();
        tick += 1;
        warned = warned.or(output.wound_up.then_some(tick));
    }
    (tick, warned, output)
}

#[test]
fn effort_that_a_law_holds_or_hunts_with_at_rest_is_no_fault_for_ten_minutes() {
    for law in controllers() {
        for target in [0.02, 0.39, 1.0, 5.0] {
            let mut device = armed(law);
            step(&mut device, target);
            let (_, _, output) = held(&mut device, 10 * MINUTE);
            assert_eq!(output.state, State::Armed, "{law}, {target} deg");
        }
    }
}

/// An integral against a joint that is held fast, with an error of 0.05 deg (21 counts).
fn wound(set: &[&str]) -> SimulatedDevice {
    let set = [&["loop.controller=ri", "reference.steps_deg=[5.0]", EXACT], set].concat();
    let mut device = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
    device.ticks(50);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    device.brake_v = 100.0;
    step(&mut device, 0.05);
    device
}

#[test]
fn a_warning_a_stall_and_heat_are_distinguished() {
    // v_c = 4 V/(deg s) 0.0508 deg t = 0.203 V/s t; PD adds 0.051 V.
    let (rate, pd) = (0.203, 0.051);
    // The warning: 0.4 V of the law for a second. The stall: after the 0.4 V of the breakaway an
    // impulse of 0.2 V s, 0.05 V of it as long as it is less, then the square of the time.
    let (tick, warned, output) = held(&mut wound(&[]), MINUTE);
    let (seen, warned_s) = (f64::from(tick) * 0.02, f64::from(warned.unwrap()) * 0.02);
    assert!((warned_s - (0.4 / rate + 1.0)).abs() < 0.05, "{warned_s} s");
    let beyond = (2.0 * rate * (0.2 - 0.05 * 0.05 / rate) + 0.05 * 0.05f64).sqrt();
    let stalls = (0.4 + beyond - pd) / rate;
    assert_eq!(output.state, State::Faulted(Fault::Stall));
    assert!((seen - stalls).abs() < 0.1, "{seen} s of {stalls}");
    // Heat alone: the effort squared through a lag of 10 s, against 3.75 V squared.
    let (tick, warned, output) = held(&mut wound(&["limits.stall_v=0"]), MINUTE);
    let (mut heat, mut heats) = (0.0, 0.0);
    while heat < 3.75 * 3.75 {
        heats += 0.02;
        let effort = f64::min(pd + rate * heats, 5.0);
        heat += (effort * effort - heat) * 0.02 / 10.0;
    }
    let seen = f64::from(tick) * 0.02;
    assert_eq!(output.state, State::Faulted(Fault::Overheat));
    assert!(warned.is_some() && (seen - heats).abs() < 0.2, "{seen} s of {heats}");
}

/// The largest friction (in hundredths of the file's) at which no run of the thesis's steps
/// and trajectories trips for a minute, while every run at less friction passes, too.
fn borne(law: &str) -> u32 {
    let controller = format!("loop.controller={law}");
    let passes = |hundredths: u32| {
        let all = ["step-response", "trajectory"].map(|name| plans(name, &[&controller]));
        all.iter().flatten().filter(|plan| plan.variant.is_empty()).all(|plan| {
            let mut device = SimulatedDevice::new(plan).unwrap();
            device.ticks(10);
            device.brake_v = 0.4 * f64::from(hundredths) / 100.0;
            device.device.servo().arm().unwrap();
            let output = device.ticks(MINUTE);
            assert!(matches!(output.state, State::Armed | State::Faulted(Fault::Stall)));
            output.state == State::Armed
        })
    };
    (1..20).map(|twentieth| 5 * twentieth).take_while(|more| passes(*more)).last().unwrap_or(0)
}

#[test]
fn friction_above_the_files_is_borne_by_an_integral_to_a_tenth_and_trips_at_twice_of_it() {
    for law in controllers() {
        let more = borne(law);
        reliability!("borne", law, more);
        // An integral goes on until the joint moves. A law that holds a little more than the
        // breakaway would hold it for ever: that is a stall, be the joint rusty or the wire cut.
        let expected = match law {
            "ri" | "rvi" | "roi" => 10..50,
            "dnpf" => 0..5,
            _ => 5..100,
        };
        assert!(expected.contains(&more), "{law}: {more} %");
    }
}
