//! Homing in the image: it finds the stop as a simulated device does, and one that is ended leaves
//! no zero.

use std::time::Duration;

use emulator::wire::EmulatedWire;
use experiments::axis_with_stops::{COUNT_DEG, axis_with_stops};
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::RunPlan;
use stiction::Fault;
use stiction::link::{StateCode, Status};
use stiction::motion::home::{HomeEnd, HomeFindings, HomeRequest, HomeTarget, Sense};

use crate::common::{firmware, plans};

const STOP_DEG: f64 = 1.5;

/// Angle of a homing switch, deg.
const EDGE_DEG: f64 = 1.3;

/// The position that is asked for at the place, counts.
const AT: i32 = 4000;

const UP: HomeRequest = HomeRequest {
    sense: Sense::Plus,
    at: AT,
    effort: None,
    travel: None,
    speed: None,
    time: None,
    to: HomeTarget::Stop,
};

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

/// The same axis, with a switch before the stop and an index in every 800 counts, 1.94 deg.
fn plan_with(contact: &str) -> RunPlan {
    let set = [
        "loop.controller=srnf",
        "reference.steps_deg=[5.0]",
        "drive.pwm_hz=2000",
        "device.index_counts=800",
        "limits.encoder_jump_deg=1",
        "limits.following_error_deg=0",
        &*format!("device.home_switch=\"{contact}\""),
    ];
    let plan = plans("step-response", &[], &set).remove(0).with_home_switch(EDGE_DEG);
    RunPlan { substitute: Some(axis_with_stops([-1e3, 4.0])), ..plan }
}

fn homed<W: Wire>(client: &mut Client<W>) -> (Option<HomeFindings>, Status) {
    homed_to(client, HomeTarget::Stop)
}

fn homed_to<W: Wire>(client: &mut Client<W>, to: HomeTarget) -> (Option<HomeFindings>, Status) {
    client.pass(Duration::from_millis(100)).unwrap();
    client.home(HomeRequest { to, ..UP }).unwrap();
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

/// PA7 and the capture of PA2 on the emulated board, against the levels of a simulated device. The
/// last place is an index, from which the count is checked.
#[test]
fn a_homing_to_a_switch_and_to_an_index_finds_what_a_simulated_device_finds() {
    for (contact, to, ended) in [
        ("normally-closed", HomeTarget::Switch, HomeEnd::Switch),
        ("normally-open", HomeTarget::Switch, HomeEnd::Switch),
        ("normally-closed", HomeTarget::Index, HomeEnd::Index),
        ("normally-closed", HomeTarget::SwitchIndex, HomeEnd::Index),
    ] {
        let name = format!("{contact}, {to:?}");
        let mut simulated = SimulatedDevice::new(&plan_with(contact)).unwrap();
        simulated.ticks(10);
        let mut here = Client::connect(SimulatedWire::new(simulated)).unwrap();
        let (expected, _) = homed_to(&mut here, to);
        let wire = EmulatedWire::with(&firmware(), &plan_with(contact)).unwrap();
        let mut there = Client::connect(wire).unwrap();
        let (found, status) = homed_to(&mut there, to);
        assert_eq!(found, expected, "{name}");
        assert_eq!(found.unwrap().ended, ended, "{name}");
        assert!(status.is_referenced && status.faults == 0, "{name}: {status:?}");
        assert!(!there.wire().board.samples(20).unwrap().bridge.is_on(), "{name}");
    }
}

/// A joint at rest loses 100 counts by noise on A and B, then turns on: the next index is the
/// fault.
#[test]
fn counts_that_noise_has_taken_are_a_fault_at_the_next_index_on_the_board() {
    let plan = plan_with("none");
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    client.set_reference(0.0).unwrap();
    client.arm().unwrap();
    client.pass_armed(Duration::from_millis(600)).unwrap();
    client.step_to(2.0).unwrap();
    let status = client.pass_armed(Duration::from_secs(2)).unwrap();
    assert_eq!((status.index_passes, status.index_deviation, status.faults), (1, 0, 0));
    client.wire().board.act(|halted| halted.jump(-100)).unwrap();
    client.step_to(3.5).unwrap();
    let status = client.pass_armed(Duration::from_secs(2)).unwrap();
    assert_eq!(status.state, StateCode::Faulted(Fault::IndexDeviation as u8), "{status:?}");
    assert!((status.fault.value + 100.0).abs() < 0.5, "{status:?}");
}
