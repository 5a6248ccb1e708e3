//! The thesis's experiments run armed with the default thresholds, and none of them trips.

use host_sim::device::simulated::SimulatedDevice;
use host_sim::experiment::{Document, Motion, RunPlan, builtins};
use stiction::Fault;
use stiction::servo::{Arming, Output, State};

use crate::fixture::plans;

/// Runs the motion of a plan to its end, and returns the last output with the fault's value.
fn run(plan: &RunPlan) -> (Output, f32) {
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(10);
    simulated.device.servo().arm(Arming::Motion).unwrap();
    let ticks = (plan.duration_s() / simulated.sample_time_s()).round() as u32;
    let output = simulated.ticks(ticks);
    let value = simulated.device.servo().latched().map_or(0.0, |latched| latched.value);
    (output, value)
}

#[test]
fn no_default_threshold_stops_an_experiment() {
    // With the soft start of the default and, as in the thesis, with none.
    let (mut runs, mut tripped) = (0, Vec::new());
    // The friction lab's have no drive.
    let driven = builtins().iter().filter(|builtin| !Document::open(builtin.name).unwrap().is_lab());
    for (name, soft_start) in driven.flat_map(|b| [(b.name, "0.5"), (b.name, "0.0")]) {
        for plan in plans(name, &[&format!("device.soft_start_s={soft_start}")]) {
            if matches!(plan.motion, Motion::Ramp(_)) {
                continue;
            }
            let (output, value) = run(&plan);
            runs += 1;
            if output.state != State::Armed {
                tripped.push(format!("{name} {}: {:?} {value}", plan.label, output.state));
            }
        }
    }
    // Eq. 37 read in SI: an unstable loop between the limits of its output is what monitors are for.
    let (literal, others): (Vec<_>, Vec<_>) = tripped.iter().partition(|line| line.contains("literal-si"));
    assert!(others.is_empty(), "{others:#?}");
    assert_eq!(literal.len(), 14, "{literal:#?}");
    assert!(runs > 100, "{runs}");
}

/// The same thresholds that let the thesis pass do see a joint that is blocked.
#[test]
fn a_blocked_joint_trips_the_same_thresholds() {
    for plan in plans("step-response", &["reference.steps_deg=[5.0]", "device.soft_start_s=0.0"]) {
        let mut simulated = SimulatedDevice::new(&plan).unwrap();
        simulated.brake_v = 100.0;
        simulated.ticks(10);
        simulated.device.servo().arm(Arming::Motion).unwrap();
        assert_eq!(simulated.ticks(30).state, State::Faulted(Fault::Stall), "{}", plan.label);
    }
}
