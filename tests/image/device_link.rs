//! A client of the image on the emulated board, through the board's own USART: the same answers,
//! and the same motion to the bit, as of a device that is simulated in process.

use std::time::Duration;

use emulator::fault_injection::Injection;
use emulator::wire::EmulatedWire;
use simulator::device;
use simulator::device::client::Client;
use simulator::device::log::SampleLog;
use simulator::device::signals::Signals;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::RunPlan;
use stiction::Fault;
use stiction::link::{DeviceKind, Sample, StateCode};
use stiction::motion::jog::Verdict;

use crate::common::{firmware, plans};
use crate::first_run::jogged;

fn plan(law: &str, set: &[&str]) -> RunPlan {
    plans("step-response", &[law], &[&["drive.pwm_hz=2000"], set].concat()).remove(0)
}

fn emulated(plan: &RunPlan) -> Client<EmulatedWire> {
    Client::connect(EmulatedWire::with(&firmware(), plan).unwrap()).unwrap()
}

/// What the device announces, and every signal of every tick of a move.
fn samples<W: Wire>(client: &mut Client<W>) -> (Signals, Vec<Sample>) {
    let signals = Signals::new(client.signals().unwrap());
    client.arm().unwrap();
    client.subscribe(signals.mask(signals.names()), 1).unwrap();
    client.step_to(2.5).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let mut samples = Vec::new();
    while let Some(sample) = client.sample(Duration::ZERO).unwrap() {
        samples.push(sample);
    }
    assert_eq!(client.lost(), 0);
    (signals, samples)
}

#[test]
fn a_move_is_that_of_the_simulated_device_to_the_bit() {
    let wired_otherwise =
        ["encoder.direction=\"reverse\"", "drive.mode=sign-magnitude", "run.delay_samples=1"];
    for (law, set) in [("srnf", &[][..]), ("ri", &[]), ("dnpf", &wired_otherwise)] {
        let plan = plan(law, set);
        let simulated = SimulatedWire::new(SimulatedDevice::new(&plan).unwrap());
        let (announced, here) = samples(&mut Client::connect(simulated).unwrap());
        let (signals, there) = samples(&mut emulated(&plan));
        assert_eq!(signals, announced, "{law}");
        // 3 s of 20 ms, and the tick in which the last answer was waited for.
        let count = here.len().min(there.len());
        assert!(
            (150..=152).contains(&count) && here.len().abs_diff(there.len()) <= 1,
            "{law}: {count}"
        );
        let since = there[0].clock - here[0].clock;
        for (here, there) in here.iter().zip(&there) {
            let there = Sample { clock: there.clock - since, ..there.clone() };
            assert_eq!(here, &there, "{law}, tick {}", here.clock);
        }
        let csv = |samples: &[Sample]| {
            let mut log = SampleLog::new(signals.clone(), &[]).unwrap();
            samples.iter().take(count).cloned().for_each(|sample| log.push(sample));
            String::from_utf8(log.render(0.02, 0.00242).unwrap()).unwrap()
        };
        assert_eq!(csv(&here), csv(&there), "{law}");
        assert!(csv(&here).lines().count() > 150);
    }
}

#[test]
fn it_says_what_it_is_and_without_a_stop_time_it_stops_at_once() {
    let mut client = emulated(&plan("pd", &["device.stop_s=0"]));
    let identity = client.identity().unwrap();
    assert_eq!((identity.kind, &*identity.version), (DeviceKind::Board, stiction::VERSION));
    assert_eq!(client.wire().warning(), Some("EMULATED DEVICE: no motor moves or stops."));
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    client.arm().unwrap();
    client.step_to(20.0).unwrap();
    client.pass(Duration::from_millis(400)).unwrap();
    let board = &mut client.wire().board;
    assert!(board.samples(1).unwrap().bridge.is_on());
    let begin = board.act(|halted| halted.now()).unwrap();
    client.stop().unwrap();
    let board = &mut client.wire().board;
    board.samples(2).unwrap();
    let on = board
        .act(|halted| halted.harness.spans.on_ns.last().map(|[_, until]| *until))
        .unwrap()
        .unwrap();
    // A tick of 20 ms, and what the request takes on the wire.
    assert!((begin..begin + 21_000_000).contains(&on), "on until {on}, asked at {begin}");
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
}

/// Counts that the joint goes on after a stop in the middle of a step.
fn stopping_distance<W: Wire>(client: &mut Client<W>) -> i32 {
    client.arm().unwrap();
    client.step_to(20.0).unwrap();
    let before = client.pass(Duration::from_millis(500)).unwrap();
    assert!(before.state == StateCode::Armed && !before.at_rest);
    client.stop().unwrap();
    let after = client.status().unwrap();
    assert_eq!(after.state, StateCode::Stopped);
    after.position - before.position
}

/// `tests/device/controlled_stop.rs` has the bounds of the simulated device.
#[test]
fn a_stop_brakes_the_joint_as_in_the_simulated_device() {
    let distance = |set: &[&str]| {
        let plan = plan("pd", set);
        let simulated = SimulatedWire::new(SimulatedDevice::new(&plan).unwrap());
        let here = stopping_distance(&mut Client::connect(simulated).unwrap());
        (f64::from(here), f64::from(stopping_distance(&mut emulated(&plan))))
    };
    let (here, there) = distance(&[]);
    // A request takes its time on the wire, so the stop may come a tick of 0.8 deg later.
    assert!((here - there).abs() < 0.8 / 0.00242, "{here} and {there} counts");
}

#[test]
fn parameters_go_there_and_back_but_not_into_its_flash() {
    let mut client = emulated(&plan("srnf", &[]));
    // In flash nothing arms by itself; else it is what the machine's file says.
    assert_eq!(client.parameters().unwrap(), device::parameters(&plan("srnf", &[])).unwrap());
    let other = device::parameters(&plan("pd", &["loop.sample_time_s=0.001"])).unwrap();
    client.set_parameters(&other).unwrap();
    assert_eq!(client.parameters().unwrap(), other);
    let status = client.status().unwrap();
    assert!(status.unsaved && status.sample_time == 0.001, "{status:?}");
    let refusal = client.save().unwrap_err().to_string();
    assert!(refusal.contains("(the emulator models no contents of the flash)"), "{refusal}");
    // It ticks at the new sample time: 100 ms are a hundred ticks.
    let before = client.status().unwrap().clock;
    client.pass(Duration::from_millis(100)).unwrap();
    let ticks = client.status().unwrap().clock - before;
    assert!((100..=106).contains(&ticks), "{ticks}");
}

#[test]
fn a_stall_is_cleared_a_jog_proves_the_encoder_and_a_reset_ends_the_session() {
    let mut client = emulated(&plan("pd", &[]));
    client.arm().unwrap();
    client.wire().board.act(|halted| halted.plant().brake_v = 100.0).unwrap();
    client.step_to(4.0).unwrap();
    let status = client.pass(Duration::from_millis(1_500)).unwrap();
    assert_eq!(status.fault.code, Fault::Stall as u8);
    assert!(client.arm().unwrap_err().to_string().contains("stall"));
    assert_eq!(client.faults().unwrap().len(), 1);
    client.clear().unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    assert!(client.arm().unwrap_err().to_string().contains("in doubt"));
    client.wire().board.act(|halted| halted.plant().brake_v = 0.0).unwrap();
    assert_eq!(jogged(&mut client).unwrap().verdict(), Verdict::Agrees);
    client.arm().unwrap();
    let board = &mut client.wire().board;
    // The one that was under way, and the first one armed.
    assert!(board.samples(2).unwrap().bridge.is_on());
    board.act(|halted| halted.inject(Injection::Reset)).unwrap();
    board.pass(100_000_000).unwrap();
    let refusal = client.status().unwrap_err().to_string();
    assert!(refusal.contains("the device was reset"), "{refusal}");
    // Not the fault before, which has been cleared.
    let mut client = Client::connect(client.end()).unwrap();
    assert_eq!(client.status().unwrap().fault.code, Fault::ResetWhileArmed as u8);
}
