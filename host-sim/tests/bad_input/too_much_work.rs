//! Runs that would take too long or too much memory.

use super::refusal::{answer, assert_all_refused};
use super::stiction;

#[test]
fn a_run_that_would_take_for_ever_or_fill_the_memory_is_refused_before_it_begins() {
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["step-response", "--set", "run.duration_s=1e300"],
            &["`run.duration_s` is 1e300", "to 200000"],
        ),
        // This number of samples is allowed for one run, but not for all.
        (
            &["step-response", "--set", "run.duration_s=150000"],
            &["is 150000", "28 runs", "1e7 samples in all"],
        ),
        (
            &["step-response", "--solver", "rk4", "--set", "run.step_s=1e-300"],
            &["`run.step_s` is 1e-300", "1e10 steps"],
        ),
        (
            &["friction-identification", "--solver", "rk4", "--set", "run.step_s=1e-7"],
            &["`run.step_s` is 1e-7", "1e10 steps"],
        ),
        (
            &["friction-identification", "--set", "identification.ramp_rates_v_per_s=[1e-300]"],
            &["`identification.ramp_rates_v_per_s[0]` is 1e-300", "from 7.5e-6"],
        ),
        (
            &[
                "friction-identification",
                "--set",
                "identification.ramp_rates_v_per_s=[1e-5, 1.1e-5]",
            ],
            &["`identification.ramp_rates_v_per_s`", "1e8", "raise the rates"],
        ),
    ];
    assert_all_refused(cases.iter().map(|(arguments, fragments)| {
        let command = stiction(&[&["run"], *arguments].concat());
        (arguments.join(" "), command, fragments.to_vec())
    }));
    // The closed form makes no steps: their size is no reason to refuse it.
    let exact =
        stiction(&["run", "step-response", "--controller", "pd", "--set", "run.step_s=1e-300"]);
    assert!(answer(exact).unwrap().status.success());
}
