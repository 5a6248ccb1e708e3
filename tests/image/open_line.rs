//! An open wire of the encoder in the image: the part's resistors pull the pin, and the firmware
//! finds it before it drives. The emulated port has its resistors; its pins have no capacitance.

use std::time::Duration;

use emulator::wire::EmulatedWire;
use files::encoder::Wires;
use simulator::device::client::Client;
use stiction::Fault;
use stiction::link::StateCode;

use crate::common::{firmware, plans};

/// 33 ticks of 20 ms, a test for open lines, and some more for the client.
const TEST: Duration = Duration::from_millis(1000);

/// A second from one test to the next, as well.
const REST: Duration = Duration::from_millis(2000);

fn board(wires: Wires) -> Client<EmulatedWire> {
    // A slower PWM costs the emulator less time.
    let set = ["drive.pwm_hz=2000", "encoder.output=push-pull"];
    let plan = plans("step-response", &["pd"], &set).remove(0);
    let mut wire = EmulatedWire::with(&firmware(), &plan).unwrap();
    wire.board.act(move |halted| halted.rewire(wires)).unwrap();
    Client::connect(wire).unwrap()
}

#[track_caller]
fn assert_found(client: &mut Client<EmulatedWire>, value: f32) {
    let fault = client.status().unwrap().fault;
    assert_eq!((fault.code, fault.value), (Fault::EncoderOpen as u8, value));
    assert!(!client.wire().board.samples(2).unwrap().bridge.is_on());
}

#[test]
fn a_wire_that_opens_before_arming_is_found_at_the_next_test_and_after_each_clearing() {
    for (wires, value) in [(Wires::OneCut, 1.0), (Wires::Cut, 3.0)] {
        let mut client = board(wires);
        // The wires were whole while the client connected, and a first test has passed.
        for until in [REST, TEST] {
            client.pass(until).unwrap();
            assert_found(&mut client, value);
            client.clear().unwrap();
            assert!(client.arm().is_err(), "{wires:?}");
        }
    }
}

#[test]
fn a_wire_that_opens_while_the_servo_holds_turns_the_bridge_off_and_sound_wires_do_not() {
    let mut client = board(Wires::Sound);
    client.pass(TEST).unwrap();
    client.arm().unwrap();
    let status = client.pass_armed(2 * REST).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
    client.wire().board.act(|halted| halted.rewire(Wires::OneCut)).unwrap();
    // An error: the servo does not stay armed.
    let _ = client.pass_armed(REST);
    assert_found(&mut client, 1.0);
}
