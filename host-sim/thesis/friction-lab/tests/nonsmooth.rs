//! Time stepping without located events: against the exact solver, with its order of convergence
//! measured, across events.

use dynamics::friction::{Coulomb, SetValued};
use dynamics::mechanism::Mechanism;
use friction_lab::friction::{Dahl, ElasticCoulomb, Implicit, LuGre, MaxwellSlip, Stribeck, Tanh};
use friction_lab::mechanism::Pendulum;
use friction_lab::solver::dynamics::SingleValuedDynamics;
use friction_lab::solver::state::{BodyEvent, BodySample, Finish, Observer};
use friction_lab::solver::{event_driven, fixed_step, nonsmooth};

use super::common::{
    ARM, ARM_LEVELS, COUPLED, COUPLED_LEVELS, INDEPENDENT_LEVELS, PENDULUM, PENDULUM_LEVELS,
    SPRING_MASS, SPRING_MASS_LEVELS, exact, independent,
};

/// Contacts without an event.
fn quiet() -> Vec<BodyEvent> {
    Vec::new()
}

fn stepped<const N: usize, M: Mechanism<N>, F: SetValued>(
    mechanism: &M,
    friction: &[F; N],
    step_s: f64,
    duration_s: f64,
) -> (Vec<BodyEvent>, Finish<N>) {
    let mut events = Vec::new();
    let finish = nonsmooth::run(mechanism, friction, step_s, duration_s, &mut events).unwrap();
    (events, finish)
}

/// The slope of log error over log step, by least squares over steps of `first_s` and its halves.
fn order(first_s: f64, halvings: i32, error: impl Fn(f64) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = (0..=halvings)
        .map(|i| first_s * 0.5_f64.powi(i))
        .map(|h| (h.ln(), error(h).ln()))
        .collect();
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let (mut above, mut below) = (0.0, 0.0);
    for (x, y) in &points {
        above += (x - mean.0) * (y - mean.1);
        below += (x - mean.0).powi(2);
    }
    above / below
}

fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_error_falls_like_the_step_across_breaks_sticks_and_reversals() {
    fn of<const N: usize>(
        name: &str,
        mechanism: &impl Mechanism<N>,
        levels: &[Coulomb; N],
        duration_s: f64,
    ) {
        let (_, reference) = exact(mechanism, levels, 1e-11, duration_s);
        let order = order(1.25e-4, 4, |h| {
            distance(&stepped(mechanism, levels, h, duration_s).1.q, &reference.q)
        });
        assert!((0.9..1.1).contains(&order), "{name}: order {order}");
    }
    of("spring and mass", &SPRING_MASS, &SPRING_MASS_LEVELS, 4.5);
    of("pendulum", &PENDULUM, &PENDULUM_LEVELS, 5.0);
    of("arm", &ARM, &ARM_LEVELS, 5.0);
    of("coupled blocks", &COUPLED, &COUPLED_LEVELS, 0.5);
    of("independent blocks", &independent(), &INDEPENDENT_LEVELS, 0.7);
}

/// The coupled blocks break and stick within the same steps, and one reversal is a stick or not by
/// a hair.
#[test]
fn events_are_the_exact_solver_s_in_its_order() {
    fn of<const N: usize>(mechanism: &impl Mechanism<N>, levels: &[Coulomb; N], duration_s: f64) {
        let (expected, _) = exact(mechanism, levels, 1e-10, duration_s);
        let h = 1e-5;
        let (events, _) = stepped(mechanism, levels, h, duration_s);
        let what = |events: &[BodyEvent]| -> Vec<_> {
            let mut what: Vec<_> = events.iter().map(|e| (e.body, e.kind)).collect();
            // One step of order is not reported.
            what.sort_by_key(|(body, _)| *body);
            what
        };
        assert_eq!(what(&events), what(&expected));
        for body in 0..N {
            let of_body = |events: &[BodyEvent]| -> Vec<f64> {
                events.iter().filter(|e| e.body == body).map(|e| e.time_s).collect()
            };
            for (found, expected) in of_body(&events).iter().zip(of_body(&expected)) {
                assert!((found - expected).abs() < 100.0 * h, "{found}, not {expected}");
            }
        }
    }
    of(&SPRING_MASS, &SPRING_MASS_LEVELS, 5.0);
    of(&PENDULUM, &PENDULUM_LEVELS, 5.0);
    of(&ARM, &ARM_LEVELS, 5.0);
    of(&independent(), &INDEPENDENT_LEVELS, 0.7);
}

/// Keeps every sample.
struct Trace<const N: usize>(Vec<BodySample<N>>);

impl<const N: usize> Observer<N> for Trace<N> {
    fn sample(&mut self, sample: &BodySample<N>) {
        self.0.push(*sample);
    }

    fn event(&mut self, _: BodyEvent) {}
}

#[test]
fn set_valued_stribeck_friction_rests_at_exactly_zero() {
    let friction =
        [Stribeck { speed: 2e-3, ..Stribeck::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1) }];
    let mut trace = Trace(Vec::new());
    nonsmooth::run(&SPRING_MASS, &friction, 1e-4, 3.0, &mut trace).unwrap();
    let (mut stuck, mut slipping) = (0, 0);
    for pair in trace.0.windows(2) {
        let sample = pair[1];
        match (pair[0].slip[0], sample.slip[0]) {
            (0, 0) => {
                let spring = SPRING_MASS.terms(sample.time_s, &sample.q, &[0.0]).force[0];
                assert!(sample.v == [0.0] && sample.a == [0.0], "{sample:?}");
                assert!(
                    (sample.friction[0] - spring).abs() < 1e-14 && spring.abs() <= 0.25,
                    "{sample:?}"
                );
                stuck += 1;
            }
            (_, 1) => {
                assert!(sample.v[0] > 0.0, "{sample:?}");
                assert!(
                    sample.friction[0] > 0.2 - 1e-12 && sample.friction[0] < 0.25 + 1e-12,
                    "{sample:?}"
                );
                slipping += 1;
            }
            // In the step in which it comes to rest.
            _ => assert!(sample.v == [0.0] && sample.friction[0].abs() <= 0.25, "{sample:?}"),
        }
    }
    assert!(stuck > 10_000 && slipping > 1000);
}

#[test]
fn with_stribeck_friction_the_error_falls_like_the_step_too() {
    let friction = [Stribeck {
        speed: 0.2,
        viscous: 0.05,
        ..Stribeck::by_rules(PENDULUM_LEVELS[0], 1e-5, 1.0)
    }];
    let mut events = quiet();
    let reference = event_driven::run(&PENDULUM, &friction, 1e-11, 5.0, &mut events).unwrap();
    assert!(events.len() > 2 && reference.v == [0.0], "{events:?}");
    let order =
        order(1.25e-4, 4, |h| distance(&stepped(&PENDULUM, &friction, h, 5.0).1.q, &reference.q));
    assert!((0.9..1.1).contains(&order), "order {order}");
}

/// The parameters are soft, so that a Runge-Kutta step resolves them: it is the second method.
#[test]
fn implicit_steps_of_every_model_converge_to_the_differential_equation() {
    fn of<const Z: usize, F: Implicit<Z> + Copy>(name: &str, friction: F, reference_s: f64) {
        let mut dynamics = SingleValuedDynamics { mechanism: &PENDULUM, friction: [friction] };
        let reference = fixed_step::run(&mut dynamics, reference_s, 1.5, &mut quiet()).unwrap();
        let order = order(1e-3, 5, |h| {
            let end =
                nonsmooth::run_implicit(&PENDULUM, &[friction], h, 1.5, &mut quiet()).unwrap();
            distance(&end.q, &reference.q)
        });
        assert!((0.85..1.15).contains(&order), "{name}: order {order}");
    }
    let (levels, range, mass) = (PENDULUM_LEVELS[0], 1e-3, 1.0);
    let sliding = Stribeck { viscous: 0.05, speed: 0.1, ..Stribeck::by_rules(levels, range, mass) };
    of("tanh", Tanh { levels, speed: 0.1 }, 2e-5);
    of("dahl", Dahl::by_rules(levels, range, mass), 2e-5);
    of("lugre", LuGre { sliding, ..LuGre::by_rules(levels, range, mass) }, 2e-5);
    of(
        "elastic-coulomb",
        ElasticCoulomb { sliding, ..ElasticCoulomb::by_rules(levels, range, mass) },
        2e-5,
    );
    // Its rates jump, which leaves Runge-Kutta steps an order of one as well.
    of(
        "maxwell-slip",
        MaxwellSlip::<4> { sliding, ..MaxwellSlip::by_rules(levels, range, mass) },
        1e-6,
    );
}

/// With bristles a million times stiffer than an explicit step could follow, only Coulomb's
/// friction is left.
#[test]
fn no_bristle_is_too_stiff_for_a_step() {
    let levels = Coulomb { stick: 0.96, slip: 0.96 };
    let (h, range) = (1e-4, 1e-9);
    let (_, expected) = stepped(&PENDULUM, &[levels], h, 5.0);
    assert!(expected.v == [0.0]);
    fn of<const Z: usize, F: Implicit<Z>>(
        friction: F,
        expected: &Finish<1>,
        h: f64,
        pendulum: &Pendulum,
    ) {
        let end = nonsmooth::run_implicit(pendulum, &[friction], h, 5.0, &mut quiet()).unwrap();
        assert!((end.q[0] - expected.q[0]).abs() < 1e-4 && end.v[0].abs() < 1e-6, "{end:?}");
    }
    of(Dahl::by_rules(levels, range, 1.0), &expected, h, &PENDULUM);
    of(LuGre::by_rules(levels, range, 1.0), &expected, h, &PENDULUM);
    of(ElasticCoulomb::by_rules(levels, range, 1.0), &expected, h, &PENDULUM);
    of(MaxwellSlip::<3>::by_rules(levels, range, 1.0), &expected, h, &PENDULUM);
    of(Tanh { levels, speed: 1e-6 }, &expected, h, &PENDULUM);
}

#[test]
fn a_step_too_long_for_the_springs_ends_with_time_and_state() {
    let trouble = nonsmooth::run(&SPRING_MASS, &SPRING_MASS_LEVELS, 0.05, 5.0, &mut quiet())
        .unwrap_err()
        .to_string();
    assert!(
        trouble.contains("too long for the springs") && trouble.contains("q = [0.0]"),
        "{trouble}"
    );
}
