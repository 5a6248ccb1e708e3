//! The geared arm of `dynamics` against the event-driven solver.

use dynamics::friction::Coulomb;
use dynamics::joint::{ArmDescription, StribeckCurve};
use dynamics::mechanism::{Mechanism, Terms, TwoLinkArm};
use friction_lab::friction::Stribeck;
use friction_lab::solver::event_driven;
use friction_lab::solver::state::BodyEvent;

/// One count of 100,000 a turn, rad.
const COUNT: f64 = std::f64::consts::TAU / 1e5;

fn arm() -> ArmDescription {
    let curve = |coulomb, viscous| StribeckCurve {
        coulomb,
        stick: 1.5 * coulomb,
        stribeck_velocity: 0.05,
        viscous,
    };
    ArmDescription {
        mass: [0.09, 0.09],
        length: [1.0, 1.0],
        rotor: [0.959, 0.337],
        friction: [curve(5.61, 2.0), curve(4.1, 1.3)],
        start: [0.4, -0.7],
        count: COUNT,
    }
}

/// The links with the rotors, for the event-driven solver.
struct Links(TwoLinkArm, [f64; 2]);

impl Mechanism<2> for Links {
    fn terms(&self, t: f64, q: &[f64; 2], v: &[f64; 2]) -> Terms<2> {
        let mut terms = self.0.terms(t, q, v);
        (0..2).for_each(|i| terms.mass[i][i] += self.1[i]);
        terms
    }

    fn start(&self) -> [f64; 2] {
        self.0.start
    }
}

/// From rest under constant efforts the arm moves as the friction lab's event-driven solver, which
/// has another integrator and another search for switches. In the last case the first joint alone
/// is driven beyond its limit, and its kick-back moves the second.
#[test]
fn constant_efforts_move_the_arm_as_the_event_driven_solver() {
    let arm = arm();
    let mut moved_by_kick_back = false;
    for efforts in [[12.0, 0.0], [0.0, -9.0], [10.0, 7.5], [-40.0, 1.0]] {
        let links =
            TwoLinkArm { mass: arm.mass, length: arm.length, torque: efforts, start: arm.start };
        let friction = arm.friction.map(|curve| Stribeck {
            levels: Coulomb { stick: curve.stick, slip: curve.coulomb },
            speed: curve.stribeck_velocity,
            exponent: 2.0,
            viscous: curve.viscous,
        });
        let mut events: Vec<BodyEvent> = Vec::new();
        let wanted =
            event_driven::run(&Links(links, arm.rotor), &friction, 1e-11, 1.0, &mut events)
                .unwrap();
        let mut joint = arm.build().unwrap();
        (0..1000).for_each(|_| joint.hold(efforts, 1e-3));
        for i in 0..2 {
            let error = (joint.turn(i).position - wanted.q[i]).abs() / COUNT;
            assert!(error < 0.05, "joint {i} under {efforts:?}: {error} counts");
        }
        assert!((wanted.q[0] - arm.start[0]).abs() + (wanted.q[1] - arm.start[1]).abs() > 0.1);
        moved_by_kick_back |= efforts[1] == 1.0 && wanted.q[1] != arm.start[1];
    }
    assert!(moved_by_kick_back);
}
