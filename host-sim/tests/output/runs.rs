//! Which runs there are, in which order, and what `--controller`, `--set`, `--delay` and `--solver`
//! do.

use stiction::compensator::Gains;

use super::{labels, number, run, runs};

/// The seven controllers that the thesis's experiments list: plain PD, and each of its six laws.
fn controllers() -> Vec<&'static str> {
    [&["pd"], &Gains::NAMES[..6]].concat()
}

#[test]
fn every_run_of_every_experiment_has_its_label() {
    let of = |names: &[&str], motions: &[&str], variants: &[&str]| -> Vec<String> {
        let mut labels = Vec::new();
        for variant in variants {
            for name in names {
                labels.extend(motions.iter().map(|motion| format!("{name}/{motion}{variant}")));
            }
        }
        labels
    };
    let speeds = ["trajectory-5.0", "trajectory-2.5"];
    let steps = of(&controllers(), &["step-5.0", "step-2.5", "step-1.0"], &[""]);
    let in_si = of(&controllers(), &["step-5.0"], &["/literal-si"]);
    let five = ["pd", "ri", "roi", "dnpf", "srnf"];
    let rates = ["rate-0.001", "rate-0.002", "rate-0.005", "rate-0.01", "rate-0.02"];
    for (experiment, expected) in [
        ("step-response", [steps, in_si].concat()),
        ("trajectory", of(&controllers(), &speeds, &[""])),
        (
            "step-added-friction",
            of(&["pd"], &["step-5.0"], &["/friction-1.25", "/friction-1.5", "/friction-2"]),
        ),
        ("srnf-robustness", of(&["srnf"], &speeds, &["/test-1", "/test-2", "/test-3", "/test-4"])),
        (
            "srnf-added-friction",
            of(
                &["srnf"],
                &speeds[1..],
                &["/added-0.1", "/added-0.2", "/added-0.4", "/added-variable"],
            ),
        ),
        ("high-gain", of(&five, &speeds, &["", "/delay-1"])),
        ("friction-identification", of(&["ramp"], &rates, &[""])),
    ] {
        assert_eq!(labels(&run(&[experiment])), expected, "{experiment}");
    }
}

#[test]
fn controllers_run_in_the_order_that_was_asked_for() {
    let steps = |names: [&str; 2]| {
        let report = run(&["step-response", "--controller", &names.join(",")]);
        labels(&report).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let expected = |[a, b]: [&str; 2]| {
        let motions = [(a, ""), (b, "")]
            .map(|(name, _)| ["5.0", "2.5", "1.0"].map(|deg| format!("{name}/step-{deg}")));
        let in_si = [a, b].map(|name| format!("{name}/step-5.0/literal-si"));
        [motions.concat(), in_si.to_vec()].concat()
    };
    for names in [["pd", "srnf"], ["srnf", "pd"]] {
        assert_eq!(steps(names), expected(names));
    }
    assert_eq!(steps(["pd", " srnf"]), expected(["pd", "srnf"]), "a space after the comma");
}

#[test]
fn a_key_that_is_set_is_used_and_leaves_out_the_variants_that_set_it_otherwise() {
    let all = run(&["srnf-robustness"]);
    assert_eq!(runs(&all).len(), 8);
    let set = ["controller.srnf.v_ms_v=0.4", "run.duration_s=24.5"];
    let report = run(&["srnf-robustness", "--set", set[0], "--set", set[1]]);
    // Tests 3 and 4 have v_ms = 0.4 (Table 18).
    let speeds = ["trajectory-5.0", "trajectory-2.5"];
    let expected = ["test-3", "test-4"]
        .map(|test| speeds.map(|speed| format!("srnf/{speed}/{test}")))
        .concat();
    assert_eq!(labels(&report), expected);
    for run in runs(&report) {
        assert_eq!(run["parameters"]["run"]["duration_s"], 24.5, "{}", run["label"]);
        assert_eq!(run["parameters"]["controller"]["v_ms_v"], 0.4, "{}", run["label"]);
        let last_s = run["events"].as_array().unwrap().last().map(|event| number(&event["time_s"]));
        assert!(last_s <= Some(24.5), "{}", run["label"]);
    }
    // A variant takes 5 for 5.0.
    let whole = run(&["step-response", "--controller", "pd", "--set", "reference.steps_deg=[5]"]);
    assert_eq!(labels(&whole), ["pd/step-5.0", "pd/step-5.0/literal-si"]);
    let other = run(&["step-response", "--controller", "pd", "--set", "reference.steps_deg=[4]"]);
    assert_eq!(labels(&other), ["pd/step-4.0"]);
}

#[test]
fn the_last_of_two_values_of_a_key_counts() {
    let arguments = ["trajectory", "--controller", "pd", "--set", "run.duration_s=25"];
    let report = run(&[&arguments[..], &["--set", "run.duration_s=24"]].concat());
    assert_eq!(runs(&report)[0]["parameters"]["run"]["duration_s"], 24.0);
    assert_eq!(runs(&run(&arguments))[0]["parameters"]["run"]["duration_s"], 25.0);
}

#[test]
fn a_sample_of_delay_is_in_the_label_and_in_the_motion() {
    let without = run(&["trajectory", "--controller", "srnf", "--delay", "0"]);
    let with = run(&["trajectory", "--controller", "srnf", "--delay", "1"]);
    assert_eq!(labels(&without), ["srnf/trajectory-5.0", "srnf/trajectory-2.5"]);
    assert_eq!(labels(&with), ["srnf/trajectory-5.0/delay-1", "srnf/trajectory-2.5/delay-1"]);
    assert_eq!(runs(&with)[0]["parameters"]["run"]["delay_samples"], 1);
    // What the first sample asks for takes effect at the second: the joint breaks away 20 ms later.
    let [early, late] =
        [&without, &with].map(|report| number(&runs(report)[0]["events"][0]["time_s"]));
    assert!((late - early - 0.02).abs() < 1e-9, "{early} and {late} s");
    // An experiment that has both kinds keeps the one that was asked for.
    assert_eq!(runs(&run(&["high-gain"])).len(), 20);
    let delayed = run(&["high-gain", "--delay", "1"]);
    assert_eq!(runs(&delayed).len(), 10);
    assert!(labels(&delayed).iter().all(|label| label.ends_with("/delay-1")));
}

#[test]
fn the_solver_that_was_asked_for_is_used_and_its_cost_is_counted() {
    let solved = |solver: &str| {
        let report = run(&["step-response", "--controller", "srnf", "--solver", solver]);
        let run = runs(&report)[0].clone();
        assert_eq!(run["parameters"]["run"]["solver"], solver);
        (
            run["cost"]["derivative_evaluations"].as_u64().unwrap(),
            number(&run["metrics"]["rms_error_deg"]),
        )
    };
    let ((exact, rms), (rk4, rms_by_steps)) = (solved("exact"), solved("rk4"));
    // RK4 solves 10 s by steps of 1e-5 s, with four evaluations each.
    assert_eq!((exact, rk4), (0, 4_000_000));
    assert!(
        (rms - rms_by_steps).abs() < 1e-3 && rms != rms_by_steps,
        "{rms} and {rms_by_steps} deg"
    );
}
