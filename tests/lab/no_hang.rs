//! A solver ends, whatever it is given, and says when and where it gave up.

use host_sim::friction::Coulomb;
use host_sim::mechanism::{Mechanism, Terms};
use host_sim::solver::dynamics::SingleValuedDynamics;
use host_sim::solver::state::BodyEvent;
use host_sim::solver::step_doubling::{self, Accuracy};
use host_sim::solver::{Trouble, located, pieces};

use host_sim::friction::ResetIntegrator;

const LEVELS: [Coulomb; 1] = [Coulomb { stick: 0.5, slip: 0.4 }];

/// A mass of 1 kg under any force of time and velocity.
struct Pushed<F>(F);

impl<F: Fn(f64, f64) -> f64> Mechanism<1> for Pushed<F> {
    fn terms(&self, t: f64, _: &[f64; 1], v: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[1.0]], force: [(self.0)(t, v[0])] }
    }
}

fn exact(force: impl Fn(f64, f64) -> f64) -> Result<Vec<BodyEvent>, Trouble> {
    let mut events = Vec::new();
    located::run(&Pushed(force), &LEVELS, 1e-8, 2.0, &mut events).map(|_| events)
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
    let trouble = pieces::run(&broken, &[reset], 1e-8, 2.0, &mut Vec::new()).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-6, "{trouble}");
    let mut dynamics = SingleValuedDynamics { mechanism: &broken, friction: [reset] };
    let accuracy = Accuracy { eps: 2e-4, max_evaluations: 10_000_000 };
    let trouble = step_doubling::run(&mut dynamics, accuracy, 2.0, &mut Vec::new()).unwrap_err();
    assert!((trouble.time_s - 0.5).abs() < 1e-3, "{trouble}");
}

#[test]
fn equal_static_and_dynamic_friction_break_away_once_and_stick_once() {
    // A ramp and back: F = t up to 1 s, then 2 - t. Slip from 0.4 s; V = s^2/2 up to the top, zero where the areas agree.
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
    located::run(&Ramp, &levels, 1e-9, 3.0, &mut events).unwrap();
    // V(1) = 0.18; then 0.18 + 0.6 u - u^2/2 = 0.
    let halt_s = 1.0 + 0.6 + (0.36_f64 + 0.36).sqrt();
    assert_eq!(events.len(), 2, "{events:?}");
    assert!((events[0].time_s - 0.4).abs() < 1e-9 && (events[1].time_s - halt_s).abs() < 1e-8, "{events:?}");
}
