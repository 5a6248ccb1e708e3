//! The simulated axis against closed forms and against a second method. Blind to the controller.

use dynamics::friction::{AddedFriction, Coulomb};
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, Event, EventKind, ExactAxis, Rk4Axis};
use proptest::prelude::*;

fn axis(stick: f64, slip: f64, viscous: f64) -> RobotAxis {
    RobotAxis {
        gain: 27.0,
        viscous,
        friction: Coulomb { stick, slip },
        added: AddedFriction::default(),
    }
}

fn thesis_axis() -> RobotAxis {
    axis(0.40, 0.38, 0.02)
}

/// Moves an axis, and returns the events.
fn advance(solver: &mut impl AxisSolver, axis: &RobotAxis, v: f64, duration_s: f64) -> Vec<Event> {
    let mut events = Vec::new();
    solver.advance(v, duration_s, &axis.friction, &mut |event| events.push(event));
    events
}

#[test]
fn a_frictionless_axis_follows_its_analytic_response() {
    // theta'' = kappa (v - b theta') from rest: velocity v/b (1 - e^(-kappa b t)).
    let axis = axis(0.0, 0.0, 0.02);
    let (v, lambda) = (2.5, 27.0 * 0.02);
    for (pieces, duration_s) in [(1, 7.0), (350, 0.02), (7, 1.0)] {
        let mut solver = ExactAxis::at_rest(&axis, 0.02);
        for _ in 0..pieces {
            advance(&mut solver, &axis, v, duration_s);
        }
        let decayed = 1.0 - (-lambda * 7.0f64).exp();
        let velocity = v / axis.viscous * decayed;
        let position = v / axis.viscous * (7.0 - decayed / lambda);
        assert!(
            (solver.velocity() / velocity - 1.0).abs() < 1e-12,
            "{pieces} pieces: {}",
            solver.velocity()
        );
        assert!(
            (solver.position() / position - 1.0).abs() < 1e-12,
            "{pieces} pieces: {}",
            solver.position()
        );
    }
}

#[test]
fn without_viscous_friction_the_axis_is_a_falling_stone() {
    // The closed form must not divide by b: acceleration kappa (v - Td), and a halt after velocity
    // / deceleration.
    let axis = axis(0.40, 0.38, 0.0);
    let mut solver = ExactAxis::at_rest(&axis, 0.02);
    advance(&mut solver, &axis, 1.38, 2.0);
    assert!((solver.velocity() - 54.0).abs() < 1e-11 && (solver.position() - 54.0).abs() < 1e-11);
    let events = advance(&mut solver, &axis, 0.0, 100.0);
    let halt_s = 54.0 / (27.0 * 0.38);
    assert_eq!(events.len(), 1);
    assert!((events[0].time_s - halt_s).abs() < 1e-11, "{events:?}");
    assert!((solver.position() - 54.0 - 27.0 * halt_s).abs() < 1e-9);
}

#[test]
fn a_coasting_axis_halts_when_and_where_the_closed_form_says() {
    // v = 0: t* = ln(1 + b velocity / Td) / (kappa b); the way is (velocity - kappa Td t*) / (kappa
    // b).
    let axis = thesis_axis();
    for velocity in [1e-6, 0.1, 5.0, 300.0, -5.0] {
        let mut solver = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, velocity);
        let events = advance(&mut solver, &axis, 0.0, 50.0);
        let lambda = 27.0 * 0.02;
        let halt_s = (0.02 * velocity.abs() / 0.38f64).ln_1p() / lambda;
        let way = velocity.signum() * (velocity.abs() - 27.0 * 0.38 * halt_s) / lambda;
        assert_eq!(events.iter().map(|e| e.kind).collect::<Vec<_>>(), [EventKind::Stick]);
        assert!((events[0].time_s / halt_s - 1.0).abs() < 1e-9, "{velocity}: {events:?}, {halt_s}");
        // The closed form of the way loses digits for small velocities, where it is velocity * t* /
        // 2.
        let way = if velocity.abs() < 1e-3 { 0.5 * velocity * halt_s } else { way };
        assert!(
            (solver.position() / way - 1.0).abs() < 1e-6,
            "{velocity}: {} {way}",
            solver.position()
        );
        assert!(solver.stuck() && solver.velocity() == 0.0);
    }
}

#[test]
fn a_stuck_axis_does_not_creep_and_breaks_away_above_static_friction() {
    let axis = thesis_axis();
    let mut solver = ExactAxis::at_rest(&axis, 0.02);
    for v in [0.40, -0.40, 0.399_999] {
        assert!(advance(&mut solver, &axis, v, 1000.0).is_empty());
        assert_eq!((solver.position(), solver.velocity()), (0.0, 0.0));
    }
    let events = advance(&mut solver, &axis, -0.400_001, 0.02);
    assert_eq!(events, [Event { time_s: 0.0, kind: EventKind::Break }]);
    assert!(solver.velocity() < 0.0);
}

#[test]
fn strong_reverse_effort_turns_the_axis_inside_one_sample() {
    let axis = thesis_axis();
    let mut solver = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, 1.0);
    let events = advance(&mut solver, &axis, -4.0, 0.02);
    // Deceleration kappa (4 + Td + b velocity/2) to first order: 1 deg/s is gone after 8.44 ms.
    assert_eq!(events.iter().map(|e| e.kind).collect::<Vec<_>>(), [EventKind::Reverse]);
    assert!((events[0].time_s - 1.0 / (27.0 * (4.38 + 0.01))).abs() < 1e-6, "{events:?}");
    let left_s = 0.02 - events[0].time_s;
    assert!(
        (solver.velocity() / (-27.0 * 3.62 * left_s) - 1.0).abs() < 0.004,
        "{}",
        solver.velocity()
    );
}

#[test]
fn halving_the_step_of_rk4_divides_its_error_by_sixteen() {
    // In pure slip, where the right-hand side is smooth. The next term of the error is lambda h of
    // the leading one: with lambda h from 0.13 down, ratios lie within a tenth of sixteen.
    let axis = thesis_axis();
    let mut exact = ExactAxis::at_rest(&axis, 4.0).with_state(0.0, 3.0);
    advance(&mut exact, &axis, 2.0, 4.0);
    let errors = [0.25, 0.125, 0.0625, 0.03125].map(|step_s| {
        let mut rk4 = Rk4Axis::at_rest(&axis, 1e-4, step_s).with_state(0.0, 3.0);
        advance(&mut rk4, &axis, 2.0, 4.0);
        assert_eq!(rk4.derivative_evaluations(), (16.0 / step_s) as u64);
        (rk4.position() - exact.position()).abs()
    });
    for pair in errors.windows(2) {
        assert!((15.0..17.6).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

#[test]
fn a_banded_stuck_axis_coasts_at_up_to_the_band() {
    // Section 2.3.1.2: the velocity with which it entered the band remains.
    let axis = thesis_axis();
    let mut rk4 = Rk4Axis::at_rest(&axis, 1e-3, 1e-5).with_state(0.0, 1.0);
    advance(&mut rk4, &axis, 0.2, 1.0);
    let (entered, velocity) = (rk4.position(), rk4.velocity());
    assert!(rk4.stuck() && velocity > 0.0 && velocity <= 1e-3, "{velocity}");
    advance(&mut rk4, &axis, 0.2, 1.0);
    // Eq. 1 balances the applied force only, so that viscous friction goes on braking: e^(-kappa b
    // t).
    let coasted = velocity * (1.0 - (-0.54f64).exp()) / 0.54;
    assert!(((rk4.position() - entered) / coasted - 1.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn one_advance_is_as_good_as_many(
        velocity in -20.0..20.0f64,
        v in -5.0..5.0f64,
        cuts in prop::collection::vec(1e-4..0.02f64, 1..12),
    ) {
        let axis = thesis_axis();
        let total: f64 = cuts.iter().sum();
        let mut whole = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, velocity);
        let events = advance(&mut whole, &axis, v, total);
        let mut parts = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, velocity);
        let mut later = Vec::new();
        let mut time_s = 0.0;
        for cut in cuts {
            for event in advance(&mut parts, &axis, v, cut) {
                later.push(Event { time_s: time_s + event.time_s, ..event });
            }
            time_s += cut;
        }
        prop_assert!((whole.position() - parts.position()).abs() < 1e-12);
        prop_assert!((whole.velocity() - parts.velocity()).abs() < 1e-11);
        prop_assert_eq!(events.len(), later.len());
        for (a, b) in events.iter().zip(&later) {
            prop_assert_eq!(a.kind, b.kind);
            prop_assert!((a.time_s - b.time_s).abs() < 1e-11);
        }
    }

    #[test]
    fn exact_and_rk4_agree_where_the_band_is_resolved(
        velocity in -20.0..20.0f64,
        v in -5.0..5.0f64,
    ) {
        let axis = thesis_axis();
        let mut exact = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, velocity);
        // The largest deceleration is kappa (5 + Ts + b 20) = 157 deg/s^2: 1.6e-4 deg/s in a step
        // of 1 us.
        let mut rk4 = Rk4Axis::at_rest(&axis, 2e-4, 1e-6).with_state(0.0, velocity);
        for effort in [v, -v, 0.1] {
            advance(&mut exact, &axis, effort, 0.02);
            advance(&mut rk4, &axis, effort, 0.02);
        }
        // Coasting through 60 ms at the band is 1.2e-5 deg, and as much again for where the band
        // was entered.
        let (exact, rk4) = (exact.position(), rk4.position());
        prop_assert!((exact - rk4).abs() < 3e-5, "{} {}", exact, rk4);
    }

    #[test]
    fn energy_never_grows_without_input(
        velocity in -500.0..500.0f64,
        viscous in 0.0..0.1f64,
        slip in 0.0..1.0f64,
        excess in 0.0..1.0f64,
        pieces in prop::collection::vec(1e-6..0.5f64, 1..50),
    ) {
        let axis = axis(slip + excess, slip, viscous);
        let mut exact = ExactAxis::at_rest(&axis, 0.02).with_state(0.0, velocity);
        let mut rk4 = Rk4Axis::at_rest(&axis, 1e-4, 1e-3).with_state(0.0, velocity);
        let mut speeds = (velocity.abs(), velocity.abs());
        for duration_s in pieces {
            advance(&mut exact, &axis, 0.0, duration_s);
            advance(&mut rk4, &axis, 0.0, duration_s);
            let now = (exact.velocity().abs(), rk4.velocity().abs());
            prop_assert!(now.0 <= speeds.0, "exact: {} after {}", now.0, speeds.0);
            // A fixed step may overshoot zero once by what one step decelerates; from then on it
            // chatters within.
            let one_step = 27.0 * slip * 1e-3;
            prop_assert!(now.1 <= speeds.1.max(one_step), "rk4: {} after {}", now.1, speeds.1);
            speeds = now;
        }
    }
}
