//! Referenced: whether the servo knows where the joint stands, on which its range rests.
//!
//! The joint is the thesis's robot with a range of -10 to 40 deg.

use experiments::controllers;
use simulator::device::client::Client;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use stiction::control::encoder::Direction;
use stiction::control::reference::{Reference, Step};
use stiction::motion::jog::JogRequest;
use stiction::servo::{Boot, Input, Refusal, State};
use stiction::units::position::Position;
use stiction::{Fault, Parameters, Servo};

use crate::dead_encoder::step;
use crate::fixture::{parameters, plans, srnf};

const RANGE: [&str; 2] = ["limits.position_min_deg=-10", "limits.position_max_deg=40"];
const COMMAND: &str = "device.reference=\"command\"";

/// Angle of a count, deg.
const COUNT_DEG: f64 = 0.00242;

/// A device under a law that has just come out of a reset, with the joint at rest.
fn reset(law: &str, set: &[&str]) -> SimulatedDevice {
    let law = format!("loop.controller={law}");
    let set = [&[&*law, "reference.steps_deg=[5.0]"], set].concat();
    let plan = &plans("step-response", &set)[0];
    let mut device = SimulatedDevice::running(plan, &parameters(plan), Boot::default()).unwrap();
    device.ticks(20);
    device
}

fn with_range(law: &str) -> SimulatedDevice {
    reset(law, &[RANGE[0], RANGE[1], COMMAND])
}

fn counts(deg: f64) -> i32 {
    (deg / COUNT_DEG).round() as i32
}

fn jog(device: &mut SimulatedDevice) -> Result<(), Refusal> {
    let jog = device.device.parameters().unwrap().jog(&JogRequest::default()).unwrap();
    device.device.servo().jog(jog)
}

/// A reset forgets the place, so every way to drive the joint but a jog is refused, wherever the
/// joint stands.
#[test]
fn after_a_reset_a_joint_with_a_range_only_jogs_until_a_command_sets_its_position() {
    for law in controllers() {
        let mut device = with_range(law);
        device.push(50.0, 0.0);
        device.ticks(20);
        let (plan, ramp) = {
            let parameters = device.device.parameters().unwrap();
            (parameters.identify(&Default::default()).unwrap(), parameters.ramp(0.05, 1.0).unwrap())
        };
        let servo = device.device.servo();
        assert!(!servo.is_referenced(), "{law}");
        assert_eq!(servo.arm(), Err(Refusal::NotReferenced), "{law}");
        assert_eq!(servo.arm_for_link(None), Err(Refusal::NotReferenced), "{law}");
        assert_eq!(servo.arm_for_link(Some(ramp)), Err(Refusal::NotReferenced), "{law}");
        assert_eq!(servo.identify(&plan), Err(Refusal::NotReferenced), "{law}");
        // The range does not hold for a jog, which has its own travel.
        assert_eq!(jog(&mut device), Ok(()), "{law}");
        while device.tick().state == State::Armed {
            device.device.servo().heard();
        }
        assert!(device.device.servo().jogged().is_some(), "{law}");
        device.ticks(20);
        let servo = device.device.servo();
        assert_eq!(servo.set_reference(counts(30.0)), Ok(()), "{law}");
        assert_eq!(servo.arm_for_link(None), Ok(()), "{law}");
    }
}

/// At 30 deg of -10 to 40, 10 deg are left one way and 40 the other.
#[test]
fn the_range_counts_from_the_position_that_the_command_sets() {
    let mut device = with_range("pd");
    // Counts before the command do not matter.
    device.push(7.0, 0.0);
    device.ticks(20);
    device.device.servo().set_reference(counts(30.0)).unwrap();
    assert_eq!(device.device.servo().position(), counts(30.0));
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    for (to_deg, is_in) in [(9.9, true), (10.1, false), (-39.9, true), (-40.1, false)] {
        let far = Step { to: Position::from_counts(counts(to_deg)), ..Step::default() };
        let found = device.device.servo().follow(Reference::Step(far));
        assert_eq!(found.is_ok(), is_in, "{to_deg} deg: {found:?}");
        step(&mut device, 0.0);
    }
    device.device.servo().stop();
    device.ticks(20);
    // The fault has the position from the reference.
    device.device.servo().set_reference(counts(39.9)).unwrap();
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    device.push(device.position_deg() + 0.2, 0.0);
    device.tick();
    let latched = device.device.servo().latched().unwrap();
    assert_eq!(latched.fault, Fault::PositionLimit);
    assert!((latched.value - 40.1).abs() < 0.02, "{latched:?}");
}

/// Lost or added counts end the reference. With `power-on`, the place of the last reset counts for
/// good, as the file asks.
#[test]
fn a_fault_of_the_encoder_ends_the_reference_and_no_other_does() {
    for &fault in Fault::ALL {
        for (reference, is_kept) in [(COMMAND, false), ("device.reference=\"power-on\"", true)] {
            let mut device = reset("pd", &[RANGE[0], RANGE[1], reference]);
            let servo = device.device.servo();
            servo.set_reference(0).unwrap();
            servo.fault(fault);
            let doubts = fault.doubts_encoder();
            assert_eq!(servo.is_referenced(), is_kept || !doubts, "{fault:?}, {reference}");
        }
    }
    let doubts = Fault::ALL.iter().filter(|fault| fault.doubts_encoder()).count();
    assert_eq!(doubts, 5, "stall, jump, reversal, open line and disagreeing encoders");
}

/// A client that is connected to a device of the thesis's robot, and the parameters.
fn connected(set: &[&str]) -> (Client<SimulatedWire>, Parameters) {
    let mut client = Client::connect(SimulatedWire::new(reset("srnf", set))).unwrap();
    let parameters = client.parameters().unwrap();
    (client, parameters)
}

/// Ten degrees away from zero the other direction would mirror the range.
#[test]
fn another_encoder_ends_the_reference_and_other_parameters_keep_it() {
    for reference in [COMMAND, "device.reference=\"power-on\""] {
        let change = |change: fn(&mut Parameters)| {
            let (mut client, mut parameters) = connected(&[RANGE[0], RANGE[1], reference]);
            client.set_reference(10.0).unwrap();
            change(&mut parameters);
            client.set_parameters(&parameters).unwrap();
            client.pass(std::time::Duration::from_millis(200)).unwrap();
            let status = client.status().unwrap();
            assert_eq!(client.arm().is_ok(), status.is_referenced, "{reference}");
            status.is_referenced
        };
        assert!(!change(|all| all.controller.encoder.direction = Direction::Reverse));
        assert!(!change(|all| all.controller.encoder.resolution *= 2.0));
        assert!(change(|all| all.controller.pd.kp *= 0.9));
        assert!(change(|all| all.limits.position_max = 30.0));
    }
}

/// The sentence names the command that helps.
#[test]
fn a_client_learns_what_to_do_and_does_it() {
    let (mut client, _) = connected(&[RANGE[0], RANGE[1], COMMAND]);
    let why = client.arm().unwrap_err().to_string();
    assert!(why.contains("reference --at DEG") && why.contains("jog"), "{why}");
    assert!(!client.status().unwrap().is_referenced);
    assert!(client.set_reference(1e9).unwrap_err().to_string().contains("2^30 counts"));
    client.set_reference(-9.0).unwrap();
    client.arm().unwrap();
    let why = client.move_to(-2.0).unwrap_err().to_string();
    assert!(why.contains("-10 to 40 deg from the reference"), "{why}");
    client.move_to(40.0).unwrap();
    let why = client.set_reference(0.0).unwrap_err().to_string();
    assert!(why.contains("`stop` first"), "{why}");
}

/// A file of today has no `device.reference`. A joint without a range needs none.
#[test]
fn a_file_of_today_and_a_joint_without_a_range_arm_as_before() {
    for set in [&RANGE[..], &[COMMAND]] {
        let mut device = reset("srnf", set);
        assert_eq!(device.device.servo().arm_for_link(None), Ok(()), "{set:?}");
    }
    let mut simulated = SimulatedDevice::new(
        &plans("step-response", &["loop.controller=pd", RANGE[0], RANGE[1], COMMAND])[0],
    )
    .unwrap();
    simulated.ticks(20);
    assert_eq!(simulated.device.servo().arm_for_link(None), Ok(()), "it starts at zero");
}

#[test]
fn the_position_is_set_at_rest_with_the_output_off_and_an_encoder_that_is_trusted() {
    let mut device = with_range("pd");
    assert_eq!(device.device.servo().set_reference(1 << 30), Err(Refusal::TooFar));
    assert_eq!(device.device.servo().set_reference(i32::MIN), Err(Refusal::TooFar));
    assert_eq!(device.device.servo().set_reference((1 << 30) - 1), Ok(()));
    device.push(1.0, 100.0);
    device.ticks(2);
    assert_eq!(device.device.servo().set_reference(0), Err(Refusal::Moving));
    device.ticks(200);
    device.device.servo().set_reference(0).unwrap();
    jog(&mut device).unwrap();
    assert_eq!(device.device.servo().set_reference(0), Err(Refusal::Armed));
    device.device.servo().fault(Fault::Stall);
    device.ticks(100);
    assert_eq!(device.device.servo().set_reference(0), Err(Refusal::EncoderInDoubt));
}

/// A command that only says where the joint stands must not start it.
#[test]
fn the_reference_does_not_let_autostart_arm() {
    let set =
        [RANGE[0], RANGE[1], COMMAND, "device.autostart=true", "device.autostart_delay_s=0.1"];
    let parameters = srnf(&set);
    let hardware = files::hardware::STM32F405;
    for wait in [2, 200] {
        let mut servo = Servo::new(Ok(&parameters), Boot::default(), &hardware);
        let ticks = |servo: &mut Servo, count: u32| {
            (0..count).for_each(|_| {
                servo.tick(Input {
                    counter: 0,
                    supply: hardware.supply_top,
                    lines: 0,
                    ..Input::default()
                });
            });
            servo.state()
        };
        ticks(&mut servo, 4 + wait);
        assert_eq!(servo.set_reference(0), Ok(()));
        assert_eq!(ticks(&mut servo, 500), State::Stopped, "{wait}");
    }
    let at_zero = Boot { is_at_zero: true, ..Boot::default() };
    let mut servo = Servo::new(Ok(&parameters), at_zero, &hardware);
    let mut arms = |_| {
        servo.tick(Input { counter: 0, supply: hardware.supply_top, lines: 0, ..Input::default() });
        servo.state() == State::Armed
    };
    assert!((0..20).any(&mut arms), "a joint that is known to stand at zero");
}

/// The monitors add up what a silent encoder hides from one arming to the next. Setting the
/// position in between must not look like counts.
#[test]
fn a_client_that_sets_the_position_again_and_again_gains_no_effort_on_a_dead_encoder() {
    let armings = |law: &str, sets: bool| {
        let mut device = with_range(law);
        device.device.servo().set_reference(0).unwrap();
        device.wires = Wires::Cut;
        (1..=100).find(|k| {
            device.device.servo().arm_for_link(None).unwrap();
            device.tick();
            step(&mut device, 0.6);
            for _ in 0..30 {
                device.device.servo().heard();
                if let State::Faulted(fault) = device.tick().state {
                    assert_eq!(fault, Fault::Stall, "{law}");
                    return true;
                }
            }
            device.device.servo().stop();
            device.ticks(5);
            if sets {
                device.device.servo().set_reference(100 * k).unwrap();
            }
            false
        })
    };
    let mut several = 0;
    for law in controllers() {
        let found = armings(law, true);
        assert_eq!(found, armings(law, false), "{law}");
        several += u32::from(found.is_some_and(|found| found > 1));
    }
    assert!(several > 0, "what is added up decides under some law");
}
