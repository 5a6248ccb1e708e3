//! The draw of a case: a joint of a family, its loop and the bounds that the rules know.
//!
//! The numbers of a case are drawn in the order of the code below, independently for each joint.
//! docs/how-to/ensembles.md has the distributions as a table.

use std::f64::consts::{LN_2, PI, TAU};

use super::arm_draw;
use super::bridge::Electrics;
use super::condition::Condition;
use super::distribution::{Draws, Purpose};
use super::drawn_case::{
    BREAKAWAY, Case, DrawOptions, EFFORT, GEAR_BACKLASH_DEG, HARD_BREAKAWAY, NOMINAL, Trapezoid,
    UnitScale, wall,
};
use super::family::Family;
use super::thesis_draw;
use dynamics::joint::{
    Body, Bristle, Description, DiscSide, Dwell, Gravity, JointEncoder, LoadTorque,
    SetValuedFriction, ShaftDescription, Stops, StribeckCurve, Thermal, Train,
};
use simulator::plant::Delay;
use simulator::rules::{JointBounds, MotorEncoder};

/// Resonance of the load against a locked motor, Hz.
const GEAR_HZ: [f64; 2] = [5.0, 50.0];
/// The same of a soft gear.
const SOFT_HZ: [f64; 2] = [2.0, 5.0];
/// Backlash of a worn gear, deg at the joint.
const WIDE_BACKLASH_DEG: f64 = 1.0;

/// Range of a load that drives a joint, in multiples of its stick friction.
const OVERHAULING: [f64; 2] = [0.5, 3.0];

impl Case {
    /// Draws case `number` of a family, under the condition of `kind`.
    pub fn draw(seed: u64, family: Family, number: u64, kind: DrawOptions) -> Self {
        let draws = &mut Draws::new(seed, family.number(), Purpose::Joint, number);
        let mut case = match family {
            Family::ThesisAxis | Family::EndStopThesis => thesis_draw::axis(draws, family, number),
            Family::Arm | Family::ArmUncoupled => arm_draw::arm(draws, family, number, kind),
            _ => in_si(draws, family, number, kind),
        };
        let draws = &mut Draws::new(seed, family.number(), Purpose::Condition, number);
        case.phase = kind.condition.apply(&mut case.joint, case.scale.angle, draws);
        case.delay = kind.condition.delay(case.delay);
        case.condition = kind.condition;
        let draws = &mut Draws::new(seed, family.number(), Purpose::Electrics, number);
        case.electrics = Electrics::draw(kind.bridge, &mut case, draws);
        case
    }
}

/// Draws a joint of the SI families: about 0.34 kg m^2, with 2 to 6 N m of slip friction.
fn in_si(draws: &mut Draws, family: Family, number: u64, kind: DrawOptions) -> Case {
    let [inertia, viscous] = NOMINAL.map(|nominal| nominal * draws.uniform(0.5, 1.5));
    let coulomb = draws.uniform(2.0, 6.0);
    // A load of three times a hard joint's friction would exceed the motor's largest effort.
    let hard = kind.hard && !family.is_overhauling();
    let ratio = if hard { draws.uniform(2.0, 4.0) } else { draws.uniform(1.05, 2.0) };
    let stribeck_velocity = draws.log_uniform(5e-3, 0.2);
    let curve = StribeckCurve { coulomb, stick: ratio * coulomb, stribeck_velocity, viscous };
    // Long enough that the wall is ahead of the joint with the coarse encoder, too.
    let least = if family.has_wall() { 0.01 } else { 1e-3 };
    let step = draws.sign() * draws.log_uniform(least, 0.5);
    let counts_per_turn = if number.is_multiple_of(2) { 1e5 } else { 1e4 };
    let count = TAU / counts_per_turn;
    let start = count * draws.uniform(-0.5, 0.5);
    let delay = if draws.coin() { Delay::OneSample } else { Delay::None };
    let lag_s = if draws.coin() { 0.7e-3 } else { 0.0 };

    let mut load = LoadTorque::default();
    let mut jump_counts = None;
    let side = if family.is_positioned_at_load() { DiscSide::Load } else { DiscSide::Motor };
    let train = match family {
        Family::Loaded => {
            load.constant = draws.uniform(-1.2, 1.2);
            Train::Rigid(Body { inertia, friction: curve.into() })
        }
        Family::Gravity => {
            let [amplitude, angle] = [draws.uniform(0.3, 1.2), draws.uniform(-PI, PI)];
            load.gravity = Some(Gravity { amplitude, angle });
            Train::Rigid(Body { inertia, friction: curve.into() })
        }
        Family::Overhauling => {
            load.constant = draws.sign() * overhauling(draws) * curve.stick;
            Train::Rigid(Body { inertia, friction: curve.into() })
        }
        Family::OverhaulingGravity => {
            let amplitude = draws.sign() * overhauling(draws) * curve.stick;
            load.gravity = Some(Gravity { amplitude, angle: draws.uniform(-PI, PI) });
            Train::Rigid(Body { inertia, friction: curve.into() })
        }
        Family::LuGre | Family::OverhaulingLuGre | Family::EndStopLuGre => {
            let deflection = count * draws.uniform(3.0, 10.0);
            load.constant = if family == Family::OverhaulingLuGre {
                draws.sign() * overhauling(draws) * curve.stick
            } else {
                draws.uniform(-1.2, 1.2)
            };
            let bristle = Bristle::breaking_at(deflection, curve.stick, inertia);
            Train::LuGre { inertia, curve, bristle }
        }
        Family::FlexibleMotor
        | Family::FlexibleBacklash
        | Family::GearBacklash
        | Family::FlexibleLoad
        | Family::OverhaulingFlexible
        | Family::EndStopFlexible
        | Family::TwoEncoders
        | Family::TwoEncodersBacklash
        | Family::TwoEncodersGearBacklash
        | Family::TwoEncodersWideBacklash
        | Family::TwoEncodersSoft
        | Family::TwoEncodersOverhauling
        | Family::TwoEncodersNoisy
        | Family::TwoEncodersEndStop => {
            let backlash = |draws: &mut Draws| match family {
                Family::GearBacklash | Family::TwoEncodersGearBacklash => {
                    let [least, most] = GEAR_BACKLASH_DEG.map(f64::to_radians);
                    draws.log_uniform(least, most)
                }
                Family::TwoEncodersWideBacklash => WIDE_BACKLASH_DEG.to_radians(),
                Family::FlexibleBacklash | Family::TwoEncodersBacklash => {
                    draws.uniform(0.0, 20.0 * count)
                }
                _ => draws.uniform(0.0, 4.0 * count),
            };
            let is_soft = family == Family::TwoEncodersSoft;
            let resonance_hz = if is_soft { SOFT_HZ } else { GEAR_HZ };
            let (train, jump) = flexible(draws, inertia, &curve, resonance_hz, backlash);
            jump_counts = (side == DiscSide::Load).then_some(jump / count);
            if family.is_overhauling() {
                load.constant = draws.sign() * overhauling(draws) * curve.stick;
            }
            train
        }
        Family::Dwell => {
            let [growth, time_s] = [draws.uniform(0.2, 1.0), draws.log_uniform(0.1, 10.0)];
            let dwell = Some(Dwell { growth, time_s });
            Train::Rigid(Body { inertia, friction: SetValuedFriction { dwell, ..curve.into() } })
        }
        Family::Drifting => {
            // The levels start at half to twice their final values.
            let thermal = Some(Thermal {
                start_k: 100.0 * draws.uniform(-LN_2, LN_2),
                heating_k_per_w: 0.0,
                time_s: draws.log_uniform(2.0, 20.0),
                levels_per_k: 0.01,
                viscous_per_k: 0.01,
            });
            Train::Rigid(Body { inertia, friction: SetValuedFriction { thermal, ..curve.into() } })
        }
        Family::Rigid
        | Family::Noisy
        | Family::NoisyDeclared
        | Family::EndStop
        | Family::ThesisAxis
        | Family::EndStopThesis
        | Family::Arm
        | Family::ArmUncoupled => Train::Rigid(Body { inertia, friction: curve.into() }),
    };
    let stops = if family.has_wall() { wall(step, count) } else { Stops::default() };

    let scale = UnitScale { effort: EFFORT[0] / 5.0, angle: PI / 180.0 };
    let breakaway = if hard { HARD_BREAKAWAY } else { BREAKAWAY };
    let is_braked = family.is_overhauling();
    let largest_load = if is_braked { OVERHAULING[1] * BREAKAWAY[1] } else { 0.0 };
    let bounds =
        scale.bounds(NOMINAL, breakaway, largest_load, EFFORT, [count, 1.0 / kind.rate_hz]);
    // Drawn after the joint, so that the joint is the same without it.
    let known = if is_braked { draws.uniform(0.8, 1.2) } else { 0.0 };
    let is_noise_known = matches!(family, Family::NoisyDeclared | Family::TwoEncodersNoisy);
    let jitter = if is_noise_known { 2.0 } else { 0.0 };
    let motor_encoder = family.has_two_encoders().then(|| {
        let finer = draws.log_uniform(1.0, 100.0).round();
        JointEncoder { count: count / finer, side: DiscSide::Motor }
    });
    let twist =
        if family.has_two_encoders() { wound_up(draws, &train, load.constant) } else { 0.0 };
    let bounds = JointBounds {
        encoder_at_load: side == DiscSide::Load,
        jitter,
        motor_encoder: motor_encoder.map(|motor| MotorEncoder {
            count: motor.count / scale.angle,
            jitter,
            gear: None,
        }),
        hold_effort: -known * load.at(start) / scale.effort,
        ..bounds
    };
    let (distance, speed, dwell_s, half_blend_s) = (0.5 * step.signum(), 0.5, 0.5, 0.125);
    Case {
        family,
        number,
        joint: Description { load, lag_s, start, twist, stops, ..Description::of(train, count) },
        encoder: JointEncoder { count, side },
        motor_encoder,
        delay,
        scale,
        bounds,
        step,
        trapezoid: Trapezoid { distance, speed, dwell_s, half_blend_s },
        is_braked,
        jump_counts,
        condition: Condition::Nominal,
        phase: 0.0,
        electrics: None,
        arm: None,
    }
}

/// Draws a load that drives the joint, in multiples of its stick friction.
fn overhauling(draws: &mut Draws) -> f64 {
    let [least, most] = OVERHAULING;
    draws.uniform(least, most)
}

/// Draws the twist of the shaft at the start, rad. Its torque differs from the one that holds the
/// load by up to nine tenths of the smaller stick friction of motor and load. Zero without a shaft.
fn wound_up(draws: &mut Draws, train: &Train, load_torque: f64) -> f64 {
    let Train::Flexible { motor, load, shaft } = train else { return 0.0 };
    let holds = motor.friction.curve.stick.min(load.friction.curve.stick);
    let torque = draws.uniform(-0.9, 0.9) * holds - load_torque;
    torque / shaft.stiffness + torque.signum() * 0.5 * shaft.backlash
}

/// Draws two inertias and a shaft; also returns how far the load slides when it breaks away, rad.
fn flexible(
    draws: &mut Draws,
    inertia: f64,
    curve: &StribeckCurve,
    [least_hz, most_hz]: [f64; 2],
    backlash: impl Fn(&mut Draws) -> f64,
) -> (Train, f64) {
    let of_motor = draws.uniform(0.2, 0.8);
    let [motor_inertia, load_inertia] = [of_motor * inertia, (1.0 - of_motor) * inertia];
    // The load's resonance with the motor locked.
    let stiffness = load_inertia * (TAU * draws.log_uniform(least_hz, most_hz)).powi(2);
    let ratio = draws.uniform(0.01, 0.05);
    let damping = 2.0 * ratio * (stiffness * motor_inertia * load_inertia / inertia).sqrt();
    let backlash = backlash(draws);
    let of_friction = draws.uniform(0.3, 0.9);
    let share = |share: f64| StribeckCurve {
        coulomb: share * curve.coulomb,
        stick: share * curve.stick,
        viscous: share * curve.viscous,
        ..*curve
    };
    let (of_motor, of_load) = (share(of_friction), share(1.0 - of_friction));
    // Balance of energy: the spring that is wound up to F_s unwinds to as far below F_c.
    let jump = 2.0 * (of_load.stick - of_load.coulomb) / stiffness;
    let train = Train::Flexible {
        motor: Body { inertia: motor_inertia, friction: of_motor.into() },
        load: Body { inertia: load_inertia, friction: of_load.into() },
        shaft: ShaftDescription { stiffness, damping, backlash },
    };
    (train, jump)
}

#[cfg(test)]
mod tests {
    use super::super::thesis_draw::{BREAKAWAY as THESIS_BREAKAWAY, NOMINAL as THESIS};
    use super::*;

    const EASY: DrawOptions = DrawOptions::ORDINARY;
    const CASES: u64 = 4000;

    fn drawn(family: Family, kind: DrawOptions) -> Vec<Case> {
        (0..CASES).map(|number| Case::draw(1, family, number, kind)).collect()
    }

    /// Returns the mean of a value over cases.
    fn mean(cases: &[Case], of: impl Fn(&Case) -> f64) -> f64 {
        cases.iter().map(of).sum::<f64>() / cases.len() as f64
    }

    fn bodies(case: &Case) -> [Body; 2] {
        match case.joint.train {
            Train::Rigid(body) => [body, body],
            Train::Flexible { motor, load, .. } => [motor, load],
            Train::LuGre { inertia, curve, .. } => [Body { inertia, friction: curve.into() }; 2],
        }
    }

    #[test]
    fn moments_of_the_joints_are_those_of_the_table() {
        let cases = drawn(Family::Rigid, EASY);
        let curve = |case: &Case| bodies(case)[0].friction.curve;
        // Five standard errors: sigma of U(a, b) is (b - a)/sqrt(12).
        let within = |found: f64, expected: f64, width: f64| {
            let limit = 5.0 * width / 12f64.sqrt() / (CASES as f64).sqrt();
            assert!((found - expected).abs() < limit, "{found} {expected}");
        };
        within(mean(&cases, |case| bodies(case)[0].inertia), 0.34, 0.34);
        within(mean(&cases, |case| curve(case).viscous), 1.3, 1.3);
        within(mean(&cases, |case| curve(case).coulomb), 4.0, 4.0);
        within(mean(&cases, |case| curve(case).stick / curve(case).coulomb), 1.525, 0.95);
        within(mean(&cases, |case| case.joint.start / case.count()), 0.0, 1.0);
        within(mean(&cases, |case| f64::from(u8::from(case.delay == Delay::OneSample))), 0.5, 1.8);
        within(mean(&cases, |case| case.joint.lag_s), 0.35e-3, 0.7e-3 * 1.8);
        let ln = |a: f64, b: f64| (0.5 * (a * b).ln(), (b / a).ln());
        let (expected, width) = ln(5e-3, 0.2);
        within(mean(&cases, |case| curve(case).stribeck_velocity.ln()), expected, width);
        let (expected, width) = ln(1e-3, 0.5);
        within(mean(&cases, |case| case.step.abs().ln()), expected, width);
        within(mean(&cases, |case| case.step.signum()), 0.0, 2.0 * 1.8);
        let hard = drawn(Family::Rigid, DrawOptions { hard: true, ..EASY });
        within(mean(&hard, |case| curve(case).stick / curve(case).coulomb), 3.0, 2.0);
    }

    #[test]
    fn the_data_sheet_encloses_what_is_drawn() {
        for hard in [false, true] {
            for family in Family::all() {
                for case in drawn(family, DrawOptions { hard, ..EASY }) {
                    let bodies = bodies(&case);
                    let is_flexible = matches!(case.joint.train, Train::Flexible { .. });
                    let stick = bodies[0].friction.curve.stick
                        + if is_flexible { bodies[1].friction.curve.stick } else { 0.0 };
                    let stick_v = stick / case.scale.effort;
                    let [low, high] = case.bounds.breakaway;
                    let bounds = (low - 1e-9)..=(high + 1e-9);
                    assert!(bounds.contains(&stick_v), "{family:?}: {stick_v}");
                    assert!(case.joint.build().is_ok(), "{case:?}");
                    // The motor can move every joint.
                    let LoadTorque { constant, gravity } = case.joint.load;
                    let load = constant.abs() + gravity.map_or(0.0, |of| of.amplitude.abs());
                    let [full_scale, count] =
                        [case.bounds.sampled.largest_effort, case.bounds.sampled.count];
                    assert!(load + stick < full_scale * case.scale.effort, "{case:?}");
                    assert!((count * case.scale.angle / case.count() - 1.0).abs() < 1e-12);
                    assert_eq!(case.jump_counts.is_some(), family.is_positioned_at_load());
                }
            }
        }
    }

    #[test]
    fn loads_are_below_the_friction_but_where_they_shall_drive_the_joint() {
        let share = |case: &Case| {
            let gravity = case.joint.load.gravity.map_or(0.0, |of| of.amplitude.abs());
            let load = case.joint.load.constant.abs().max(gravity);
            load / bodies(case)[0].friction.curve.stick
        };
        for family in [Family::Loaded, Family::Gravity, Family::LuGre] {
            let cases = drawn(family, EASY);
            assert!(cases.iter().all(|case| (0.0..0.6).contains(&share(case)) && !case.is_braked));
            assert!(mean(&cases, share) > 0.05, "{family:?}");
        }
        for family in [Family::Overhauling, Family::OverhaulingGravity, Family::OverhaulingLuGre] {
            let driven = drawn(family, EASY);
            assert!(driven.iter().all(|case| (0.5..3.0).contains(&share(case)) && case.is_braked));
            let more = driven.iter().filter(|case| share(case) > 1.0).count() as f64 / CASES as f64;
            assert!((more - 0.8).abs() < 0.04, "{more}");
            // The known effort holds the load where the joint is armed, within 20 %.
            for case in &driven {
                let held = -case.bounds.hold_effort * case.scale.effort;
                let load = case.joint.load.at(case.joint.start);
                assert!((0.8..1.2).contains(&(held / load)), "{family:?}: {held} {load}");
            }
        }
        for case in drawn(Family::OverhaulingFlexible, EASY) {
            let [motor, load] = bodies(&case).map(|body| body.friction.curve.stick);
            let share = case.joint.load.constant.abs() / (motor + load);
            assert!((0.5..3.0).contains(&share) && case.is_braked, "{share}");
        }
    }

    #[test]
    fn a_wall_stands_five_counts_before_the_target_on_the_way_there() {
        for family in Family::all().filter(|family| family.has_wall()) {
            for case in drawn(family, EASY) {
                let Stops { lower, upper } = case.joint.stops;
                let wall = if case.step > 0.0 { upper } else { lower };
                let before = (case.step - wall) / case.count() * case.step.signum();
                assert!((before - 5.0).abs() < 1e-6, "{family:?}: {before}");
                assert!(lower.is_infinite() || upper.is_infinite());
                // It is on the way, and not behind the joint.
                assert!(wall * case.step > 0.0 && wall.abs() > 10.0 * case.count());
            }
        }
    }

    #[test]
    fn the_core_s_volts_and_degrees_are_those_of_the_thesis_for_the_thesis_s_axis() {
        let bounds = Case::draw(1, Family::ThesisAxis, 0, EASY).bounds;
        assert_eq!([bounds.inertia, bounds.viscous], THESIS);
        assert_eq!((bounds.breakaway, bounds.sampled.count), (THESIS_BREAKAWAY, 0.00242));
        // 0.34 kg m^2 at 12 N m/V: a volt accelerates by 12/0.34 rad/s^2 = 2022 deg/s^2.
        let bounds = Case::draw(1, Family::Rigid, 0, EASY).bounds;
        assert!((1.0 / bounds.inertia - 2022.2).abs() < 0.1, "{}", bounds.inertia);
        assert!(
            (bounds.sampled.largest_effort - 5.0).abs() < 1e-12
                && (bounds.sampled.lsb - 0.005).abs() < 1e-12
        );
    }
}
