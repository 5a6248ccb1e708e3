//! An encoder that is dead: how far the joint goes before the servo lets it go, under every law.
//!
//! Both wires are cut, so that the counter stands still whatever the joint does. The servo has the
//! limits that are derived for the thesis's robot (0.4 V start it, 0.38 V keep it moving).

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::control::reference::{Reference, Step};
use stiction::servo::{Output, State};
use stiction::units::position::Position;

use crate::fixture::plans;
use experiments::controllers;

/// Errors under which the encoder dies, deg: from ten counts to the full scale of PD.
const ERRORS: [f64; 9] = [0.025, 0.05, 0.1, 0.2, 0.35, 0.39, 0.41, 1.0, 5.0];

/// A friction that is known exactly: no effort up to it has to prove the encoder.
pub const EXACT: &str = "limits.breakaway_min_v=0.4";

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// The joint of the thesis's robot at rest under a law, armed by a link that goes on talking.
pub fn armed(law: &str) -> SimulatedDevice {
    armed_with(law, 1.0, &[])
}

/// The same with an output that is scaled by the supply, and with further keys. The factor is the
/// supply over the nominal one.
pub fn armed_with(law: &str, supply: f64, set: &[&str]) -> SimulatedDevice {
    let controller = format!("loop.controller={law}");
    let [nominal, range] = ["device.nominal_supply_v=12", "device.supply_full_scale_v=24"];
    let own = [&*controller, nominal, range, "reference.steps_deg=[5.0]"];
    let plan = &plans("step-response", &[&own, set].concat())[0];
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
    let (is_armed, output, _) = a_minute_with_its_way(device);
    (is_armed, output)
}

/// The same, with the way of a joint that had what was applied, deg, see [`coasted`].
fn a_minute_with_its_way(device: &mut SimulatedDevice) -> (bool, Output, f64) {
    let mut output = device.tick();
    let (mut way, mut speed) = (0.0, 0.0);
    for _ in 0..MINUTE {
        coasted(&mut way, &mut speed, f64::from(output.tick.v_applied).abs());
        device.device.servo().heard();
        output = device.tick();
        if output.state != State::Armed {
            break;
        }
    }
    (output.state == State::Armed, output, way)
}

/// Moves a joint on that has an effort of one sign (V) for a tick, and the thesis's slip friction,
/// but no viscous one: the thesis's own goes less far.
fn coasted(way: &mut f64, speed: &mut f64, effort: f64) {
    let (acceleration, tick) = (27.0 * (effort - 0.38), 0.02);
    let after = *speed + acceleration * tick;
    if after > 0.0 {
        *way += 0.5 * (*speed + after) * tick;
        *speed = after;
    } else {
        // It stops within the tick.
        *way += 0.5 * *speed * *speed / -acceleration;
        *speed = 0.0;
    }
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
        let mut cells = Vec::new();
        for error in ERRORS {
            let mut device = armed(law);
            device.wires = Wires::Cut;
            step(&mut device, error);
            let (is_armed, output, coasts) = a_minute_with_its_way(&mut device);
            let travel = device.position_deg().abs();
            if is_armed && law == "robust" {
                cells.push(format!("gives up at {travel:.1}"));
                gave_up(&output, travel, coasts, error);
                assert!(device.device.servo().has_given_up(), "{error} deg: it does not say so");
                continue;
            }
            cells.push(if is_armed { "rests".into() } else { format!("{travel:.1}") });
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
        let [a, b, c, d, e, f, g, h, i] = <[String; ERRORS.len()]>::try_from(cells).unwrap();
        reliability!("dead-encoder", law, a, b, c, d, e, f, g, h, i);
    }
}

/// `robust` pulses, and the joint moves, but after three strong pulses without a count it gives up.
/// Then it has no effort for ever, and the joint rests.
fn gave_up(output: &Output, travel: f64, coasts: f64, error: f64) {
    assert_eq!(output.tick.code, 0, "{error} deg: its hold effort is none");
    // What it has applied, all of it towards the target, moves a joint without viscous friction by
    // so much; up to 5 deg/s that friction is 0.1 V of 1 V and more.
    assert!((0.7 * coasts..coasts).contains(&travel), "{error} deg: {travel} of {coasts} deg");
    // No farther than a law that goes on.
    assert!(travel < pushed(0.45, 203.0), "{error} deg: {travel} deg");
}

#[test]
fn pulses_that_give_up_add_up_to_a_stall_over_the_next_motions() {
    // It gives up after three pulses of 1.5 times 1.03 V at least. Each of them counts as 1.145 V
    // for a tick: 0.069 V s in each motion at least, of 0.2 V s.
    let most = (0.2f64 / 0.069).ceil() as usize;
    for error in [0.025, 0.05, 0.1, 0.2, 0.35, 0.39, 0.41] {
        let mut device = armed("robust");
        device.wires = Wires::Cut;
        let mut furthest = 0.0f64;
        let faulted = (1..=most).find(|motion| {
            let from = device.position_deg();
            step(&mut device, if motion % 2 == 1 { error } else { -error });
            let (is_armed, output) = a_minute(&mut device);
            assert!(!is_armed || output.tick.code == 0, "{error} deg, motion {motion}");
            assert!(is_armed || output.state == State::Faulted(Fault::Stall), "{output:?}");
            furthest = furthest.max((device.position_deg() - from).abs());
            !is_armed
        });
        let motions = faulted.unwrap_or_else(|| panic!("{error} deg: armed after {most} motions"));
        // The pulses for a small error are small at first; the first test has what trips at once.
        assert!(motions > 1 || error > 0.3, "{error} deg: {motions} motions");
        // As far as one motion of a law that goes on.
        assert!(furthest > 0.1 && furthest < pushed(0.45, 203.0), "{error} deg: {furthest} deg");
        let furthest = format!("{furthest:.1}");
        reliability!("dead-pulses", error, motions, furthest);
    }
}

#[test]
fn pulses_that_never_give_up_end_in_a_stall() {
    // 0.2 V s are 10 V for a tick, and 2 V or more count as 1.6 V: seven ticks at least. Each pulse
    // is a fifth more than the last, so 0.32 V, the least one, and 13 more make that if each has
    // one tick; a pulse has six ticks with its rest, or two more.
    let set = ["loop.controller=robust", "controller.robust.give_up_attempts=0"];
    let plan = &plans("step-response", &[set[0], set[1], "reference.steps_deg=[5.0]"])[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.ticks(50);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    device.wires = Wires::Cut;
    step(&mut device, 0.025);
    let mut ticks = 0;
    let state = loop {
        device.device.servo().heard();
        ticks += 1;
        let state = device.tick().state;
        if state != State::Armed || ticks == MINUTE {
            break state;
        }
    };
    assert_eq!(state, State::Faulted(Fault::Stall), "{ticks}");
    assert!((7..=14 * 8).contains(&ticks), "{ticks}");
}

#[test]
fn a_constant_effort_leads_as_far_as_its_impulse_says() {
    // 0.4 V for every error within 0.4 deg, a code more than 0.4 V when it is rounded; and under
    // SRNF 0.4 V and the error, for its tanh is 1 by then.
    for (law, error, effort) in [("dnpf", 0.2, 0.4), ("srnf", 0.1, 0.5), ("srnf", 0.2, 0.6)] {
        let mut device = armed_with(law, 1.0, &[EXACT]);
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
            // It counts, but the joint is held: it cannot move until it is released.
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
        let mut device = armed_with("pd", supply, &[EXACT]);
        device.brake_v = 5.0;
        step(&mut device, 0.37);
        assert!(a_minute(&mut device).0, "{supply}");
    }
    // DNPF asks for 0.5 V, which is more, at a supply that is a quarter too high with the duty of
    // 0.4 V.
    for supply in [0.9, 1.0, 1.25] {
        let mut device = armed_with("dnpf", supply, &[EXACT]);
        (device.wires, device.brake_v) = (Wires::Cut, 5.0);
        step(&mut device, 0.5);
        let (_, output) = a_minute(&mut device);
        assert_eq!(output.state, State::Faulted(Fault::Stall), "{supply}");
    }
}
