//! Free-running: edges and PWM at their own times. That the duties are those of the core, fed with
//! the counts that the image has read, is checked in every run.

use simulator::run::{RunTrace, run_all};

use crate::common::{emulation, plans};

#[test]
fn the_metrics_stay_near_those_of_lockstep() {
    let mut plans = plans("step-response", &["pd", "srnf", "ri"], &["run.duration_s=4"]);
    // Unstable by design: a microsecond decides where it is after a second.
    plans.retain(|plan| plan.variant.is_empty());
    let lockstep = run_all(&plans).unwrap();
    let mut emulation = emulation();
    emulation.free_running = true;
    let free = emulation.run_all(&plans).unwrap();
    for (lockstep, free) in lockstep.iter().zip(&free) {
        let label = &lockstep.plan.label;
        let (a, b) = (&lockstep.metrics, &free.result.metrics);
        let (rms_a, rms_b) = (a.rms_error_deg.unwrap(), b.rms_error_deg.unwrap());
        // A latency of 30 us against a rise of 0.3 s.
        assert!((rms_a / rms_b - 1.0).abs() < 2e-3, "{label}: rms {rms_a} and {rms_b}");
        let (rest_a, rest_b) = (a.rest_error_counts.unwrap(), b.rest_error_counts.unwrap());
        // PD and SRNF come to rest once, from less than 25 deg/s, with an effort that comes 33 us
        // late: a third of a count, and the encoder's count. RI hunts by 12 counts around its
        // target (`reset_integral.rs`), and may be anywhere in that.
        let allowed = if label.starts_with("ri") { 12.0 } else { 1.4 };
        assert!((rest_a - rest_b).abs() <= allowed, "{label}: rest {rest_a} and {rest_b} counts");
        let RunTrace::Loop(moments) = &free.result.trace else { panic!("{label} is a ramp") };
        assert!(moments.iter().any(|moment| moment.position_deg != 0.0), "{label} does not move");
    }
}

#[test]
fn the_latency_is_that_of_the_pwm() {
    let plans = plans("step-response", &["pd"], &["run.duration_s=1"]);
    let mut emulation = emulation();
    emulation.free_running = true;
    for run in emulation.run_all(&plans).unwrap() {
        let latency = run.latency.unwrap();
        // Half a period of 22 kHz and the tick itself, neither more nor nothing.
        assert!((1.0..=22.8 + 10.0).contains(&latency.max_us), "{latency:?}");
        assert!((1.0..latency.max_us).contains(&latency.mean_us), "{latency:?}");
    }
}

/// Compares every controller's metrics with those of lockstep. That the replay agrees needs no line
/// here: a run in which it does not fails by itself. The PWM is a slow one, a twelfth of the
/// product's, for more latency.
fn assert_near_lockstep(name: &str, set: &[&str]) {
    let mut plans = plans(name, &[], &[&["drive.pwm_hz=2000"], set].concat());
    plans.retain(|plan| plan.variant.is_empty());
    let lockstep = run_all(&plans).unwrap();
    let mut emulation = emulation();
    emulation.free_running = true;
    for (lockstep, free) in lockstep.iter().zip(&emulation.run_all(&plans).unwrap()) {
        let (plan, latency_s) = (&lockstep.plan, free.latency.unwrap().max_us * 1e-6);
        // Half a period of the PWM, and the tick itself.
        assert!(latency_s < 250e-6 + 10e-6, "{}: latency {latency_s} s", plan.label);
        let RunTrace::Loop(moments) = &free.result.trace else {
            panic!("{} is a ramp", plan.label)
        };
        let speed =
            moments.iter().map(|moment| moment.velocity_deg_per_s.abs()).fold(0.0, f64::max);
        let (sample_s, count) =
            (plan.machine.sampling.sample_time_s(), plan.machine.encoder.resolution_deg());
        // An effort that comes so much later finds the joint so much further; the encoder
        // resolves a count.
        let late = speed * latency_s + count;
        // A compensator that is switched by a threshold may be switched a whole sample later.
        let smooth = matches!(plan.controller.as_deref(), Some("pd" | "feedforward" | "srnf"));
        let beyond = if smooth { late } else { speed * sample_s + count };
        let near = |what: &str, a: Option<f64>, b: Option<f64>, limit: f64| {
            let near = match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() <= limit,
                (a, b) => a == b,
            };
            assert!(near, "{}: {what} {a:?} and {b:?}, allowed {limit}", plan.label);
        };
        let (a, b) = (&lockstep.metrics, &free.result.metrics);
        near("overshoot", a.overshoot_deg, b.overshoot_deg, beyond);
        near("largest error", a.max_error_deg, b.max_error_deg, late);
        near("cruise error", a.cruise_error_deg, b.cruise_error_deg, late);
        if smooth {
            // It is a multiple of the sample time.
            near("settling time", a.settling_time_s, b.settling_time_s, 1.01 * sample_s);
        }
    }
}

#[test]
fn seven_controllers_three_steps() {
    assert_near_lockstep("step-response", &["run.duration_s=2"]);
}

#[test]
fn seven_controllers_two_trajectories() {
    // Until the end of the first flank: what comes back is its mirror.
    assert_near_lockstep("trajectory", &["run.duration_s=11.5"]);
}
