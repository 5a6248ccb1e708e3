//! Every friction with an implicit step of its own on every built-in mechanism
//! (`spring-mass-revisited` is `spring-mass` cut short): time stepping goes through to the end with
//! steps of any length, and tends to what the solvers find that follow the differential equation.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

use simulator::experiment::Document;
use thesis::lab::{self, LabResult};

const EXPERIMENTS: [&str; 7] = [
    "spring-mass",
    "spring-mass-2dof",
    "spring-mass-independent",
    "manipulator-1dof",
    "manipulator-2dof",
    "square-wave",
    "triangle-wave",
];

fn run(experiment: &str, model: &str, solver: &str, more: &str) -> LabResult {
    let mut document = Document::open(experiment).unwrap();
    let set =
        [format!("run.friction=[{model:?}]"), format!("run.solver={solver}"), more.to_owned()];
    document.set(&set).unwrap();
    let [plan] = &lab::plan(&document).unwrap()[..] else { panic!("one run") };
    lab::run(plan).unwrap_or_else(|error| panic!("{error}"))
}

/// The farthest that any body has been from where it began.
fn travel(run: &LabResult) -> f64 {
    let all = run.rows.iter().flat_map(|row| &row.position);
    all.fold(0.0, |most: f64, position| most.max(position.abs()))
}

/// Largest difference of where the bodies end.
fn apart(a: &LabResult, b: &LabResult) -> f64 {
    let pairs = a.metrics.final_position.iter().zip(&b.metrics.final_position);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Backward Euler is of first order: a tenth of the step leaves a tenth of the error. Twice that is
/// let pass, since a step falls where it may about each break; and the reference is right to a
/// hundred times its tolerance.
#[test]
fn steps_of_a_tenth_bring_every_model_on_every_mechanism_nearer_to_the_located_solution() {
    for experiment in EXPERIMENTS {
        for model in ["tanh", "dahl", "lugre", "elastic-coulomb"] {
            let exact = run(experiment, model, "exact", "run.tolerance=1e-9");
            let stepped = |step_s: &str| {
                apart(&run(experiment, model, "nonsmooth", &format!("run.step_s={step_s}")), &exact)
            };
            // The first only has to come to its end: it is longer than the periods of some
            // bristles.
            let errors = ["1e-3", "1e-4", "1e-5"].map(stepped);
            let rounding = 1e-7 * travel(&exact);
            assert!(
                errors[2] < 0.2 * errors[1] + rounding && errors[2] < 0.01 * travel(&exact),
                "{experiment}, {model}: {errors:?}, of {}",
                travel(&exact)
            );
        }
    }
}

/// Its springs have no dampers: what rings on below the first element's limit, and when a ramp
/// breaks it loose, depends on the phase. So only the size of the difference from Runge-Kutta steps
/// is bounded, by a tenth of the travel.
#[test]
fn generalized_maxwell_slip_goes_through_on_every_mechanism() {
    for experiment in EXPERIMENTS {
        let reference = run(experiment, "maxwell-slip", "rk4", "run.step_s=1e-5");
        for (step_s, bound) in [("1e-3", f64::INFINITY), ("1e-5", 0.1)] {
            let stepped =
                run(experiment, "maxwell-slip", "nonsmooth", &format!("run.step_s={step_s}"));
            let part = apart(&stepped, &reference) / travel(&reference);
            assert!(part < bound, "{experiment}, {step_s}: {part}");
        }
    }
}
