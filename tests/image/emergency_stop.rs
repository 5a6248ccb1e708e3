//! The contact of the emergency stop on the board: the hardware turns the bridge off, and the
//! program reports it.
//!
//! Blind to the contact's circuit (docs/reference/wiring.md), of which the board has the levels.

use std::time::Duration;

use emulator::bridge::BridgeInputs;
use emulator::fault_injection::Injection;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::Fault;
use stiction::link::StateCode;

use crate::common::{firmware, plans};
use crate::fault_injection::MS;

const TIM1_BDTR: u64 = 0x4001_0044;
const MOE: u32 = 1 << 15;
const CONTACT: &str = "device.emergency_stop=true";
const TICK: Duration = Duration::from_millis(20);

const fn faulted(fault: Fault) -> StateCode {
    StateCode::Faulted(fault as u8)
}

/// A board that is armed and follows a step of 5 deg.
fn armed(set: &[&str]) -> Client<EmulatedWire> {
    let set = [&["drive.pwm_hz=2000", "reference.steps_deg=[5.0]"], set].concat();
    let plan = plans("step-response", &["pd"], &set).remove(0);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    drive(&mut client);
    client
}

fn drive(client: &mut Client<EmulatedWire>) {
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    client.pass_armed(10 * TICK).unwrap();
    assert!(is_on(client));
}

fn is_on(client: &mut Client<EmulatedWire>) -> bool {
    client.wire().board.act(|halted| BridgeInputs::read(halted.board()).is_on()).unwrap()
}

fn inject(client: &mut Client<EmulatedWire>, fault: Injection) {
    client.wire().board.act(move |halted| halted.inject(fault)).unwrap();
}

fn log(client: &mut Client<EmulatedWire>) -> Vec<String> {
    let lines = client.wire().board.act(|halted| {
        halted.harness.log.lines.iter().map(|line| line.text.clone()).collect::<Vec<_>>()
    });
    lines.unwrap()
}

#[test]
fn an_open_contact_turns_the_bridge_off_without_the_program() {
    let mut client = armed(&[CONTACT]);
    inject(&mut client, Injection::CoreStalls);
    inject(&mut client, Injection::ContactOpens);
    client.wire().board.pass(MS / 100).unwrap();
    let output = client.wire().board.act(|halted| halted.register(TIM1_BDTR)).unwrap().unwrap();
    assert_eq!(output & MOE, 0, "the break input has ended the PWM");
    assert!(!is_on(&mut client));
}

#[test]
fn an_emergency_stop_is_reported_as_such_and_ends_once_the_contact_is_closed() {
    let mut client = armed(&[CONTACT]);
    for stops in 1..=2 {
        inject(&mut client, Injection::ContactOpens);
        let status = client.pass(2 * TICK).unwrap();
        assert_eq!((status.state, status.faults), (faulted(Fault::EmergencyStop), stops));
        assert!(client.clear().is_err() && client.arm().is_err());
        assert!(!is_on(&mut client));
        inject(&mut client, Injection::ContactCloses);
        let status = client.pass(10 * TICK).unwrap();
        assert_eq!(status.state, faulted(Fault::EmergencyStop), "only a command clears it");
        client.clear().unwrap();
        client.pass(100 * TICK).unwrap();
        drive(&mut client);
    }
    let log = log(&mut client);
    assert!(
        log.iter().any(|line| line.starts_with("faulted: emergency stop (code 32)")),
        "{log:?}"
    );
    assert!(!log.iter().any(|line| line.contains("break input")), "{log:?}");
}

/// Bounces end before the tick reads the contact: the break input alone has seen them.
#[test]
fn a_contact_that_bounces_is_no_fault_of_the_bridge() {
    let mut client = armed(&[CONTACT]);
    inject(&mut client, Injection::ContactOpens);
    inject(&mut client, Injection::ContactCloses);
    assert!(!is_on(&mut client));
    assert_eq!(client.pass(TICK).unwrap().state, faulted(Fault::BreakInput));
    inject(&mut client, Injection::ContactOpens);
    assert_eq!(client.pass(2 * TICK).unwrap().state, faulted(Fault::EmergencyStop));
}

#[test]
fn without_the_key_the_contact_still_acts_in_hardware() {
    let mut client = armed(&[]);
    inject(&mut client, Injection::ContactOpens);
    assert!(!is_on(&mut client));
    assert_eq!(client.pass(2 * TICK).unwrap().state, faulted(Fault::BreakInput));
}
