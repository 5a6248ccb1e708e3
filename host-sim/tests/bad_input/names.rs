//! Names of experiments, controllers and solvers that do not exist.

use super::refusal::assert_all_refused;
use super::stiction;

#[test]
fn names_that_do_not_exist_are_answered_with_the_nearest_or_with_all() {
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["run", "stepresponse"],
            &[
                "no experiment `stepresponse`",
                "must be one of spring-mass, ",
                "; did you mean `step-response`?",
            ],
        ),
        (&["show", "trajektory"], &["no experiment `trajektory`", "did you mean `trajectory`?"]),
        (&["run", "qwerty"], &["no experiment `qwerty`", "must be one of spring-mass, "]),
        (&["run", ""], &["no experiment ``", "must be one of spring-mass, "]),
        (
            &["run", "step-response", "--controller", "srnff"],
            &["--controller srnff: ", "`srnff` in step-response", "did you mean `srnf`?"],
        ),
        (
            &["run", "high-gain", "--controller", "xyz"],
            &["`xyz` in high-gain", "must be one of dnpf, pd, ri, roi, srnf"],
        ),
        (
            &["run", "step-response", "--controller", "pd,,ri"],
            &["--controller pd,,ri: ", "no controller ``"],
        ),
        (
            &["run", "step-response", "--controller", "pd,ri,pd"],
            &["--controller pd,ri,pd: ", "`pd` is listed twice"],
        ),
        (&["run", "friction-identification", "--controller", "srnf"], &["`srnf`", "must be pd"]),
        (
            &["run", "step-response", "--solver", "euler"],
            &["`run.solver` is \"euler\"", "must be one of exact, rk4"],
        ),
        (
            &["run", "step-response", "--delay", "2"],
            &["`run.delay_samples` is 2", "must be the whole number 0 or 1"],
        ),
    ];
    assert_all_refused(cases.iter().map(|(arguments, fragments)| {
        (arguments.join(" "), stiction(arguments), fragments.to_vec())
    }));
}
