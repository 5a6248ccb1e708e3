//! A wire of the encoder that is open at rest, under every law: it follows the resistors of the
//! input, and the servo finds it before it drives.
//!
//! The servo has the limits that are derived for the thesis's robot, and its tick of 20 ms: a
//! reading a tick, 32 readings a test. Tests at 1 ms a tick are in `src/safety/open_line.rs`.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::servo::{Output, Refusal, State};

use crate::dead_encoder::{armed_with, step};
use crate::encoder_in_doubt::jog;
use crate::fixture::plans;
use experiments::controllers;

/// Ticks of 20 ms in a second.
const SECOND: u32 = 50;

/// A test for open lines: one tick to rest and 32 readings.
const TEST: u32 = 33;

const PUSH_PULL: &str = "encoder.output=push-pull";

/// The wires that are open, with the value of the fault: line A, and both.
const OPEN: [(Wires, f32); 2] = [(Wires::OneCut, 1.0), (Wires::Cut, 3.0)];

/// The joint of the thesis's robot at rest under a law, before its first tick.
fn powered(law: &str, set: &[&str]) -> SimulatedDevice {
    let controller = format!("loop.controller={law}");
    let own = [&*controller, "reference.steps_deg=[5.0]"];
    SimulatedDevice::new(&plans("step-response", &[&own, set].concat())[0]).unwrap()
}

/// Asks for a closed loop and for a jog.
fn try_to_arm(device: &mut SimulatedDevice) -> [Result<(), Refusal>; 2] {
    [device.device.servo().arm_for_link(None), jog(device)]
}

#[test]
fn a_wire_that_is_open_at_power_on_is_found_before_arming_however_often_a_client_tries() {
    for law in controllers() {
        for (wires, value) in OPEN {
            let mut device = powered(law, &[PUSH_PULL]);
            device.wires = wires;
            let mut finds = 0;
            for _ in 0..10 * SECOND {
                let Output { enable, state, .. } = device.tick();
                assert!(!enable, "{law}, {wires:?}");
                if let State::Faulted(fault) = state {
                    let servo = device.device.servo();
                    assert_eq!(fault, Fault::EncoderOpen, "{law}, {wires:?}");
                    assert_eq!(servo.latched().map(|latched| latched.value), Some(value));
                    assert!(servo.is_encoder_in_doubt());
                    servo.clear().unwrap();
                    finds += 1;
                }
                for armed in try_to_arm(&mut device) {
                    assert_eq!(armed, Err(Refusal::Moving), "{law}, {wires:?}");
                }
            }
            // Each clearing begins a test of its own. Two open lines count in a test, and the next
            // one waits until they are still.
            assert!((10 * SECOND / (TEST + 3)..=10 * SECOND / TEST).contains(&finds), "{finds}");
        }
    }
}

/// The wires open once the joint holds its place, whatever effort it holds it with.
#[test]
fn a_wire_that_opens_at_rest_is_found_by_the_next_test_or_after_the_fault_of_a_law_that_pushes() {
    for law in controllers() {
        let (mut latest, mut farthest, mut finds, mut runs) = (0, 0.0f64, 0, 0);
        for (wires, value) in OPEN {
            for to_deg in [0.2, 5.0] {
                for after in [0, 7, 20] {
                    let mut device = armed_with(law, 1.0, &[PUSH_PULL]);
                    step(&mut device, to_deg);
                    let tick = |device: &mut SimulatedDevice| {
                        device.device.servo().heard();
                        device.tick().state
                    };
                    let name = format!("{law}, {wires:?}, {to_deg} deg, {after}");
                    for _ in 0..6 * SECOND + after {
                        assert_eq!(tick(&mut device), State::Armed, "{name}");
                    }
                    device.wires = wires;
                    let from = device.position_deg();
                    let ticks = (1..).find(|_| tick(&mut device) != State::Armed).unwrap();
                    latest = latest.max(ticks);
                    farthest = farthest.max((device.position_deg() - from).abs());
                    let mut latched = device.device.servo().latched().unwrap();
                    runs += 1;
                    finds += u32::from(latched.fault == Fault::EncoderOpen);
                    if latched.fault != Fault::EncoderOpen {
                        // A law that pushes on is no joint at rest. Once it is, the cause is found.
                        assert!(latched.fault.doubts_encoder(), "{name}: {latched:?}");
                        device.device.servo().clear().unwrap();
                        device.ticks(2 * SECOND);
                        latched = device.device.servo().latched().unwrap();
                    }
                    assert_eq!(latched.fault, Fault::EncoderOpen, "{name}");
                    // The wires may open within a test: it has cleared one of them already.
                    let is_whole = latched.value == value || (value == 3.0 && latched.value > 0.0);
                    assert!(is_whole, "{name}: {latched:?}");
                }
            }
        }
        reliability!(
            "open-line",
            law,
            runs,
            finds,
            latest_s = format!("{:.2}", 0.02 * f64::from(latest)),
            travel_deg = format!("{farthest:.2}")
        );
        // A second between two tests, and the test.
        assert!(latest <= SECOND + TEST, "{law}: {latest} ticks");
        assert!(finds > 0, "{law}");
        assert!(farthest <= 10.0, "{law}: {farthest} deg");
    }
}

#[test]
fn driven_lines_run_as_without_the_test_to_the_last_bit() {
    for law in controllers() {
        for wires in [Wires::Sound, Wires::Swapped] {
            let [mut with, mut without] =
                [&[PUSH_PULL][..], &[]].map(|set| armed_with(law, 1.0, set));
            for device in [&mut with, &mut without] {
                device.wires = wires;
                step(device, 5.0);
            }
            for tick in 0..60 * SECOND {
                for device in [&mut with, &mut without] {
                    device.device.servo().heard();
                }
                assert_eq!(with.tick(), without.tick(), "{law}, {wires:?}, tick {tick}");
            }
        }
    }
}

#[test]
fn an_output_that_an_open_line_looks_like_is_not_tested() {
    for output in ["unknown", "open-collector", "receiver"] {
        let mut device = powered("pd", &[&format!("encoder.output={output}")]);
        device.wires = Wires::Cut;
        for _ in 0..10 * SECOND {
            assert_eq!(device.tick().state, State::Stopped, "{output}");
            assert!(!device.device.servo().pulls_down(), "{output}");
        }
        device.device.servo().arm_for_link(None).unwrap();
    }
}

/// A stall comes first, and the joint rests while two open lines count in test after test.
#[test]
fn what_open_lines_count_in_a_test_proves_no_encoder() {
    let mut device = powered("pd", &[PUSH_PULL]);
    device.ticks(SECOND);
    device.wires = Wires::Cut;
    device.device.servo().fault(Fault::Stall);
    let mut counted = Vec::new();
    for _ in 0..10 * SECOND {
        device.tick();
        let servo = device.device.servo();
        assert!(servo.is_encoder_in_doubt());
        counted.push(servo.position());
    }
    // Each change of the pull is two counts, and a test begins and ends with the pull-up.
    counted.dedup();
    assert!(counted.windows(2).all(|pair| pair[1] - pair[0] == 2), "{counted:?}");
    let first = counted.iter().position(|&counts| counts == 36);
    assert!(first.is_some(), "{counted:?}");
}

#[test]
fn a_wire_that_is_whole_again_needs_a_hand_on_the_joint() {
    let mut device = powered("pd", &[PUSH_PULL]);
    device.wires = Wires::OneCut;
    device.ticks(2 * SECOND);
    device.wires = Wires::Sound;
    device.ticks(SECOND);
    device.device.servo().clear().unwrap();
    device.ticks(SECOND);
    assert_eq!(device.device.servo().arm_for_link(None), Err(Refusal::EncoderInDoubt));
    device.push(0.2, 0.0);
    device.ticks(SECOND);
    device.device.servo().arm_for_link(None).unwrap();
}
