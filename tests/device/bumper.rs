//! A soft bumper within the travel of an identification: how far the joint goes into it.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::identification::IdentificationRequest;
use stiction::servo::{Refusal, State};

use crate::fixture::plans;

/// Ticks of 20 ms in 300 s, the longest time of a sequence, and in the time for coming to rest.
const LONGEST: u32 = 15_000 + 500;

/// Four times the 0.4 V that start the joint: the sequence's bound of the effort unless a client
/// sets another. Half a code of 4.88 mV is for rounding.
const MOST_V: f64 = 1.6 + 0.0025;

/// Bound of the sequence's speed, deg/s.
const SPEED_DEG_PER_S: f64 = 10.0;

fn joint(set: &[&str]) -> SimulatedDevice {
    let set = [&["loop.controller=srnf", "reference.steps_deg=[5.0]"], set].concat();
    let mut device = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
    device.ticks(50);
    device
}

/// Begins a sequence with a travel, deg.
fn identify(device: &mut SimulatedDevice, travel_deg: f64) -> Result<(), Refusal> {
    let asked = IdentificationRequest {
        travel: Some(travel_deg as f32),
        speed: Some(SPEED_DEG_PER_S as f32),
        ..Default::default()
    };
    let plan = device.device.parameters().unwrap().identify(&asked).unwrap();
    device.device.servo().identify(&plan)
}

#[test]
fn a_sequence_that_runs_into_a_bumper_keeps_its_travel_and_its_effort_and_ends_as_a_stall() {
    for (begins_deg, v_per_deg) in [(3.0, 10.0), (3.0, 1.0), (3.0, 0.1), (1.0, 0.1), (0.02, 10.0)] {
        for travel_deg in [20.0, 45.0] {
            let mut device = joint(&[]);
            identify(&mut device, travel_deg).unwrap();
            let (mut furthest, mut effort_v) = (0.0f64, 0.0f64);
            for _ in 0..LONGEST {
                let at = device.position_deg();
                furthest = furthest.max(at.abs());
                device.load_v = -v_per_deg * (at - begins_deg).max(0.0);
                device.device.servo().heard();
                effort_v = effort_v.max(device.tick().tick.v_applied.abs().into());
            }
            let name = format!("{v_per_deg} V/deg from {begins_deg} deg, travel {travel_deg} deg");
            assert!(effort_v <= MOST_V, "{name}: {effort_v} V");
            // Energy, without friction: the effort and the speed of the arrival against the spring
            // (kappa 27 deg/s^2 per V).
            let pressed = MOST_V / v_per_deg;
            let speed = SPEED_DEG_PER_S * SPEED_DEG_PER_S / (27.0 * v_per_deg);
            let held = begins_deg + pressed + (pressed * pressed + speed).sqrt();
            assert!(furthest <= held.min(travel_deg), "{name}: {furthest} deg");
            let state = device.device.servo().state();
            assert_eq!(state, State::Faulted(Fault::Stall), "{name}");
            reliability!(
                "bumper",
                begins_deg,
                v_per_deg,
                travel_deg,
                furthest = format!("{furthest:.1}")
            );
        }
    }
}

#[test]
fn a_range_that_is_narrower_than_the_travel_refuses_the_sequence() {
    let range = ["limits.position_min_deg=-15", "limits.position_max_deg=15"];
    assert_eq!(identify(&mut joint(&range), 20.0), Err(Refusal::OutOfRange));
    assert_eq!(identify(&mut joint(&range), 14.0), Ok(()));
}
