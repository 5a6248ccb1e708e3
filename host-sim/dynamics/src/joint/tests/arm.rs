//! The geared arm.

use super::*;
use crate::friction;
use crate::mechanism::{Mechanism, Terms, TwoLinkArm};
use crate::solver::event_driven;
use crate::solver::state::BodyEvent;

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

/// The links with the rotors, for the friction lab's solver.
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
        let friction = arm.friction.map(|curve| friction::Stribeck {
            levels: friction::Coulomb { stick: curve.stick, slip: curve.coulomb },
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

/// Under efforts that change, it moves as backward Euler with the convex problem of both joints at
/// once, solved by coordinate descent: `A = M + hB`, `b = M v + h (u - c - g)`,
/// `v_i = soft(b_i - sum A_ij v_j, h g_i)/A_ii`.
#[test]
fn changing_efforts_move_the_arm_as_time_stepping_with_coordinate_descent() {
    const SAMPLES: u32 = 600;
    let arm = arm();
    let efforts = |sample: u32| [1.6 * effort(sample), 1.1 * effort(sample + 210)];
    let step = |steps: u32| {
        let h = 1e-3 / f64::from(steps);
        let (mut q, mut v, mut out) = (arm.start, [0.0_f64; 2], Vec::new());
        for sample in 0..SAMPLES {
            let torque = efforts(sample);
            let links = TwoLinkArm { mass: arm.mass, length: arm.length, torque, start: [0.0; 2] };
            for _ in 0..steps {
                let Terms { mass, force } = Links(links, arm.rotor).terms(0.0, &q, &v);
                let level = arm.friction.map(|curve| curve);
                let g = [0, 1].map(|i| {
                    let over = (-(v[i] / level[i].stribeck_velocity).powi(2)).exp();
                    level[i].coulomb + (level[i].stick - level[i].coulomb) * over
                });
                let b = [0, 1].map(|i| mass[i][0] * v[0] + mass[i][1] * v[1] + h * force[i]);
                for _ in 0..8 {
                    for i in 0..2 {
                        let free = b[i] - mass[i][1 - i] * v[1 - i];
                        let held = (free.abs() - h * g[i]).max(0.0) * free.signum();
                        v[i] = held / (mass[i][i] + h * level[i].viscous);
                    }
                }
                (0..2).for_each(|i| q[i] += h * v[i]);
            }
            out.push(q);
        }
        out
    };
    let (coarse, fine) = (step(250), step(500));
    let mut joint = arm.build().unwrap();
    let mut rests = [0; 2];
    for sample in 0..SAMPLES {
        joint.hold(efforts(sample), 1e-3);
        for i in 0..2 {
            let wanted = 2.0 * fine[sample as usize][i] - coarse[sample as usize][i];
            let error = (joint.turn(i).position - wanted).abs() / COUNT;
            assert!(error < 0.1, "joint {i} in sample {sample}: {error} counts");
            rests[i] += u32::from(joint.is_joint_stuck(i));
        }
    }
    assert_eq!(joint.unfollowed_s(), 0.0);
    assert!(rests.iter().all(|rests| (20..580).contains(rests)), "{rests:?}");
}

#[test]
fn an_arm_at_rest_stays_where_it_is() {
    let arm = arm();
    assert!((0..2).all(|i| arm.gravity()[i] < 0.5 * arm.friction[i].coulomb));
    let mut joint = arm.build().unwrap();
    (0..100).for_each(|_| joint.hold([0.0; 2], 1e-3));
    assert!(joint.is_stuck());
    assert_eq!([joint.turn(0).position, joint.turn(1).position], arm.start);
}
