//! The rigid joint.

use super::*;
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, EventKind, ExactAxis};

/// Coulomb and viscous friction have a closed form between switches, which the robot's axis is
/// solved in: both joints meet to rounding, break for break.
#[test]
fn coulomb_friction_moves_as_its_closed_form() {
    let (stick, slip, viscous) = (6.0, 4.0, 1.3);
    let curve = Stribeck { coulomb: slip, stick, stribeck_velocity: 0.0, viscous };
    let mut joint = rigid(curve).build().unwrap();
    let friction = Coulomb { stick, slip };
    let axis = RobotAxis { gain: 1.0 / INERTIA, viscous, friction, added: Default::default() };
    let mut exact = ExactAxis::at_rest(&axis, 1e-3);
    let (mut events, mut wanted) = (Vec::new(), Vec::new());
    let mut worst: f64 = 0.0;
    for sample in 0..10_000 {
        joint.hold_and_tell(effort(sample), 1e-3, &mut |event| events.push(event));
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

#[test]
fn varying_friction_moves_as_in_time_stepping() {
    let friction = Friction::from(CURVE);
    let ripple = Some(Ripple { depth: 0.3, cycles: 100.0, phase: 0.7 });
    let dwell = Some(Dwell { growth: 0.3, time_s: 0.02 });
    let thermal = Some(Thermal {
        start_k: -10.0,
        heating_k_per_w: 5.0,
        time_s: 2.0,
        levels_per_k: 0.01,
        viscous_per_k: 0.03,
    });
    for (name, friction) in [
        ("curve", friction),
        ("ripple", Friction { ripple, ..friction }),
        ("dwell", Friction { dwell, ..friction }),
        ("thermal", Friction { thermal, ..friction }),
    ] {
        for lag_s in [0.0, 0.7e-3] {
            let train = Train::Rigid(Body { inertia: INERTIA, friction });
            let load =
                Load { constant: 0.3, gravity: Some(Gravity { amplitude: 1.0, angle: 0.4 }) };
            let push = Some(Push { torque: 5.0, from_s: 0.1004, until_s: 0.2503 });
            let stops = Stops { lower: -0.3, upper: 0.1 };
            let joint = Description { lag_s, load, push, stops, ..Description::of(train, COUNT) };
            let (worst, own) = against_time_stepping(&joint, effort, 1000);
            println!("{name} {lag_s} {worst} {own}");
        }
    }
}
