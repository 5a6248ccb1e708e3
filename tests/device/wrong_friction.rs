//! A file whose friction is too high, and an encoder that is silent: efforts between the lowest and
//! the highest breakaway may move the joint, and the encoder has to prove itself.
//!
//! The joint is the thesis's robot: 0.4 V start it, 0.38 V keep it moving. Travel is true travel
//! beyond start and target, coasting included.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::identification::IdentificationRequest;
use stiction::motion::jog::JogRequest;
use stiction::servo::{Refusal, State};

use crate::dead_encoder::{armed_with, step};
use crate::fixture::plans;
use experiments::controllers;

/// Breakaway efforts of a wrong file, V: what unknown friction derived once, and twice the truth.
const TOO_HIGH: [&str; 2] = ["limits.breakaway_v=1.25", "limits.breakaway_v=0.8"];

/// Ticks of 20 ms in a second.
const SECOND: u32 = 50;

/// Travel beyond start and target, deg, in a minute or until the joint is at rest after a fault.
fn beyond(device: &mut SimulatedDevice, to_deg: f64) -> (f64, State) {
    let mut beyond = 0.0f64;
    let mut state = State::Armed;
    for _ in 0..60 * SECOND {
        device.device.servo().heard();
        state = device.tick().state;
        let at = device.position_deg();
        beyond = beyond.max((at - to_deg.max(0.0)).max(to_deg.min(0.0) - at));
        if state != State::Armed && device.velocity_deg_per_s() == 0.0 {
            break;
        }
    }
    (beyond, state)
}

#[test]
fn a_silent_encoder_leads_no_further_than_its_bound_where_the_file_has_too_much_friction() {
    for too_high in TOO_HIGH {
        for law in controllers() {
            let mut furthest = 0.0f64;
            for to_deg in [0.3, 0.6, -0.6, 1.0, 1.2, 2.0, 5.0] {
                let mut device = armed_with(law, 1.0, &[too_high, "limits.breakaway_min_v=0.4"]);
                device.wires = Wires::Cut;
                step(&mut device, to_deg);
                let (beyond, state) = beyond(&mut device, to_deg);
                let name = format!("{too_high}, {law}, {to_deg} deg: {beyond} deg, {state:?}");
                assert!(beyond < 45.0, "{name}");
                let is_still = device.velocity_deg_per_s() == 0.0;
                assert!(
                    is_still && (state == State::Armed || state == State::Faulted(Fault::Stall)),
                    "{name}"
                );
                furthest = furthest.max(beyond);
            }
            reliability!("wrong-friction", too_high, law, beyond_deg = format!("{furthest:.1}"));
        }
    }
}

/// The truth lies between the two of the file, and PD and feedforward rest short of their target
/// for ever. One probe shows that the encoder lives; it is not repeated at that place.
#[test]
fn a_joint_that_rests_is_pushed_once_towards_its_target_and_trips_nothing_for_five_minutes() {
    for law in controllers() {
        for to_deg in [0.3, -0.3, 0.5, 2.0] {
            let rests = ["0.2", "0.8"].map(|lowest| {
                let lowest = format!("limits.breakaway_min_v={lowest}");
                let mut device = armed_with(law, 1.0, &["limits.breakaway_v=0.8", &lowest]);
                step(&mut device, to_deg);
                for tick in 0..300 * SECOND {
                    device.device.servo().heard();
                    let state = device.tick().state;
                    assert_eq!(state, State::Armed, "{law}, {to_deg} deg, tick {tick}");
                }
                device.position_deg()
            });
            // From 0.3 V to the 0.4 V that start it, the effort of a probe rises by 0.03 V a tick:
            // the joint moves for two ticks at most before its counts end the probe.
            let pushed = (rests[0] - rests[1]) * to_deg.signum();
            let short = matches!(law, "pd" | "feedforward") && to_deg.abs() < 1.0;
            let expected = if short { 2.0..20.0 } else { -15.0..15.0 };
            let pushed = pushed / 0.00242;
            assert!(expected.contains(&pushed), "{law}, {to_deg} deg: {pushed} counts, {rests:?}");
        }
    }
}

#[test]
fn without_any_friction_in_the_file_no_closed_loop_is_armed_and_open_ones_are() {
    let set = ["joint.friction.stick_v=0", "joint.friction.slip_v=0"];
    let plan = &plans("step-response", &[&["loop.controller=pd"], &set[..]].concat())[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.ticks(50);
    let parameters = device.device.parameters().unwrap().clone();
    let servo = device.device.servo();
    assert_eq!(servo.arm(), Err(Refusal::FrictionUnknown));
    assert_eq!(servo.arm_for_link(None), Err(Refusal::FrictionUnknown));
    for open in 0..3 {
        let servo = device.device.servo();
        match open {
            0 => servo.jog(parameters.jog(&JogRequest::default()).unwrap()),
            1 => servo.arm_for_link(Some(parameters.ramp(0.05, 1.0).unwrap())),
            _ => servo.identify(&parameters.identify(&IdentificationRequest::default()).unwrap()),
        }
        .unwrap();
        assert_eq!(device.tick().state, State::Armed);
        device.device.servo().stop();
        device.ticks(200);
    }
}
