//! The rigid joint.

use super::*;
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, EventKind, ExactAxis};

/// With Coulomb and viscous friction, the motion between switches has the closed form in which the
/// robot's axis is solved: both joints agree to rounding, break for break.
#[test]
fn coulomb_friction_moves_as_its_closed_form() {
    let (stick, slip, viscous) = (6.0, 4.0, 1.3);
    let curve = StribeckCurve { coulomb: slip, stick, stribeck_velocity: 0.0, viscous };
    let mut joint = rigid(curve).build().unwrap();
    let friction = Coulomb { stick, slip };
    let axis = RobotAxis { gain: 1.0 / INERTIA, viscous, friction, added: Default::default() };
    let mut exact = ExactAxis::at_rest(&axis, 1e-3);
    let (mut events, mut wanted) = (Vec::new(), Vec::new());
    let mut worst: f64 = 0.0;
    for sample in 0..10_000 {
        joint.hold_and_report(effort(sample), 1e-3, &mut |event| events.push(event));
        exact.advance(effort(sample), 1e-3, &friction, &mut |event| wanted.push(event));
        worst = worst.max((joint.motor().position - exact.position()).abs());
    }
    assert!(worst < 1e-6 * COUNT, "{:e} counts", worst / COUNT);
    assert!(wanted.iter().filter(|event| event.kind == EventKind::Stick).count() > 9);
    assert_eq!(events.len(), wanted.len());
    for (event, wanted) in events.iter().zip(&wanted) {
        assert!(event.kind == wanted.kind && (event.time_s - wanted.time_s).abs() < 1e-9);
    }
}

/// Without friction a pendulum keeps its energy: `J v^2/2 - G cos(q0 + x)`.
#[test]
fn a_frictionless_pendulum_keeps_its_energy() {
    let curve = StribeckCurve { coulomb: 0.0, stick: 0.0, stribeck_velocity: 0.0, viscous: 0.0 };
    let (amplitude, angle) = (1.2, 2.0);
    let gravity = Some(Gravity { amplitude, angle });
    let load = LoadTorque { constant: 0.0, gravity };
    let mut joint = Description { load, ..rigid(curve) }.build().unwrap();
    let energy = |turn: Turn| {
        0.5 * INERTIA * turn.velocity.powi(2) - amplitude * (angle + turn.position).cos()
    };
    let (begin, mut fastest) = (energy(joint.motor()), 0.0_f64);
    for _ in 0..10_000 {
        joint.hold(0.0, 1e-3);
        fastest = fastest.max(joint.motor().velocity.abs());
        assert!((energy(joint.motor()) - begin).abs() < 1e-9);
    }
    assert!(fastest > 1.0);
}

/// Gravity, ripple and walls move with the zero of the position.
#[test]
fn a_joint_that_begins_somewhere_moves_as_one_whose_zero_is_there() {
    let ripple = Some(Ripple { depth: 0.2, cycles: 7.0, phase: 0.4 });
    let gravity = Some(Gravity { amplitude: 1.2, angle: 0.3 });
    let start = 0.8;
    let train = Train::Rigid(Body {
        inertia: INERTIA,
        friction: SetValuedFriction { ripple, ..CURVE.into() },
    });
    let load = LoadTorque { constant: 0.2, gravity };
    let stops = Stops { lower: -10.0, upper: start + 0.05 };
    let there = Description { load, stops, start, ..Description::of(train, COUNT) };
    let [mut here, mut there] = [there.begun_at(start), there].map(|one| one.build().unwrap());
    let (mut worst, mut farthest) = (0.0_f64, 0.0_f64);
    for sample in 0..10_000 {
        [&mut here, &mut there].into_iter().for_each(|joint| joint.hold(effort(sample), 1e-3));
        let [here, there] = [here.motor().position, there.motor().position - start];
        worst = worst.max((here - there).abs());
        farthest = farthest.max(here);
    }
    assert!(worst < 1e-3 * COUNT, "{:e} counts", worst / COUNT);
    // It came to the wall.
    assert!((farthest - 0.05).abs() < COUNT, "{farthest}");
}

#[test]
fn a_joint_breaks_away_above_its_stick_level_and_not_below() {
    let load = LoadTorque { constant: 0.5, gravity: None };
    for (effort, moves) in [(5.499, false), (5.501, true), (-6.499, false), (-6.501, true)] {
        let mut joint = Description { load, ..rigid(CURVE) }.build().unwrap();
        (0..100).for_each(|_| joint.hold(effort, 1e-3));
        assert_eq!(joint.motor().position != 0.0, moves, "{effort}");
        assert_eq!(joint.motor().position * effort > 0.0, moves, "{effort}");
        assert_eq!(joint.is_stuck(), !moves);
    }
}

/// A load that is stronger than the stick level drives the joint as an effort of its size does.
#[test]
fn an_overhauling_load_moves_the_joint_as_an_effort_does() {
    let load = LoadTorque { constant: -13.0, gravity: None };
    let mut loaded = Description { load, ..rigid(CURVE) }.build().unwrap();
    let mut bare = rigid(CURVE).build().unwrap();
    let mut lowest: f64 = 0.0;
    for sample in 0..1000 {
        let effort = if sample < 300 { 0.0 } else { 19.5 };
        loaded.hold(effort, 1e-3);
        bare.hold(effort - 13.0, 1e-3);
        assert!((loaded.motor().position - bare.motor().position).abs() < 1e-6 * COUNT);
        lowest = lowest.min(bare.motor().position);
    }
    // It falls for 0.3 s and more under 7 to 9 N m beyond its friction, and is brought back.
    assert!(lowest < -0.5 && bare.motor().position > lowest + 0.1);
}

/// `u (1 - exp(-t/tau)) = F_s` is the break behind a lag.
#[test]
fn a_lagging_effort_breaks_the_joint_at_the_instant_of_its_closed_form() {
    let (tau, effort) = (0.7e-3, 8.0_f64);
    let mut joint = Description { lag_s: tau, ..rigid(CURVE) }.build().unwrap();
    let mut events = Vec::new();
    joint.hold_and_report(effort, 1e-3, &mut |event| events.push(event));
    let wanted = tau * (effort / (effort - CURVE.stick)).ln();
    assert_eq!(events.len(), 1);
    assert!(events[0].kind == EventKind::Break && (events[0].time_s - wanted).abs() < 1e-12);
}

#[test]
fn a_wall_stops_the_joint_dead_and_lets_it_go_beyond_the_stick_level_only() {
    let stops = Stops { lower: -1.0, upper: 0.02 };
    let mut joint = Description { stops, ..rigid(CURVE) }.build().unwrap();
    (0..500).for_each(|_| joint.hold(20.0, 1e-3));
    assert_eq!(joint.motor(), Turn { position: 0.02, velocity: 0.0 });
    (0..500).for_each(|_| joint.hold(-5.99, 1e-3));
    assert_eq!(joint.motor(), Turn { position: 0.02, velocity: 0.0 });
    joint.hold(-6.01, 1e-3);
    assert!(joint.motor().position < 0.02);
}

/// Everything at once: gravity, a constant load, a push that begins and ends between samples, and
/// walls; with each kind of friction, with a lag and without.
#[test]
fn varying_friction_moves_as_in_time_stepping() {
    let friction = SetValuedFriction::from(CURVE);
    let ripple = Some(Ripple { depth: 0.3, cycles: 100.0, phase: 0.7 });
    let dwell = Some(Dwell { growth: 0.3, time_s: 0.02 });
    // A gear that warms a thousand times faster than any.
    let thermal = Some(Thermal {
        start_k: -10.0,
        heating_k_per_w: 5.0,
        time_s: 2.0,
        levels_per_k: 0.01,
        viscous_per_k: 0.03,
    });
    for (friction, allowed) in [
        (friction, 0.05),
        (SetValuedFriction { ripple, ..friction }, 0.05),
        (SetValuedFriction { dwell, ..friction }, 0.05),
        (SetValuedFriction { thermal, ..friction }, 0.5),
    ] {
        for lag_s in [0.0, 0.7e-3] {
            let train = Train::Rigid(Body { inertia: INERTIA, friction });
            let gravity = Some(Gravity { amplitude: 1.0, angle: 0.4 });
            let load = LoadTorque { constant: 0.3, gravity };
            let push = Some(TorquePulse { torque: 5.0, from_s: 0.1004, until_s: 0.2503 });
            let stops = Stops { lower: -0.3, upper: 0.1 };
            let joint = Description { lag_s, load, push, stops, ..Description::of(train, COUNT) };
            let worst = against_time_stepping(&joint, effort, 1000);
            assert!(worst < allowed, "{friction:?}, lag {lag_s} s: {worst} counts");
        }
    }
}
