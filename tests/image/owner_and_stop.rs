//! A stop of a joint that moves, a second client, and a reset of a joint with a range, in the
//! image.
//!
//! tests/device has each of them under every law: controlled_stop.rs, link/owner.rs, referenced.rs.

use std::time::Duration;

use emulator::fault_injection::Injection;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::link::StateCode;
use stiction::motion::jog::JogRequest;

use crate::common::{firmware, plans};

const SECOND: Duration = Duration::from_secs(1);

fn board(law: &str, set: &[&str]) -> Client<EmulatedWire> {
    // A slower PWM costs the emulator less time.
    let set = [&["drive.pwm_hz=2000"], set].concat();
    let plan = plans("step-response", &[law], &set).remove(0);
    Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap()
}

/// Position (deg) and speed (deg/s) of the joint.
fn place(client: &mut Client<EmulatedWire>) -> (f64, f64) {
    let act = client.wire().board.act(|halted| {
        let plant = halted.plant();
        (plant.position_deg(), plant.velocity_deg_per_s())
    });
    act.unwrap()
}

/// A joint in the middle of a step of 20 deg.
fn moving(law: &str, set: &[&str]) -> Client<EmulatedWire> {
    let mut client = board(law, set);
    client.arm().unwrap();
    client.step_to(20.0).unwrap();
    client.pass_armed(Duration::from_millis(600)).unwrap();
    client
}

/// How far a joint goes after a stop, deg.
fn stopped(law: &str, set: &[&str]) -> f64 {
    let mut client = moving(law, set);
    let (from, speed) = place(&mut client);
    assert!(speed > 5.0, "{law}: {speed} deg/s");
    client.stop().unwrap();
    client.pass(5 * SECOND).unwrap();
    let (at, speed) = place(&mut client);
    assert_eq!(speed, 0.0, "{law}");
    at - from
}

#[test]
fn a_stop_brakes_the_joint_before_the_bridge_is_off() {
    for law in ["pd", "srnf", "robust"] {
        let (braked, coasted) = (stopped(law, &[]), stopped(law, &["device.stop_s=0"]));
        assert!(braked > 0.0 && braked < 0.5 * coasted, "{law}: {braked} deg, {coasted} deg");
    }
}

#[test]
fn a_second_client_reads_while_the_motor_is_driven_and_owns_it_once_it_has_taken_over() {
    let first = moving("srnf", &[]);
    let mut second = Client::connect(first.end()).unwrap();
    assert!(second.is_guest());
    assert_eq!(second.status().unwrap().state, StateCode::Armed);
    let why = second.step_to(1.0).unwrap_err().to_string();
    assert!(why.contains("another client"), "{why}");
    second.take_over().unwrap();
    let (_, speed) = place(&mut second);
    assert!(!second.is_guest() && speed < 1.0, "{speed} deg/s");
    second.pass(SECOND).unwrap();
    second.arm().unwrap();
    second.pass_armed(SECOND).unwrap();
    assert_eq!(second.status().unwrap().faults, 0);
}

#[test]
fn after_a_reset_a_joint_with_a_range_only_jogs_until_a_command_sets_its_position() {
    let range = [
        "limits.position_min_deg=-10",
        "limits.position_max_deg=40",
        "device.reference=\"command\"",
    ];
    let mut client = board("pd", &range);
    assert!(client.status().unwrap().is_referenced, "the wire has set the zero");
    client.wire().board.act(|halted| halted.inject(Injection::Reset)).unwrap();
    client.wire().board.pass(300_000_000).unwrap();
    let mut client = Client::connect(client.end()).unwrap();
    assert!(!client.status().unwrap().is_referenced);
    let why = client.arm().unwrap_err().to_string();
    assert!(why.contains("position is unknown since a reset"), "{why}");
    client.jog(JogRequest::default()).unwrap();
    while client.pass(SECOND).unwrap().state == StateCode::Armed {}
    assert!(client.jogged().unwrap().is_some());
    client.set_reference(30.0).unwrap();
    client.arm().unwrap();
}
