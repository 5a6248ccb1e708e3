//! Free-running: edges and PWM at their own times. That the duties are those of the core, fed with the counts that the
//! image has read, is checked in every run.

use host_sim::run::{Trace, run_all};

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
        assert!((rest_a - rest_b).abs() < 30.0, "{label}: rest {rest_a} and {rest_b} counts");
        let Trace::Loop(moments) = &free.result.trace else { panic!("{label} is a ramp") };
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
