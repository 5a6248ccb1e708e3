//! A solver ends, whatever it is given, and says when and where it gave up.

use dynamics::friction::Coulomb;
use dynamics::mechanism::{Mechanism, Terms};
use friction_lab::friction::{Dahl, ResetIntegrator, Stribeck, Tanh};
use friction_lab::mechanism::{Pull, SpringMass};
use friction_lab::solver::dynamics::{
    Dynamics, SingleValuedDynamics, StateRates, direction, floor,
};
use friction_lab::solver::state::{BodyEvent, BodyState};
use friction_lab::solver::step_doubling::{self, Accuracy};
use friction_lab::solver::{SolverFailure, event_driven, fixed_step, nonsmooth, piecewise_smooth};

use super::common::{SPRING_MASS, SPRING_MASS_LEVELS};

const LEVELS: [Coulomb; 1] = [Coulomb { stick: 0.5, slip: 0.4 }];

/// A mass of 1 kg under any force of time and velocity.
struct Pushed<F>(F);

impl<F: Fn(f64, f64) -> f64> Mechanism<1> for Pushed<F> {
    fn terms(&self, t: f64, _: &[f64; 1], v: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[1.0]], force: [(self.0)(t, v[0])] }
    }
}

fn exact(force: impl Fn(f64, f64) -> f64) -> Result<Vec<BodyEvent>, SolverFailure> {
    let mut events = Vec::new();
    event_driven::run(&Pushed(force), &LEVELS, 1e-8, 2.0, &mut events).map(|_| events)
}

#[test]
fn chatter_ends_with_time_and_state() {
    // A force that turns against every motion at once: it breaks away and halts, without end.
    let trouble = exact(|_, v| if v >= 0.0 { -2.0 } else { 2.0 }).unwrap_err();
    let said = trouble.to_string();
    assert!(trouble.time_s < 1e-3 && said.contains(" s, in the state q = ["), "{said}");
}

#[test]
fn a_force_without_a_value_ends_with_time_and_state() {
    let trouble = exact(|t, _| if t < 0.5 { 1.0 } else { f64::NAN }).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-6, "{trouble}");
    // At rest too.
    let trouble = exact(|t, _| if t < 0.5 { 0.1 } else { f64::NAN }).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-6, "{trouble}");
}

#[test]
fn a_motion_that_leaves_in_finite_time_ends_there() {
    // v' = v^2 - 0.4 from v' = 0.6: gone soon after a second or two, and no step gets there.
    let found = exact(|_, v| 1.0 + 40.0 * v * v);
    let trouble = found.unwrap_err();
    assert!((0.05..1.0).contains(&trouble.time_s), "{trouble}");
}

#[test]
fn other_solvers_end_as_well() {
    let reset = ResetIntegrator::by_rules(LEVELS[0], 1e-5, 1.0);
    let broken = Pushed(|t: f64, _: f64| if t < 0.5 { 1.0 } else { f64::NAN });
    let trouble = piecewise_smooth::run(&broken, &[reset], 1e-8, 2.0, &mut Vec::new()).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-6, "{trouble}");
    let mut dynamics = SingleValuedDynamics { mechanism: &broken, friction: [reset] };
    let accuracy = Accuracy { eps: 2e-4, max_evaluations: 10_000_000 };
    let trouble = step_doubling::run(&mut dynamics, accuracy, 2.0, &mut Vec::new()).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-3, "{trouble}");
}

/// Fixed steps go on; a state that is no longer finite ends the run, which says when.
#[test]
fn fixed_steps_end_where_the_state_is_no_longer_finite() {
    let broken = Pushed(|t: f64, _: f64| if t < 0.5 { 1.0 } else { f64::NAN });
    let h = 1e-3;
    let ends = |at_s: Option<f64>| assert!((at_s.unwrap() - 0.5).abs() < 2.0 * h, "{at_s:?}");
    let mut dynamics = SingleValuedDynamics {
        mechanism: &broken,
        friction: [Tanh { levels: LEVELS[0], speed: 0.1 }],
    };
    ends(fixed_step::run(&mut dynamics, h, 2.0, &mut Vec::new()).unwrap().diverged_at_s);
    ends(nonsmooth::run(&broken, &LEVELS, h, 2.0, &mut Vec::new()).unwrap().diverged_at_s);
    let dahl = [Dahl::by_rules(LEVELS[0], 1e-5, 1.0)];
    ends(nonsmooth::run_implicit(&broken, &dahl, h, 2.0, &mut Vec::new()).unwrap().diverged_at_s);
}

/// A pendulum of a millisecond that reports every reversal: 2000 a second.
struct Swinging;

impl Dynamics<1, 0> for Swinging {
    fn start(&self) -> BodyState<1, 0> {
        BodyState { q: [1.0], ..BodyState::ZERO }
    }

    fn evaluate(&self, _: f64, state: &BodyState<1, 0>) -> StateRates<1, 0> {
        let omega = 2e3 * std::f64::consts::PI;
        let a = -omega * omega * state.q[0];
        StateRates { rates: BodyState { q: state.v, v: [a], z: [[]] }, friction: [0.0] }
    }

    fn slip(&self, state: &BodyState<1, 0>) -> [i8; 1] {
        [direction(state.v[0])]
    }

    fn next_corner(&self, _: f64) -> f64 {
        f64::INFINITY
    }

    fn scale(&self) -> BodyState<1, 0> {
        floor()
    }
}

/// In a run of 1e9 s an instant is a second.
#[test]
fn events_without_end_stop_every_solver_with_time_and_state() {
    let fails_within =
        |solver: &str, run: Result<(), SolverFailure>, at_s: std::ops::Range<f64>| {
            let trouble = run.unwrap_err();
            let said = trouble.to_string();
            assert!(
                said.contains("more than 200 changes between sticking and slipping within"),
                "{solver}: {said}"
            );
            assert!(
                at_s.contains(&trouble.time_s) && said.contains(" s, in the state q = ["),
                "{solver}: {said}"
            );
        };
    const LONG_S: f64 = 1e9;
    // 200 reversals at 2000 a second.
    fails_within(
        "rk4",
        fixed_step::run(&mut Swinging, 1e-5, LONG_S, &mut Vec::new()).map(|_| ()),
        0.09..0.11,
    );
    let accuracy = Accuracy { eps: 1e-6, max_evaluations: 10_000_000 };
    let adaptive = step_doubling::run(&mut Swinging, accuracy, LONG_S, &mut Vec::new());
    fails_within("rk4-adaptive", adaptive.map(|_| ()), 0.09..0.11);
    // Pushed for two milliseconds, held back for two: it breaks away and sticks every four.
    let to_and_fro = Pushed(|t: f64, _: f64| if (250.0 * t).fract() < 0.5 { 1.0 } else { -0.45 });
    let stepped = nonsmooth::run(&to_and_fro, &LEVELS, 1e-4, LONG_S, &mut Vec::new());
    fails_within("nonsmooth", stepped.map(|_| ()), 0.39..0.41);
}

/// A force at rest that dips between the instants at which it is asked for its polynomial: there
/// the polynomial reaches F_s, and the force does so only after the dip.
#[test]
fn a_break_is_where_the_force_is_at_its_limit_and_not_where_a_polynomial_is() {
    let force = |t: f64| 0.1 + 0.3 * t - 0.3 * (-((t - 4.0 / 3.0) / 0.02).powi(2)).exp();
    let (mut low, mut high) = (4.0 / 3.0, 1.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force(middle) < LEVELS[0].stick { low = middle } else { high = middle }
    }
    let events = exact(|t, _| force(t)).unwrap();
    assert!(
        (events[0].time_s - low).abs() < 1e-9 && low - 4.0 / 3.0 > 0.03,
        "{events:?}, not \
        {low}"
    );
}

/// Stribeck's curve falls five hundred thousand times a second here, where the ramp is slowest: a
/// motion begins in nothing that the tolerance could resolve. In the limit of that speed the
/// friction is Coulomb's.
#[test]
fn a_steep_stribeck_curve_under_a_slow_ramp_goes_through() {
    let mechanism = SpringMass { pull: Pull::steady(1e-5), ..SPRING_MASS };
    let rule = Stribeck::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1);
    let (expected, _) = super::common::exact(&mechanism, &SPRING_MASS_LEVELS, 1e-9, 750.0);
    assert_eq!(expected.len(), 10, "{expected:?}");
    for (speed, exponent) in [(1e-6, 1.0), (1e-6, 2.0), (1e-7, 1.0)] {
        let friction = [Stribeck { speed, exponent, ..rule }];
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let mut events = Vec::new();
            event_driven::run(&mechanism, &friction, tolerance, 750.0, &mut events).unwrap();
            assert_eq!(
                events.len(),
                expected.len(),
                "{speed}, {exponent}, {tolerance}: {events:?}"
            );
            // A slip takes 0.1 s, the wait between two 100 s.
            for (found, expected) in events.iter().zip(&expected) {
                let near =
                    (found.time_s - expected.time_s).abs() < 0.05 && found.kind == expected.kind;
                assert!(near, "{speed}, {exponent}, {tolerance}: {found:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn equal_static_and_dynamic_friction_break_away_once_and_stick_once() {
    // A ramp and back: F = t up to 1 s, then 2 - t. Slip from 0.4 s; V = s^2/2 up to the top, zero
    // where the areas agree.
    let levels = [Coulomb { stick: 0.4, slip: 0.4 }];
    struct Ramp;
    impl Mechanism<1> for Ramp {
        fn terms(&self, t: f64, _: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
            Terms { mass: [[1.0]], force: [if t < 1.0 { t } else { 2.0 - t }] }
        }
        fn next_corner(&self, t: f64) -> f64 {
            if t < 1.0 { 1.0 } else { f64::INFINITY }
        }
    }
    let mut events: Vec<BodyEvent> = Vec::new();
    event_driven::run(&Ramp, &levels, 1e-9, 3.0, &mut events).unwrap();
    // V(1) = 0.18; then 0.18 + 0.6 u - u^2/2 = 0.
    let halt_s = 1.0 + 0.6 + (0.36_f64 + 0.36).sqrt();
    assert_eq!(events.len(), 2, "{events:?}");
    assert!(
        (events[0].time_s - 0.4).abs() < 1e-9 && (events[1].time_s - halt_s).abs() < 1e-8,
        "{events:?}"
    );
}
