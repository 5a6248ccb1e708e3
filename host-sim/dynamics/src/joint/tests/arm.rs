//! The geared arm.

use super::*;
use crate::mechanism::{Mechanism, Terms, TwoLinkArm};

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

/// Links with their rotors, for the second method.
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
