//! The draw of the thesis's axis with other friction and inertia, in degrees and volts.

use super::condition::Condition;
use super::distribution::Draws;
use super::drawn_case::{Case, Trapezoid, UnitScale, wall};
use super::family::Family;
use dynamics::joint::{Body, Description, DiscSide, JointEncoder, Stops, StribeckCurve, Train};
use simulator::plant::Delay;

/// Nominal inertia of the thesis's axis, V s^2/deg, and viscous friction, V s/deg.
pub(super) const NOMINAL: [f64; 2] = [1.0 / 27.0, 0.02];

/// The full scale of the thesis's D/A and its step, V.
const EFFORT: [f64; 2] = [5.0, 0.00488];

/// Bounds of the breakaway effort of the thesis's axis, V: 0.38 L(0.5, 2) times U(1, 1.35).
pub(super) const BREAKAWAY: [f64; 2] = [0.19, 1.03];

/// Count of the thesis's encoder, deg, and its sample time, s.
const LOOP: [f64; 2] = [0.00242, 0.02];

/// The step of the thesis's axis, deg.
const STEP: f64 = 2.5;

/// Draws an axis of the thesis, with its loop and moves.
pub(super) fn axis(draws: &mut Draws, family: Family, number: u64) -> Case {
    let inertia = NOMINAL[0] * draws.log_uniform(0.5, 2.0);
    let viscous = NOMINAL[1] * draws.uniform(0.5, 1.5);
    let coulomb = 0.38 * draws.log_uniform(0.5, 2.0);
    let stick = coulomb * draws.uniform(1.0, 1.35);
    let curve = StribeckCurve { coulomb, stick, stribeck_velocity: 0.0, viscous };
    let [count, sample_time] = LOOP;
    let start = -count * draws.uniform(0.0, 1.0);
    let delay = if draws.coin() { Delay::OneSample } else { Delay::None };
    let scale = UnitScale { effort: 1.0, angle: 1.0 };
    let train = Train::Rigid(Body { inertia, friction: curve.into() });
    let stops = if family.has_wall() { wall(STEP, count) } else { Stops::default() };
    Case {
        family,
        number,
        joint: Description { start, stops, ..Description::of(train, count) },
        encoder: JointEncoder { count, side: DiscSide::Motor },
        motor_encoder: None,
        delay,
        scale,
        bounds: scale.bounds(NOMINAL, BREAKAWAY, 0.0, EFFORT, [count, sample_time]),
        step: STEP,
        trapezoid: Trapezoid { distance: 50.0, speed: 5.0, dwell_s: 2.0, half_blend_s: 0.25 },
        is_braked: false,
        jump_counts: None,
        condition: Condition::Nominal,
        phase: 0.0,
        electrics: None,
        arm: None,
    }
}
