//! An encoder that is dead: how far the joint goes before the servo lets it go, under every law.
//!
//! Both wires are cut, so that the counter stands still whatever the joint does. The servo has the
//! limits that are derived for the thesis's robot (0.4 V start it, 0.38 V keep it moving).

use host_sim::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::position::Position;
use stiction::reference::{Reference, Step};
use stiction::servo::{Output, State};

use crate::fixture::plans;
use experiments::controllers;

/// Errors under which the encoder dies, deg: from ten counts to the full scale of PD.
const ERRORS: [f64; 9] = [0.025, 0.05, 0.1, 0.2, 0.35, 0.39, 0.41, 1.0, 5.0];

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// The joint of the thesis's robot at rest under a law, armed by a link that goes on talking.
pub fn armed(law: &str) -> SimulatedDevice {
    armed_at(law, 1.0)
}

/// The same with an output that is scaled by the supply, which is so many times the nominal one.
fn armed_at(law: &str, supply: f64) -> SimulatedDevice {
    let controller = format!("loop.controller={law}");
    let [nominal, range] = ["device.nominal_supply_v=12", "device.supply_full_scale_v=24"];
    let set = [&controller, nominal, range, "reference.steps_deg=[5.0]"];
    let plan = &plans("step-response", &set)[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.supply = (2047.5 * supply).round() as u16;
    device.ticks(50);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    device
}

pub fn step(device: &mut SimulatedDevice, to_deg: f64) {
    let to = Position::from_counts((to_deg / 0.00242).round() as i32);
    let step = Step { from: Position::default(), to, at_tick: 0 };
    device.device.servo().follow(Reference::Step(step)).unwrap();
}

/// Lets a minute pass, or less if the servo is no longer armed; says whether it is and the last
/// output.
fn a_minute(device: &mut SimulatedDevice) -> (bool, Output) {
    let mut output = device.tick();
    for _ in 0..MINUTE {
        device.device.servo().heard();
        output = device.tick();
        if output.state != State::Armed {
            break;
        }
    }
    (output.state == State::Armed, output)
}

/// Where a joint at rest is after `ticks` ticks under a constant effort (V) that starts it, deg, in
/// closed form: Table 1 of the thesis has kappa 27 deg/s^2 per V, b 0.02 V s/deg, T_d 0.38 V.
fn pushed(effort: f64, ticks: f64) -> f64 {
    let (kappa, b, slip) = (27.0, 0.02, 0.38);
    let (time, tau) = (0.02 * ticks, 1.0 / (kappa * b));
    (effort - slip) / b * (time - tau * (1.0 - (-time / tau).exp()))
}

#[test]
fn an_encoder_that_is_dead_from_rest_is_seen_under_every_law_and_error() {
    for law in controllers() {
        let mut told = Vec::new();
        for error in ERRORS {
            let mut device = armed(law);
            device.wires = Wires::Cut;
            step(&mut device, error);
            let (is_armed, output) = a_minute(&mut device);
            let travel = device.position_deg().abs();
            told.push(if is_armed { "rests".into() } else { format!("{travel:.1}") });
            if is_armed {
                // The law asks for less than starts the joint, and may do so for ever.
                assert!(travel == 0.0, "{law}, {error} deg: armed after {travel} deg");
                assert!(
                    output.tick.v_applied.abs() <= 0.4,
                    "{law}, {error} deg: {:?}",
                    output.tick
                );
                continue;
            }
            assert_eq!(output.state, State::Faulted(Fault::Stall), "{law}, {error} deg");
            // Up to an eighth beyond 0.4 V trips after 4 s, and no effort takes longer; more leads
            // less far, since it is seen sooner. 8 deg, and a tick of coasting.
            assert!(travel < pushed(0.45, 203.0), "{law}, {error} deg: {travel} deg");
        }
        let [a, b, c, d, e, f, g, h, i] = <[String; ERRORS.len()]>::try_from(told).unwrap();
        reliability!("dead-encoder", law, a, b, c, d, e, f, g, h, i);
    }
}

#[test]
fn a_constant_effort_leads_as_far_as_its_impulse_says() {
    // 0.4 V for every error within 0.4 deg, a code more than 0.4 V when it is rounded; and under
    // SRNF 0.4 V and the error, for its tanh is 1 by then.
    for (law, error, effort) in [("dnpf", 0.2, 0.4), ("srnf", 0.1, 0.5), ("srnf", 0.2, 0.6)] {
        let mut device = armed(law);
        device.wires = Wires::Cut;
        step(&mut device, error);
        let (is_armed, _) = a_minute(&mut device);
        let code: f64 = (effort / 0.00488f64).round();
        // In codes; an eighth of 81 is 10. The tick that trips is not applied, but the joint coasts
        // in it.
        let ticks = (0.2 / (0.00488 * 0.02) / (code - 81.0).max(10.0)).floor();
        let travel = device.position_deg();
        // The soft start takes a part of the first two.
        let bounds = [pushed(code * 0.00488, ticks - 2.0), pushed(code * 0.00488, ticks + 1.0)];
        assert!(
            !is_armed && (bounds[0]..=bounds[1]).contains(&travel),
            "{law}, {error} deg: {travel} of {bounds:?}"
        );
    }
}

#[test]
fn pauses_and_another_arming_do_not_clear_an_impulse_and_counts_do() {
    // Each push of 0.6 V is 0.6 of what trips: 0.2 V for 0.6 s.
    let push = |device: &mut SimulatedDevice| {
        step(device, 0.2);
        let mut state = State::Armed;
        for _ in 0..30 {
            device.device.servo().heard();
            state = device.tick().state;
        }
        state
    };
    for is_dead in [true, false] {
        let mut device = armed("srnf");
        if is_dead {
            device.wires = Wires::Cut;
        } else {
            // It counts, but the joint is held: nobody moves it until it is let go.
            device.brake_v = 5.0;
        }
        assert_eq!(push(&mut device), State::Armed);
        device.device.servo().stop();
        device.ticks(100);
        if !is_dead {
            device.push(1.0, 0.0);
            device.ticks(100);
        }
        device.device.servo().arm_for_link(None).unwrap();
        device.tick();
        let expected = if is_dead { State::Faulted(Fault::Stall) } else { State::Armed };
        assert_eq!(push(&mut device), expected);
    }
}

#[test]
fn effort_is_that_at_the_nominal_supply_whatever_the_duty_is() {
    // PD asks for 0.37 V of a joint that 0.40 V start, for ever. At a supply that is a tenth too
    // low its duty is that of 0.41 V.
    for supply in [0.9, 1.0, 1.1] {
        let mut device = armed_at("pd", supply);
        device.brake_v = 5.0;
        step(&mut device, 0.37);
        assert!(a_minute(&mut device).0, "{supply}");
    }
    // DNPF asks for 0.5 V, which is more, at a supply that is a quarter too high with the duty of
    // 0.4 V.
    for supply in [0.9, 1.0, 1.25] {
        let mut device = armed_at("dnpf", supply);
        (device.wires, device.brake_v) = (Wires::Cut, 5.0);
        step(&mut device, 0.5);
        let (_, output) = a_minute(&mut device);
        assert_eq!(output.state, State::Faulted(Fault::Stall), "{supply}");
    }
}
