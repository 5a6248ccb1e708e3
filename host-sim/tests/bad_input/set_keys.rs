//! Keys that a user sets on the command line by `--set`.

use super::refusal::assert_all_refused;
use super::{json, stiction};

#[test]
fn a_key_that_is_set_wrongly_is_named_with_what_was_found_and_what_is_allowed() {
    const STEP: &str = "step-response";
    const RAMP: &str = "friction-identification";
    let cases: &[(&str, &str, &[&str])] = &[
        // Not an assignment.
        (STEP, "joint", &["write it as table.key=value"]),
        (STEP, "=3", &["write it as table.key=value"]),
        (STEP, "joint=3", &["`joint` names no table", "table.key=value"]),
        (STEP, "title=3", &["`title` names no table", "table.key=value"]),
        (STEP, "joint..x=1", &["write it as table.key=value"]),
        (STEP, "run.duration_s=", &["no value after the `=`"]),
        (
            STEP,
            "run.duration_s=3\nrun.step_s=5",
            &["neither a number, a word, a quoted text nor a list"],
        ),
        (STEP, "loop.sample_time_s=0.02s", &["\"0.02s\" is neither a number"]),
        (STEP, "run.duration_s.x=1", &["`duration_s` in `run.duration_s.x` is not a table"]),
        // Unknown keys and names.
        (STEP, "a.b.c.d=1", &["unknown key `a`", "must be one of title", "joint", "variant"]),
        (
            STEP,
            "loop.sample_time_ms=20",
            &["unknown key `loop.sample_time_ms`", "`sample_time_s`?"],
        ),
        (STEP, "joint.inertia=3", &["unknown key `joint.inertia`", "gain_deg_per_s2_per_v"]),
        (STEP, "controller.pd.kp=1", &["unknown key `controller.pd.kp`", "`kp_v_per_deg`?"]),
        (STEP, "controller.pdd.kp_v_per_deg=1", &["no controller `pdd`", "did you mean `pd`?"]),
        (
            STEP,
            "controller.zzz.kp_v_per_deg=1",
            &["no controller `zzz`", "must be one of pd, ri, ", "srnf"],
        ),
        (
            STEP,
            "loop.controller=nope",
            &["`loop.controller` names `nope`", "`[controller.nope]`", "srnf"],
        ),
        (STEP, "run.solver=euler", &["`run.solver` is \"euler\"", "must be one of exact, rk4"]),
        (STEP, "encoder.rounding=neares", &["`encoder.rounding` is \"neares\"", "`nearest`?"]),
        (STEP, "controller.pd.laws=[\"foo\"]", &["`controller.pd.laws[0]` is \"foo\"", "srnf"]),
        // Wrong types and units.
        (
            STEP,
            "loop.sample_time_s=\"20 ms\"",
            &["`loop.sample_time_s` is \"20 ms\"", "must be a number"],
        ),
        (STEP, "controller.pd.kp_v_per_deg=abc", &["is \"abc\"; must be a number"]),
        (STEP, "controller.pd=3", &["`controller.pd` is 3; must be a table"]),
        (STEP, "joint.friction=3", &["`joint.friction` is 3; must be a table"]),
        (STEP, "reference.steps_deg=5", &["`reference.steps_deg` is 5; must be a list"]),
        (
            STEP,
            "reference.steps_deg=[\"a\"]",
            &["`reference.steps_deg[0]` is \"a\"; must be a number"],
        ),
        (STEP, "run.solver=3", &["`run.solver` is 3; must be a text"]),
        (STEP, "run.duration_s=1979-05-27", &["`run.duration_s` is 1979-05-27; must be a number"]),
        (
            STEP,
            "loop.controller=[3]",
            &["`loop.controller` is [3]", "a controller's name or a list of names"],
        ),
        (STEP, "loop.velocity_window=5.0", &["is 5.0; must be a whole number from 2 to 16"]),
        (STEP, "encoder.counter_bits=16.0", &["is 16.0; must be the whole number 16 or 32"]),
        (STEP, "goal.tolerance_deg=fine", &["`goal.tolerance_deg` is \"fine\"", "a number"]),
        (STEP, "goal.tolerance=1", &["unknown key `goal.tolerance`", "`tolerance_deg`?"]),
        (STEP, "goal.tolerance_deg=0", &["is 0; must be a finite number above 0"]),
        (STEP, "goal.settle_s=-0.5", &["is -0.5; must be a finite number above 0"]),
        (STEP, "goal.hold_s=inf", &["must be a finite number above 0"]),
        (STEP, "run.delay_samples=true", &["is true; must be the whole number 0 or 1"]),
        // Out of range.
        (
            STEP,
            "loop.sample_time_s=0",
            &["`loop.sample_time_s` is 0; must be a number above 0, up to 1"],
        ),
        (STEP, "loop.sample_time_s=-0.02", &["`loop.sample_time_s` is -0.02", "above 0"]),
        (STEP, "loop.sample_time_s=nan", &["`loop.sample_time_s` is NaN", "above 0"]),
        (STEP, "loop.sample_time_s=1e-300", &["is 1e-300, which is 0 in single precision"]),
        (
            STEP,
            "loop.velocity_window=0",
            &["`loop.velocity_window` is 0", "a whole number from 2 to 16"],
        ),
        (
            STEP,
            "loop.velocity_window=-3",
            &["`loop.velocity_window` is -3", "a whole number from 2 to 16"],
        ),
        (
            STEP,
            "loop.velocity_window=17",
            &["`loop.velocity_window` is 17", "a whole number from 2 to 16"],
        ),
        (
            STEP,
            "loop.velocity_window=1000000000",
            &["is 1000000000", "a whole number from 2 to 16"],
        ),
        (STEP, "joint.gain_deg_per_s2_per_v=-27", &["is -27; must be a number above 0"]),
        (STEP, "joint.gain_deg_per_s2_per_v=inf", &["is inf; must be a finite number above 0"]),
        (STEP, "joint.viscous_v_per_deg_per_s=-1", &["is -1; must be a number not below 0"]),
        (STEP, "joint.friction.slip_v=-1", &["`joint.friction.slip_v` is -1", "not below 0"]),
        (
            STEP,
            "joint.friction.stick_v=0.1",
            &["is 0.1; must be a number not below `slip_v` (0.38)"],
        ),
        (STEP, "joint.friction.added_v=-1", &["is -1; must be a number not below -0.38"]),
        (
            STEP,
            "joint.friction.added_during_s=[[3,1]]",
            &["`joint.friction.added_during_s[0]` is [3, 1]", "later"],
        ),
        (
            STEP,
            "joint.friction.added_during_s=[[0,1],[nan,3]]",
            &["`joint.friction.added_during_s[1]`", "NaN"],
        ),
        (
            STEP,
            "joint.friction.added_during_s=[[3]]",
            &["`joint.friction.added_during_s[0]`", "must have 2"],
        ),
        (
            STEP,
            "controller.pd.kp_v_per_deg=nan",
            &["`controller.pd.kp_v_per_deg` is NaN", "from 0 to 1000000"],
        ),
        (
            STEP,
            "controller.pd.kp_v_per_deg=-1",
            &["`controller.pd.kp_v_per_deg` is -1", "from 0 to 1000000"],
        ),
        (
            STEP,
            "controller.pd.kp_v_per_deg=1e300",
            &["`controller.pd.kp_v_per_deg` is 1e300", "from 0"],
        ),
        (
            STEP,
            "controller.srnf.alpha_per_deg=nan",
            &["`controller.srnf.alpha_per_deg` is NaN", "from 0"],
        ),
        (STEP, "controller.pd.v_ms_v=nan", &["`controller.pd.v_ms_v` is NaN", "not below 0"]),
        (
            STEP,
            "controller.pd.laws=[\"ri\"]",
            &[
                "`controller.pd.ki_v_per_deg_s`, `controller.pd.theta_ri_deg` are missing; the law ri",
            ],
        ),
        (STEP, "controller.ri.laws=[\"ri\",\"ri\"]", &["`controller.ri.laws[1]`", "repeats a law"]),
        (
            STEP,
            "controller.ri.laws=[\"ri\",\"rvi\"]",
            &["`controller.ri.laws` has ri and rvi", "only one"],
        ),
        (
            STEP,
            "encoder.resolution_deg=0",
            &["`encoder.resolution_deg` is 0; must be a number above 0"],
        ),
        (STEP, "encoder.counter_bits=17", &["`encoder.counter_bits` is 17; must be one of 16, 32"]),
        (STEP, "encoder.counter_bits=-1", &["`encoder.counter_bits` is -1; must be one of 16, 32"]),
        (
            STEP,
            "encoder.counter_bits=1000",
            &["`encoder.counter_bits` is 1000; must be one of 16, 32"],
        ),
        (
            STEP,
            "encoder.phase=inf",
            &["`encoder.phase` is inf; must be a finite number from -1 to 1"],
        ),
        (STEP, "drive.pwm_hz=0", &["`drive.pwm_hz` is 0; must be a number from 1300 to 5250000"]),
        (STEP, "drive.lsb_v=0", &["`drive.lsb_v` is 0; must be a number above 0.00015"]),
        (
            STEP,
            "drive.full_scale_v=1e300",
            &["`drive.full_scale_v` is 1e300; must be a number above 0"],
        ),
        (
            STEP,
            "run.delay_samples=2",
            &["`run.delay_samples` is 2; must be the whole number 0 or 1"],
        ),
        (STEP, "run.delay_samples=-1", &["`run.delay_samples` is -1", "0 or 1"]),
        (STEP, "run.step_s=0", &["`run.step_s` is 0; must be a number above 0"]),
        (STEP, "run.step_s=nan", &["`run.step_s` is NaN; must be a number above 0"]),
        (STEP, "run.duration_s=nan", &["`run.duration_s` is NaN; must be a number from 0.02"]),
        (STEP, "run.duration_s=0.001", &["`run.duration_s` is 0.001; must be a number from 0.02"]),
        // Steps.
        (
            STEP,
            "reference.steps_deg=[]",
            &["nothing to run", "add an entry", "`reference.steps_deg`"],
        ),
        (
            STEP,
            "reference.steps_deg=[5.0, 0.0]",
            &["`reference.steps_deg[1]` is 0", "other than 0"],
        ),
        (
            STEP,
            "reference.steps_deg=[1e12]",
            &["`reference.steps_deg[0]` is 1000000000000", "2^30 counts"],
        ),
        (STEP, "reference.steps_deg=[nan]", &["`reference.steps_deg[0]` is NaN", "2^30 counts"]),
        (
            STEP,
            "reference.steps_deg=[5, 5]",
            &["`pd/step-5.0`", "need different sizes, speeds and slugs"],
        ),
        (STEP, "loop.controller=[]", &["`loop.controller` is empty", "at least one name"]),
        (STEP, "loop.controller=[\"pd\", \"pd\"]", &["`loop.controller` names `pd` twice"]),
        // Ramps.
        (STEP, "identification.hold_s=3", &["`identification.ramp_rates_v_per_s` is missing"]),
        (RAMP, "identification.ramp_rates_v_per_s=[]", &["nothing to run"]),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[0]",
            &["`identification.ramp_rates_v_per_s[0]` is 0", "to 250"],
        ),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[-1]",
            &["is -1; must be a number from", "to 250"],
        ),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[nan]",
            &["is NaN; must be a number from", "to 250"],
        ),
        (
            RAMP,
            "identification.ramp_rates_v_per_s=[1e300]",
            &["is 1e300; must be a number from", "to 250"],
        ),
        (
            RAMP,
            "identification.hold_s=nan",
            &["`identification.hold_s` is NaN; must be a number from 0"],
        ),
        (
            RAMP,
            "identification.hold_s=-1",
            &["`identification.hold_s` is -1; must be a number from 0"],
        ),
        (RAMP, "run.duration_s=nan", &["`run.duration_s` is NaN; must be a number above 0"]),
        // A variant sets it.
        ("srnf-robustness", "controller.srnf.v_ms_v=0.3", &["cannot be set", "every variant"]),
    ];
    assert_all_refused(cases.iter().map(|(experiment, assignment, fragments)| {
        let typed = ["", assignment.lines().next().unwrap()];
        let command = stiction(&["run", experiment, "--set", assignment]);
        (typed.concat(), command, [&typed, *fragments].concat())
    }));
}

#[test]
fn a_key_that_no_longer_goes_with_one_that_was_set_is_named_with_both() {
    let cases: &[(&str, &[&str])] = &[
        ("joint.friction.slip_v=0.5", &["`joint.friction.stick_v` is 0.4", "`slip_v` (0.5)"]),
        ("loop.sample_time_s=1e-9", &["`run.duration_s` is 10", "1e-9 (one sample) to 0.01"]),
    ];
    assert_all_refused(cases.iter().map(|(assignment, fragments)| {
        let command = stiction(&["run", "step-response", "--set", assignment]);
        let origin = ["step-response with ", assignment];
        ((*assignment).to_owned(), command, [&origin, *fragments].concat())
    }));
}

#[test]
fn values_at_the_edge_of_what_is_allowed_are_taken() {
    for assignment in [
        "loop.velocity_window=2",
        "loop.velocity_window=16",
        "loop.sample_time_s=1",
        "encoder.counter_bits=32",
        "encoder.phase=-1",
        "run.delay_samples=1",
        "run.duration_s=0.02",
        "run.step_s=1e300",
        "drive.pwm_hz=1300",
        "drive.lsb_v=5",
        "joint.viscous_v_per_deg_per_s=0",
        "joint.friction.slip_v=0",
        "joint.friction.stick_v=0.38",
        "joint.friction.added_v=-0.38",
        "joint.friction.added_during_s=[]",
        "controller.pd.kp_v_per_deg=0",
        "controller.pd.kp_v_per_deg=1000000",
        "controller.pd.laws=[]",
        "reference.steps_deg=[-5, 0.0001]",
        "run.duration_s = 1 # with a comment",
        "run.solver=\"rk4\"",
        "loop.controller=pd",
    ] {
        let output = stiction(&["run", "step-response", "--controller", "pd", "--set", assignment])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.is_empty(), "{assignment}: {said}");
    }
    // Two keys that need each other may be set one after the other.
    let ramp = ["identification.hold_s=3", "identification.ramp_rates_v_per_s=[0.02]"];
    let both = json(&[
        "run",
        "step-response",
        "--controller",
        "pd",
        "--json",
        "--set",
        ramp[0],
        "--set",
        ramp[1],
    ]);
    assert!(both["runs"].as_array().unwrap().iter().any(|run| run["label"] == "ramp/rate-0.02"));
}
