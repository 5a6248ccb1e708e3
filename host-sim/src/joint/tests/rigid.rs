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
