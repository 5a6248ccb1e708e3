//! Homing in the image: it finds the stop as a simulated device does, and one that is ended leaves
//! no zero.

use std::time::Duration;

use emulator::wire::EmulatedWire;
use experiments::axis_with_stops::{COUNT_DEG, axis_with_stops};
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::RunPlan;
use stiction::link::Status;
use stiction::motion::home::{HomeEnd, HomeFindings, HomeRequest, Sense};

use crate::common::{firmware, plans};

const STOP_DEG: f64 = 1.5;

/// The position that is asked for at the stop, counts.
const AT: i32 = 4000;

const UP: HomeRequest =
    HomeRequest { sense: Sense::Plus, at: AT, effort: None, travel: None, speed: None, time: None };

/// The thesis's axis before a stop, with a range that is unknown after a reset. A slower PWM costs
/// the emulator less time.
fn plan(law: &str) -> RunPlan {
    let law = format!("loop.controller={law}");
    let set = [
        &*law,
        "reference.steps_deg=[5.0]",
        "drive.pwm_hz=2000",
        "limits.position_min_deg=-10",
        "limits.position_max_deg=40",
        "device.reference=\"command\"",
    ];
    let plan = plans("step-response", &[], &set).remove(0);
    RunPlan { substitute: Some(axis_with_stops([-1e3, STOP_DEG])), ..plan }
}

fn homed<W: Wire>(client: &mut Client<W>) -> (Option<HomeFindings>, Status) {
    client.pass(Duration::from_millis(100)).unwrap();
    client.home(UP).unwrap();
    client.pass_armed(Duration::from_secs(60)).unwrap();
    (client.homed().unwrap(), client.status().unwrap())
}

#[test]
fn a_homing_finds_what_a_simulated_device_finds_and_leaves_the_bridge_off() {
    for law in ["srnf", "robust"] {
        let mut simulated = SimulatedDevice::new(&plan(law)).unwrap();
        simulated.ticks(10);
        let mut here = Client::connect(SimulatedWire::new(simulated)).unwrap();
        let (expected, _) = homed(&mut here);
        let wire = EmulatedWire::with(&firmware(), &plan(law)).unwrap();
        let mut there = Client::connect(wire).unwrap();
        let (found, status) = homed(&mut there);
        assert_eq!(found, expected, "{law}");
        let found = found.unwrap();
        assert_eq!(found.ended, HomeEnd::Stop, "{law}: {found:?}");
        assert!((f64::from(found.moved) * COUNT_DEG - STOP_DEG).abs() <= 2.0 * COUNT_DEG);
        assert!(status.is_referenced, "{law}");
        assert_eq!(status.faults, 0, "{law}");
        let board = &mut there.wire().board;
        assert!(!board.samples(20).unwrap().bridge.is_on(), "{law}");
        let position = there.status().unwrap().position;
        let board = &mut there.wire().board;
        let true_deg = board.act(|halted| halted.plant().position_deg()).unwrap() - STOP_DEG;
        let error_deg = f64::from(position - AT) * COUNT_DEG - true_deg;
        assert!(error_deg.abs() <= 2.0 * COUNT_DEG, "{law}: {error_deg} deg");
    }
}

#[test]
fn a_homing_that_is_stopped_on_its_way_sets_no_zero() {
    let wire = EmulatedWire::with(&firmware(), &plan("srnf")).unwrap();
    let mut client = Client::connect(wire).unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    client.set_reference(0.0).unwrap();
    assert!(client.status().unwrap().is_referenced);
    client.home(UP).unwrap();
    client.pass(Duration::from_millis(400)).unwrap();
    let board = &mut client.wire().board;
    assert!(board.samples(1).unwrap().bridge.is_on());
    client.stop().unwrap();
    client.pass(Duration::from_millis(500)).unwrap();
    assert_eq!(client.homed().unwrap(), None);
    let status = client.status().unwrap();
    assert!(!status.is_referenced && status.faults == 0, "{status:?}");
    assert!(!client.wire().board.samples(1).unwrap().bridge.is_on());
}
