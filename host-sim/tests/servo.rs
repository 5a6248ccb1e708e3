//! `run --target servo` runs the servo around the loop, on the host.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use simulator::closed_loop::LoopSample;
use simulator::experiment::{Document, Experiment, RunPlan};
use simulator::run::{RunDriver, RunResult, RunTrace, run, run_driven};

fn plan(name: &str, controller: &str, set: &[&str]) -> RunPlan {
    let mut document = Document::open(name).unwrap();
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
    let wanted: Vec<String> =
        [controller].iter().filter(|name| !name.is_empty()).map(|n| n.to_string()).collect();
    Experiment::plan(&document, &wanted, &[]).unwrap().runs.remove(0)
}

fn moments(result: &RunResult) -> &[LoopSample] {
    match &result.trace {
        RunTrace::Loop(moments) => moments,
        RunTrace::Ramp(_) => panic!("a ramp"),
    }
}

#[test]
fn without_a_soft_start_the_servo_does_what_the_bare_loop_does() {
    for controller in ["pd", "ri", "srnf"] {
        // The encoder's disc is a count further where the joint rests, so that the servo's zero is
        // not the host's.
        let set = ["device.soft_start_s=0", "reference.steps_deg=[2.5]", "encoder.phase=-0.6"];
        let plan = plan("step-response", controller, &set);
        let (bare, servo) = (run(&plan).unwrap(), run_driven(&plan, RunDriver::ByServo).unwrap());
        assert_eq!(servo.fault, None);
        assert_eq!(moments(&bare).len(), moments(&servo).len());
        for (bare, servo) in moments(&bare).iter().zip(moments(&servo)) {
            assert_eq!(
                (bare.tick.code, bare.tick.counts),
                (servo.tick.code, servo.tick.counts),
                "{controller}"
            );
            assert_eq!(bare.reference_deg, servo.reference_deg);
            assert_eq!(bare.position_deg.to_bits(), servo.position_deg.to_bits());
        }
    }
}

#[test]
fn a_soft_start_is_seen_in_what_is_applied_and_not_in_what_is_asked_for() {
    let plan =
        plan("step-response", "srnf", &["device.soft_start_s=0.5", "reference.steps_deg=[5.0]"]);
    let result = run_driven(&plan, RunDriver::ByServo).unwrap();
    // This holds as long as the loop asks for more than the limit: on the way it asks for less.
    let limited: Vec<&LoopSample> =
        moments(&result).iter().take_while(|moment| moment.tick.saturated).collect();
    assert!(limited.len() > 10, "{}", limited.len());
    for (k, moment) in limited.into_iter().enumerate() {
        // The limit rises by 5 V in 25 ticks of 20 ms, in steps of the D/A.
        let limit_v = 0.2 * k as f64;
        assert!(moment.applied_v <= limit_v + 1e-9 && moment.applied_v > limit_v - 0.005, "{k}");
        assert!(f64::from(moment.tick.v) > limit_v, "{k}");
        assert!((f64::from(moment.tick.v_applied) - moment.applied_v).abs() < 1e-6);
    }
}

#[test]
fn a_fault_turns_the_output_off_and_is_reported_with_its_time() {
    let set = ["limits.overspeed_deg_per_s=5", "reference.steps_deg=[5.0]"];
    let result = run_driven(&plan("step-response", "srnf", &set), RunDriver::ByServo).unwrap();
    let fault = result.fault.unwrap();
    assert_eq!((fault.code, fault.name), (17, "overspeed"));
    assert!(fault.value > 5.0 && fault.value < 8.0, "{fault:?}");
    let after = moments(&result).iter().filter(|moment| moment.time_s >= fault.time_s);
    assert!(after.clone().count() > 100);
    for moment in after {
        assert_eq!((moment.applied_v, moment.tick.code), (0.0, 0));
        // What was asked for stays asked for, and the encoder goes on.
        assert!((moment.reference_deg - 5.0).abs() < 0.00242);
        assert!((f64::from(moment.tick.counts) * 0.00242 - moment.position_deg).abs() < 0.00242);
    }
    let before = moments(&result).iter().rfind(|moment| moment.time_s < fault.time_s).unwrap();
    assert!(before.tick.code != 0);
}

/// The ramp's readings are of the effort of the same sample, in the simulator as in the image.
#[test]
fn a_ramp_has_no_delay() {
    let rate = "identification.ramp_rates_v_per_s=[0.05]";
    let levels = |delay: &str| {
        let result = run(&plan("friction-identification", "", &[rate, delay])).unwrap();
        (result.metrics.stick_v, result.metrics.slip_v)
    };
    let at_once = levels("run.delay_samples=0");
    assert!(at_once.0.is_some() && at_once.1.is_some());
    assert_eq!(levels("run.delay_samples=1"), at_once);
}
