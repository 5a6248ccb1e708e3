//! Lockstep: every count and every duty of the image is that of the host.

use emulator::{Emulation, first_difference};
use simulator::closed_loop::LoopSample;
use simulator::experiment::RunPlan;
use simulator::run::{RunResult, RunTrace, run_all};

use crate::common::{emulation, plans};

/// A tenth of the usual frequency, Hz, costs the emulator half of the time. What a law computes
/// does not depend on it. The laws of the thesis have the usual one in two tests, and those beyond
/// it on the trajectories.
const SLOW_PWM: &str = "drive.pwm_hz=2000";

fn assert_same(host: &RunResult, image: &RunResult) {
    let label = &host.plan.label;
    let (RunTrace::Loop(a), RunTrace::Loop(b)) = (&host.trace, &image.trace) else {
        panic!("{label} is a ramp")
    };
    if let Some(difference) = first_difference(a, b) {
        panic!("{label}: {difference}");
    }
    assert_eq!(a, b, "{label}: the joint's own motion");
    assert_eq!(host.events, image.events, "{label}");
    assert_eq!(host.metrics, image.metrics, "{label}");
    assert_eq!(
        (host.unstable, host.diverged_at_s),
        (image.unstable, image.diverged_at_s),
        "{label}"
    );
}

fn same_on_both(plans: &[RunPlan]) {
    assert_same_in(&emulation(), plans);
}

/// Asserts that an image does what the host does, bit for bit.
pub fn assert_same_in(emulation: &Emulation, plans: &[RunPlan]) {
    let host = run_all(plans).unwrap();
    let image = emulation.run_all(plans).unwrap();
    assert_eq!(host.len(), image.len());
    for (host, image) in host.iter().zip(&image) {
        assert_same(host, &image.result);
    }
}

/// The verdict on an edit within a minute: `cargo xtask image` runs this alone.
#[test]
fn first_look_every_law_begins_its_steps() {
    for laws in [&[][..], &["robust", "observer"]] {
        same_on_both(&plans("step-response", laws, &["run.duration_s=4", SLOW_PWM]));
    }
}

#[test]
fn seven_controllers_three_steps() {
    same_on_both(&plans("step-response", &[], &[]));
}

#[test]
fn seven_controllers_two_trajectories() {
    same_on_both(&plans("trajectory", &[], &[]));
}

/// Pulses, holds and attempts of `robust`, and its profile in motion.
#[test]
fn laws_beyond_the_thesis() {
    same_on_both(&plans("untuned-joints", &["robust", "observer"], &[SLOW_PWM]));
    same_on_both(&plans("trajectory", &["robust", "observer"], &["run.duration_s=6"]));
}

/// Five counts a second: `robust` follows them by pulses, and rests at their end.
#[test]
fn a_slow_ramp_is_followed_by_the_same_pulses() {
    let ramp = "reference.trajectories=[{corner_times_s=[0.5, 5.5], \
                corner_positions_deg=[0.0, 0.0605], half_blend_s=0.1}]";
    let plans = plans("trajectory", &["robust", "pd"], &[ramp, "run.duration_s=7", SLOW_PWM]);
    same_on_both(&plans);
    let pulses = |run: &RunResult| {
        let RunTrace::Loop(samples) = &run.trace else { panic!("{} is a ramp", run.plan.label) };
        let coasts = |sample: &&LoopSample| sample.time_s < 5.0 && sample.tick.law[0] == 3.0;
        samples.iter().filter(coasts).count()
    };
    let [robust, pd] = &run_all(&plans).unwrap()[..] else { panic!("two laws") };
    assert!(pulses(robust) > 20 && pulses(pd) == 0, "{} {}", pulses(robust), pulses(pd));
}

#[test]
fn a_sine_is_followed_by_the_same_bits() {
    let sine = "reference.sines=[{amplitude_deg=2.0, frequency_hz=0.4}]";
    let set = ["reference.trajectories=[]", sine, "run.duration_s=6", SLOW_PWM];
    let plans = plans("trajectory", &["robust", "srnf"], &set);
    same_on_both(&plans);
    // Friction takes each law's error to the other side at a turn; a joint at rest would keep it.
    for run in run_all(&plans).unwrap() {
        let most = run.metrics.max_error_deg.unwrap();
        assert!(most > 0.0 && most < 1.0, "{}: {most}", run.plan.label);
    }
}

#[test]
fn added_friction_and_wrong_gains() {
    for name in ["step-added-friction", "srnf-added-friction", "srnf-robustness"] {
        same_on_both(&plans(name, &[], &[SLOW_PWM]));
    }
    // Five times the gain, with and without a sample of delay: the first blend and two seconds of
    // the first flank.
    same_on_both(&plans("high-gain", &[], &["run.duration_s=3", SLOW_PWM]));
}

#[test]
fn a_disc_that_counts_down_and_one_that_does_not_rest_at_zero() {
    same_on_both(&plans(
        "step-response",
        &["srnf", "pd"],
        &[
            "run.duration_s=3",
            "encoder.direction=\"reverse\"",
            "encoder.phase=0.7",
            "encoder.counter_bits=32",
        ],
    ));
}

#[test]
fn a_sample_of_delay_and_a_millisecond_of_sample_time() {
    same_on_both(&plans("step-response", &["srnf"], &["run.duration_s=2", "run.delay_samples=1"]));
    same_on_both(&plans(
        "step-response",
        &["pd", "srnf"],
        &["run.duration_s=1", "loop.sample_time_s=0.001"],
    ));
}

#[test]
fn ten_thousand_ticks_a_second() {
    // The shortest sample time that a device takes. The joint sets out within the first 20 ms.
    let set = ["run.duration_s=0.2", "loop.sample_time_s=0.0001", "reference.steps_deg=[5.0]"];
    let plans = plans("step-response", &["pd", "srnf", "ri"], &set);
    same_on_both(&plans);
    for run in run_all(&plans).unwrap() {
        let RunTrace::Loop(moments) = &run.trace else { panic!("{} is a ramp", run.plan.label) };
        assert!(moments.len() == 2001 && moments[2000].position_deg > 0.1, "{}", run.plan.label);
    }
}

#[test]
fn sign_and_magnitude() {
    same_on_both(&plans(
        "step-response",
        &["pd", "dnpf"],
        &["run.duration_s=3", "drive.mode=sign-magnitude"],
    ));
}

#[test]
fn rk4_moves_the_joint_as_well() {
    same_on_both(&plans("step-response", &["pd"], &["run.duration_s=1", "run.solver=rk4"]));
}

#[test]
fn the_same_run_takes_the_same_instructions() {
    let plans = plans("step-response", &["srnf"], &["run.duration_s=1"]);
    let instructions = || {
        emulation()
            .run_all(&plans)
            .unwrap()
            .into_iter()
            .map(|run| run.instructions)
            .collect::<Vec<_>>()
    };
    let first = instructions();
    assert!(first.iter().all(|count| *count > 0));
    assert_eq!(first, instructions());
}
