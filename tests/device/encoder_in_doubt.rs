//! A client that clears, arms and repeats while the encoder is dead: how far the joint goes, and
//! what makes the servo trust the encoder again.
//!
//! The servo has the limits that are derived for the thesis's robot. Travel is true travel.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::motion::jog::JogRequest;
use stiction::servo::{Boot, Refusal, State};
use stiction::{Fault, Servo};

use crate::dead_encoder::{armed, step};
use crate::fixture::srnf;
use experiments::controllers;

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// Starts a jog within the device's own bounds.
pub fn jog(device: &mut SimulatedDevice) -> Result<(), Refusal> {
    let jog = device.device.parameters().unwrap().jog(&JogRequest::default()).unwrap();
    device.device.servo().jog(jog)
}

/// Runs a jog to its end.
fn jog_to_its_end(device: &mut SimulatedDevice) {
    jog(device).unwrap();
    while device.tick().state == State::Armed {
        device.device.servo().heard();
    }
}

/// Returns a device at rest under a law, whose fault is cleared. The wires are sound again.
fn cleared(law: &str, fault: Fault) -> SimulatedDevice {
    let mut device = armed(law);
    device.device.servo().fault(fault);
    device.ticks(10);
    device.device.servo().clear().unwrap();
    device.tick();
    device
}

/// The client closes the loop whenever it can. The first stall is the only one.
#[test]
fn a_client_that_clears_and_arms_drives_a_joint_with_a_dead_encoder_once() {
    for law in controllers() {
        for to_deg in [-5.0, 5.0, 40.0] {
            let name = format!("{law}, {to_deg} deg");
            let mut device = armed(law);
            device.wires = Wires::Cut;
            step(&mut device, to_deg);
            let from = device.position_deg();
            let (mut farthest, mut refused) = (0.0f64, 0);
            for _ in 0..MINUTE {
                device.device.servo().heard();
                let state = device.tick().state;
                farthest = farthest.max((device.position_deg() - from).abs());
                if state == State::Armed {
                    continue;
                }
                device.device.servo().clear().unwrap();
                match device.device.servo().arm_for_link(None) {
                    Ok(()) => {
                        device.tick();
                        step(&mut device, to_deg);
                    }
                    Err(Refusal::EncoderInDoubt) => refused += 1,
                    Err(other) => assert_eq!(other, Refusal::Moving, "{name}"),
                }
            }
            assert!(device.device.servo().is_encoder_in_doubt(), "{name}");
            assert_eq!(device.device.servo().log().count(), 1, "{name}");
            assert!(refused > MINUTE / 2, "{name}: {refused}");
            let travel_deg = format!("{farthest:.2}");
            reliability!("repeating-client", law, step_deg = to_deg, travel_deg);
            assert!(farthest < 45.0, "{name}: {farthest} deg");
        }
    }
}

/// Every way to close the loop is refused; a jog is not.
#[test]
fn in_doubt_the_servo_only_jogs() {
    for fault in [Fault::Stall, Fault::EncoderJump, Fault::EncoderReversed] {
        let mut device = cleared("pd", fault);
        let servo = device.device.servo();
        assert_eq!(servo.arm_for_link(None), Err(Refusal::EncoderInDoubt), "{fault:?}");
        assert_eq!(servo.arm(), Err(Refusal::EncoderInDoubt), "{fault:?}");
        let plan = device.device.parameters().unwrap().identify(&Default::default()).unwrap();
        assert_eq!(device.device.servo().identify(&plan), Err(Refusal::EncoderInDoubt));
        assert_eq!(jog(&mut device), Ok(()), "{fault:?}");
    }
    // A fault that says nothing of the encoder is only cleared.
    let mut device = cleared("pd", Fault::BreakInput);
    assert_eq!(device.device.servo().arm_for_link(None), Ok(()));
}

#[test]
fn counts_by_hand_prove_the_encoder_at_rest_or_moving() {
    for fault in [Fault::Stall, Fault::EncoderJump, Fault::EncoderReversed] {
        for (counts, proves) in [(15.0, false), (-15.0, false), (16.0, true), (-16.0, true)] {
            let mut device = cleared("pd", fault);
            let at = device.position_deg();
            device.push(at + counts * 0.00242, 0.0);
            device.ticks(10);
            assert_eq!(
                device.device.servo().arm_for_link(None).is_ok(),
                proves,
                "{fault:?}, {counts} counts"
            );
        }
    }
}

#[test]
fn a_jog_proves_an_encoder_that_agrees_and_no_other() {
    for (wires, proves) in [(Wires::Sound, true), (Wires::Swapped, false), (Wires::Cut, false)] {
        let mut device = cleared("pd", Fault::Stall);
        device.wires = wires;
        jog_to_its_end(&mut device);
        // The joint coasts for some counts after the jog: the drive moved them, and no hand.
        device.ticks(50);
        let servo = device.device.servo();
        assert_eq!(servo.is_encoder_in_doubt(), !proves, "{wires:?}: {:?}", servo.jogged());
        assert_eq!(servo.arm_for_link(None).is_ok(), proves, "{wires:?}");
    }
}

/// A client may repeat the jog without end. Each moves a joint with a dead encoder within the
/// bounds of `tests/device/jog.rs`, to and fro.
#[test]
fn jogs_with_a_dead_encoder_lead_nowhere_in_a_minute() {
    let mut device = cleared("pd", Fault::Stall);
    device.wires = Wires::Cut;
    let from = device.position_deg();
    let (mut farthest, mut jogs) = (0.0f64, 0);
    for _ in 0..MINUTE {
        device.device.servo().heard();
        if device.tick().state != State::Armed {
            device.device.servo().clear().unwrap();
            jogs += u32::from(jog(&mut device).is_ok());
        }
        farthest = farthest.max((device.position_deg() - from).abs());
    }
    reliability!("repeated-jogs", jogs, travel_deg = format!("{farthest:.2}"));
    assert!(device.device.servo().is_encoder_in_doubt());
    assert!(jogs > 10, "{jogs}");
    assert!(farthest < 45.0, "{farthest} deg");
}

/// The fault may have been cleared before the reset, and the encoder still be dead.
#[test]
fn the_doubt_outlasts_a_reset_and_nothing_arms_automatically() {
    let parameters = srnf(&["device.autostart=true"]);
    let stalled = Some(Fault::Stall.into());
    for (is_encoder_in_doubt, fault) in [(true, None), (false, stalled), (true, stalled)] {
        let boot = Boot { is_encoder_in_doubt, fault, ..Boot::default() };
        let hardware = files::hardware::STM32F405;
        let mut servo = Servo::new(Ok(&parameters), boot, &hardware);
        let mut ticks = |counter, count| {
            for _ in 0..count {
                servo.tick(stiction::servo::Input {
                    counter,
                    supply: hardware.supply_top,
                    lines: 0,
                    ..Default::default()
                });
            }
            servo.clear().unwrap();
            servo.state()
        };
        assert_eq!(ticks(0, 100), State::Stopped, "{boot:?}");
        // A hand proves the encoder, and must not start the motion of the parameters.
        assert_eq!(ticks(100, 100), State::Stopped, "{boot:?}");
        assert_eq!(servo.arm(), Ok(()), "{boot:?}");
    }
}
