//! The draw of a geared arm of two links, with a controller for each joint.
//!
//! Each joint is one of the family `rigid`: friction, rotor and step are drawn as there. The links
//! are drawn so that in every pose gravity is no more than half of either joint's slip friction: a
//! released arm stays where it is.
//!
//! ```text
//! w_2 = m_2 l_2 g = U(0.2, 1) min(0.5 F_c2, 0.4 F_c1 / (1 + l_1/l_2))
//! m_1 l_1 g       = U(0.05, 0.1) F_c1          so (m_1 + m_2) l_1 g + w_2 <= 0.5 F_c1
//! l_1 = U(0.5, 1.5) m,  l_2 = l_1 U(0.5, 1)
//! known J_i = (N^2 J_i + D_ii at the start) / U(0.5, 1.5)
//! ```

use std::f64::consts::{PI, TAU};

use super::condition::Condition;
use super::distribution::Draws;
use super::drawn_case::{
    ArmCase, BREAKAWAY, Case, DrawOptions, EFFORT, HARD_BREAKAWAY, NOMINAL, Trapezoid, UnitScale,
};
use super::family::Family;
use dynamics::joint::{
    ArmDescription, Body, Description, DiscSide, JointEncoder, StribeckCurve, Train,
};
use dynamics::mechanism::{GRAVITY, Mechanism as _, TwoLinkArm};
use simulator::plant::Delay;

/// One joint of an arm, without the inertia of the links.
struct Drawn {
    curve: StribeckCurve,
    rotor: f64,
    error_of_inertia: f64,
    step: f64,
    start: f64,
    delay: Delay,
}

fn joint(draws: &mut Draws, kind: DrawOptions) -> Drawn {
    let rotor = NOMINAL[0] * draws.uniform(0.5, 1.5);
    let viscous = NOMINAL[1] * draws.uniform(0.5, 1.5);
    let coulomb = draws.uniform(2.0, 6.0);
    let ratio = if kind.hard { draws.uniform(2.0, 4.0) } else { draws.uniform(1.05, 2.0) };
    let stribeck_velocity = draws.log_uniform(5e-3, 0.2);
    let curve = StribeckCurve { coulomb, stick: ratio * coulomb, stribeck_velocity, viscous };
    Drawn {
        curve,
        rotor,
        error_of_inertia: draws.uniform(0.5, 1.5),
        step: draws.sign() * draws.log_uniform(1e-3, 0.5),
        start: draws.uniform(-PI, PI),
        delay: if draws.coin() { Delay::OneSample } else { Delay::None },
    }
}

/// Draws an arm.
pub(super) fn arm(draws: &mut Draws, family: Family, number: u64, kind: DrawOptions) -> Case {
    let [first, second] = [joint(draws, kind), joint(draws, kind)];
    let inner = draws.uniform(0.5, 1.5);
    let length = [inner, inner * draws.uniform(0.5, 1.0)];
    let most =
        (0.5 * second.curve.coulomb).min(0.4 * first.curve.coulomb / (1.0 + length[0] / length[1]));
    let outer = draws.uniform(0.2, 1.0) * most / (GRAVITY * length[1]);
    let own = draws.uniform(0.05, 0.1) * first.curve.coulomb / (GRAVITY * length[0]);
    let count = TAU / if number.is_multiple_of(2) { 1e5 } else { 1e4 };
    let arm = ArmDescription {
        mass: [own, outer],
        length,
        rotor: [first.rotor, second.rotor],
        friction: [first.curve, second.curve],
        start: [first.start, second.start],
        count,
    };
    let links = TwoLinkArm { mass: arm.mass, length, torque: [0.0; 2], start: arm.start };
    let mass = links.terms(0.0, &arm.start, &[0.0; 2]).mass;
    let scale = UnitScale { effort: EFFORT[0] / 5.0, angle: PI / 180.0 };
    let breakaway = if kind.hard { HARD_BREAKAWAY } else { BREAKAWAY };
    let bounds = |drawn: &Drawn, links: f64| {
        let nominal = [(drawn.rotor + links) / drawn.error_of_inertia, NOMINAL[1]];
        scale.bounds(nominal, breakaway, 0.0, EFFORT, [count, 1.0 / kind.rate_hz])
    };
    let trapezoid = |drawn: &Drawn| Trapezoid {
        distance: 0.5 * drawn.step.signum(),
        speed: 0.5,
        dwell_s: 0.5,
        half_blend_s: 0.125,
    };
    let body = Body { inertia: first.rotor + mass[0][0], friction: first.curve.into() };
    Case {
        family,
        number,
        joint: Description { start: first.start, ..Description::of(Train::Rigid(body), count) },
        encoder: JointEncoder { count, side: DiscSide::Motor },
        motor_encoder: None,
        delay: first.delay,
        scale,
        bounds: bounds(&first, mass[0][0]),
        step: first.step,
        trapezoid: trapezoid(&first),
        is_braked: false,
        jump_counts: None,
        condition: Condition::Nominal,
        phase: 0.0,
        electrics: None,
        arm: Some(Box::new(ArmCase {
            arm,
            is_coupled: family == Family::Arm,
            bounds: bounds(&second, mass[1][1]),
            step: second.step,
            trapezoid: trapezoid(&second),
            delay: second.delay,
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EASY: DrawOptions = DrawOptions::ORDINARY;

    #[test]
    fn gravity_takes_no_more_than_half_of_either_joint_s_slip_friction() {
        let mut largest: f64 = 0.0;
        for number in 0..2000 {
            let case = Case::draw(1, Family::Arm, number, EASY);
            let arm = case.arm.unwrap().arm;
            for (gravity, curve) in arm.gravity().iter().zip(&arm.friction) {
                assert!(*gravity > 0.0 && *gravity <= 0.5 * curve.coulomb * (1.0 + 1e-12));
                largest = largest.max(gravity / curve.coulomb);
            }
            assert!(arm.mass.iter().all(|mass| *mass > 0.0));
        }
        assert!(largest > 0.45, "{largest}");
    }

    #[test]
    fn arms_with_their_coupling_and_without_are_the_same() {
        for number in 0..20 {
            let [mut with, without] = [Family::Arm, Family::ArmUncoupled]
                .map(|family| Case::draw(1, family, number, EASY));
            assert!(with != without);
            with.family = Family::ArmUncoupled;
            with.arm.as_mut().unwrap().is_coupled = false;
            assert_eq!(with, without);
        }
    }
}
