//! The motor loses its supply for a while, and no converter shows it: the effort does not reach the
//! joint.
//!
//! The servo has the limits that are derived for the thesis's robot. A joint without torque coasts,
//! whatever the servo asks for: it decelerates by its slip friction at least.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::servo::State;

use crate::dead_encoder::{armed, step};
use experiments::controllers;

/// Ticks of 20 ms in a second.
const SECOND: u32 = 50;

/// Effort that starts the joint, V: `breakaway_v` and the truth.
const BREAKAWAY_V: f64 = 0.4;

/// Steps (deg), and the ticks after which the supply is lost: at rest, in motion, and on target.
const CASES: [(f64, u32); 9] = [
    (0.5, 0),
    (2.0, 0),
    (5.0, 0),
    (5.0, 20),
    (20.0, 20),
    (20.0, 40),
    (40.0, 40),
    (40.0, 80),
    (5.0, 100),
];

/// Runs a tick of a link that goes on talking, and returns the effort (V) of an armed servo.
fn effort(device: &mut SimulatedDevice) -> Option<f64> {
    device.device.servo().heard();
    let output = device.tick();
    (output.state == State::Armed).then(|| f64::from(output.tick.v_applied).abs())
}

/// Brings a joint to the moment at which its supply is lost.
fn unpowered(law: &str, (to_deg, after): (f64, u32)) -> Option<SimulatedDevice> {
    let mut device = armed(law);
    step(&mut device, to_deg);
    let is_armed = (0..after).all(|_| effort(&mut device).is_some());
    device.is_unpowered = true;
    is_armed.then_some(device)
}

/// Where a joint comes to rest without torque (deg), in closed form from Table 1 of the thesis:
/// kappa is 27 deg/s^2 per V, and T_d 0.38 V. Viscous friction shortens the way.
fn coasts_to(device: &SimulatedDevice) -> f64 {
    let speed = device.velocity_deg_per_s();
    device.position_deg() + speed * speed.abs() / (2.0 * 27.0 * 0.38)
}

#[test]
fn a_joint_without_a_supply_that_stands_under_effort_is_a_stall_within_a_second() {
    for law in controllers() {
        let mut slowest = 0;
        for case in CASES {
            // Overspeed and following error end some of these bare steps before the loss.
            let Some(mut device) = unpowered(law, case) else { continue };
            let (mut ticks, mut is_pushed) = (0, false);
            for _ in 0..10 * SECOND {
                let Some(effort) = effort(&mut device) else { break };
                let stands = device.velocity_deg_per_s() == 0.0;
                is_pushed |= stands && effort > BREAKAWAY_V;
                ticks += u32::from(stands && effort > 1.25 * BREAKAWAY_V);
            }
            let state = device.device.servo().state();
            assert!(ticks <= SECOND, "{law}, {case:?}: {ticks} ticks");
            match state {
                State::Faulted(Fault::Stall) => slowest = slowest.max(ticks),
                // A bare step beyond the speed that its limits allow: the error grows as it coasts.
                State::Faulted(Fault::FollowingError) => assert!(case.0 > 2.0, "{law}, {case:?}"),
                // A law that is on target asks for nothing.
                _ => assert!(!is_pushed && case.1 == 100, "{law}, {case:?}: {state:?}"),
            }
        }
        reliability!("no-supply", law, slowest_s = format!("{:.2}", 0.02 * f64::from(slowest)));
    }
}

#[test]
fn a_supply_that_returns_after_a_second_leads_no_farther_than_coasting_does() {
    for law in controllers() {
        for case in CASES {
            let Some(mut device) = unpowered(law, case) else { continue };
            let rest = coasts_to(&device);
            let (mut is_armed, mut furthest) = (true, 0.0f64);
            for tick in 0..10 * SECOND {
                device.is_unpowered = tick < SECOND;
                is_armed &= effort(&mut device).is_some();
                furthest = furthest.max(device.position_deg());
            }
            // Two degrees: under PD and the observer, a bare step of 20 deg overshoots.
            assert!(furthest <= rest.max(case.0 + 2.0), "{law}, {case:?}: {furthest} deg");
            let left = (device.position_deg() - case.0).abs();
            assert!(!is_armed || left < 0.4, "{law}, {case:?}: {left} deg from the target");
        }
    }
}
