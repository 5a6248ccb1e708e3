//! The flexible joint.

use super::*;

fn flexible(backlash: f64) -> Description {
    let half = StribeckCurve { coulomb: 2.0, stick: 3.0, stribeck_velocity: 0.05, viscous: 0.65 };
    let body = |inertia| Body { inertia, friction: half.into() };
    let shaft = ShaftDescription { stiffness: 900.0, damping: 0.4, backlash };
    Description::of(Train::Flexible { motor: body(0.14), load: body(0.2), shaft }, COUNT)
}

#[test]
fn two_bodies_stick_and_slip_as_in_time_stepping() {
    for (backlash, lag_s) in [(0.0, 0.0), (4.0 * COUNT, 0.7e-3), (20.0 * COUNT, 0.0)] {
        let gravity = Some(Gravity { amplitude: 0.6, angle: 0.4 });
        let load = LoadTorque { constant: 0.2, gravity };
        let push = Some(TorquePulse { torque: 5.0, from_s: 0.1004, until_s: 0.2503 });
        let stops = Stops { lower: -0.3, upper: 0.1 };
        let joint = Description { lag_s, load, push, stops, ..flexible(backlash) };
        let worst = against_time_stepping(&joint, effort, 1000);
        assert!(worst < 0.05, "backlash {backlash}, lag {lag_s} s: {worst} counts");
    }
}

/// Without friction and damping the twist swings at `omega^2 = k (1/J_m + 1/J_l)` about what the
/// effort bends, and the centre of mass moves evenly.
#[test]
fn a_frictionless_shaft_swings_at_its_resonance() {
    let smooth = StribeckCurve { coulomb: 0.0, stick: 0.0, stribeck_velocity: 0.0, viscous: 0.0 };
    let (jm, jl, k, effort) = (0.14, 0.2, 900.0, 2.0);
    let body = |inertia| Body { inertia, friction: smooth.into() };
    let shaft = ShaftDescription { stiffness: k, damping: 0.0, backlash: 0.0 };
    let train = Train::Flexible { motor: body(jm), load: body(jl), shaft };
    let mut joint = Description::of(train, COUNT).build().unwrap();
    let omega = (k * (1.0 / jm + 1.0 / jl)).sqrt();
    for sample in 1..=2000 {
        joint.hold(effort, 1e-3);
        let t = f64::from(sample) * 1e-3;
        let centre = 0.5 * effort / (jm + jl) * t * t;
        let twist = effort * jl / (jm + jl) / k * (1.0 - (omega * t).cos());
        let motor = centre + twist * jl / (jm + jl);
        let load = centre - twist * jm / (jm + jl);
        let errors = [joint.motor().position - motor, joint.load().position - load];
        assert!(errors.iter().all(|error| error.abs() < 0.05 * COUNT), "{errors:?} at {t} s");
    }
}

/// With the motor held, a torque P on the load takes it `2 (P - F_c)/k` far, and there it sticks.
#[test]
fn a_pushed_load_jumps_as_far_as_its_closed_form() {
    let levels = StribeckCurve { coulomb: 2.0, stick: 3.0, stribeck_velocity: 0.0, viscous: 0.0 };
    let body = |inertia| Body { inertia, friction: levels.into() };
    let shaft = ShaftDescription { stiffness: 900.0, damping: 0.0, backlash: 0.0 };
    let train = Train::Flexible { motor: body(0.14), load: body(0.2), shaft };
    for (torque, wanted) in [(2.99, 0.0), (3.5, 2.0 * (3.5 - 2.0) / 900.0)] {
        let push = Some(TorquePulse { torque, from_s: 0.0105, until_s: 1.0 });
        let mut joint = Description { push, ..Description::of(train, COUNT) }.build().unwrap();
        joint.set_brake(100.0);
        (0..200).for_each(|_| joint.hold(0.0, 1e-3));
        assert!(joint.is_stuck() && joint.motor().position == 0.0);
        assert!((joint.load().position - wanted).abs() < 1e-3 * COUNT);
    }
}

/// A motor that creeps winds the shaft up until the load breaks away, jumps and sticks again: each
/// break is at its limit but for rounding, and is not taken back.
#[test]
fn a_creeping_motor_lets_the_load_stick_and_slip() {
    let curve = |coulomb, stick, viscous| StribeckCurve {
        coulomb,
        stick,
        stribeck_velocity: 0.006,
        viscous,
    };
    let motor = Body { inertia: 0.133, friction: curve(2.96, 4.50, 1.18).into() };
    let load = Body { inertia: 0.158, friction: curve(0.893, 1.355, 0.356).into() };
    for backlash in [2.0 * COUNT, 20.0 * COUNT] {
        let shaft = ShaftDescription { stiffness: 208.0, damping: 0.33, backlash };
        let joint = Description::of(Train::Flexible { motor, load, shaft }, COUNT);
        let worst =
            against_time_stepping(&joint, |k| 4.6 + 1.2 * (0.05 * f64::from(k)).sin(), 1500);
        assert!(worst < 0.1, "{worst} counts");
    }
}

/// A hunting PID brings motor and load to their switches in any order and at nearly the same
/// instant. The solver must not skip any time.
#[test]
fn a_hunting_controller_does_not_stop_the_time() {
    // A linear congruential generator for the draws (Knuth's constants).
    let mut state = 1_u64;
    let mut draw = |from: f64, to: f64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for case in 0..150 {
        let (share, part, level) = (draw(0.2, 0.8), draw(0.3, 0.9), draw(2.0, 6.0));
        let (ratio, speed) = (draw(1.05, 2.0), draw(0.005, 0.1));
        let body = |share: f64, part: f64| {
            let (coulomb, stick) = (level * part, level * part * ratio);
            let curve =
                StribeckCurve { coulomb, stick, stribeck_velocity: speed, viscous: 1.3 * part };
            Body { inertia: INERTIA * share, friction: curve.into() }
        };
        let stiffness = INERTIA * (1.0 - share) * (std::f64::consts::TAU * draw(5.0, 50.0)).powi(2);
        let damping = 0.06 * (stiffness * INERTIA * share * (1.0 - share)).sqrt();
        let shaft = ShaftDescription { stiffness, damping, backlash: draw(0.0, 20.0) * COUNT };
        let (motor, load) = (body(share, part), body(1.0 - share, 1.0 - part));
        let lag_s = if case % 2 == 0 { 0.0 } else { 0.7e-3 };
        let train = Train::Flexible { motor, load, shaft };
        let mut joint = Description { lag_s, ..Description::of(train, 1e-2) }.build().unwrap();
        let encoder = JointEncoder { count: COUNT, side: DiscSide::Motor };
        let (mut sum, mut last, mut speed) = (0.0, 0.0, 0.0);
        for sample in 0..3000 {
            let position = encoder.read(&joint) as f64 * COUNT;
            let error = 0.1 * (f64::from(sample) * 1e-3).min(1.0) - position;
            speed += 0.3 * ((position - last) * 1e3 - speed);
            last = position;
            sum += error * 1e-3;
            let effort = 850.0 * error + 4250.0 * sum - 30.0 * speed;
            joint.hold((effort.clamp(-60.0, 60.0) / 0.06).round() * 0.06, 1e-3);
        }
        assert_eq!(joint.unfollowed_s(), 0.0, "case {case}: {train:?}");
    }
}

/// A motor without friction swings on the shaft of a load at rest: `T = u (1 - cos(w t))`. With
/// `2 u = F (1 + e)` the load breaks away shortly before the torque falls again, and halts after
/// `9 F e^2 / (J_l w^2)`, to the lowest order in e. All of it can happen within one step.
#[test]
fn a_load_that_breaks_away_for_a_moment_halts_again() {
    let (jm, jl, k, limit) = (0.14, 0.2, 900.0, 3.0);
    let level =
        |f| StribeckCurve { coulomb: f, stick: f, stribeck_velocity: 0.05, viscous: 0.0 }.into();
    let motor = Body { inertia: jm, friction: level(0.0) };
    let load = Body { inertia: jl, friction: level(limit) };
    let shaft = ShaftDescription { stiffness: k, damping: 0.0, backlash: 0.0 };
    let train = Train::Flexible { motor, load, shaft };
    let omega_squared = k / jm;
    let peak_s = std::f64::consts::PI / f64::sqrt(omega_squared);
    for case in 1..=200 {
        let excess = 5e-6 * f64::from(case);
        let mut joint = Description::of(train, COUNT).build().unwrap();
        joint.hold(0.5 * limit * (1.0 + excess), 1.5 * peak_s);
        assert_eq!(joint.unfollowed_s(), 0.0, "{excess}");
        assert_eq!(joint.load().velocity, 0.0, "{excess}");
        let way = joint.load().position / (9.0 * limit * excess * excess / (jl * omega_squared));
        assert!(excess < 5e-4 || (way - 1.0).abs() < 0.05, "{excess}: {way}");
    }
}

/// The torque of the gear is in the middle of the range that friction allows, on the flank that the
/// load presses: `|T|` from `|d| - F_l` to the smaller of `|d|` and `F_m`.
#[test]
fn a_wound_up_joint_rests_with_its_load_on_a_flank_and_stays_there() {
    // F_m and F_l are 3 N m, half of the backlash is 10 counts.
    for (d, torque) in [(4.0, 2.0_f64), (-4.0, -2.0), (3.5, 1.75), (-5.5, -2.75)] {
        for seen in [DiscSide::Motor, DiscSide::Load] {
            let load = LoadTorque { constant: d, gravity: None };
            let description = Description { load, ..flexible(20.0 * COUNT) };
            let mut joint = description.build().unwrap();
            joint.wind_up(seen);
            let (motor, load) = (joint.motor().position, joint.load().position);
            let twist = 10.0 * COUNT * torque.signum() + torque / 900.0;
            assert!((load - motor - twist).abs() < 1e-12, "{d} N m: {motor}, {load}");
            let seen = if seen == DiscSide::Motor { motor } else { load };
            assert_eq!(seen, 0.0, "{d} N m");
            (0..100).for_each(|_| joint.hold(0.0, 1e-3));
            assert!(joint.is_stuck());
            assert_eq!((joint.motor().position, joint.load().position), (motor, load));
        }
    }
}

#[test]
fn a_load_that_friction_holds_stays_in_the_slack_and_one_that_it_does_not_hold_falls() {
    for (d, is_held) in [(2.9, true), (6.1, false)] {
        let load = LoadTorque { constant: d, gravity: None };
        let mut joint = Description { load, ..flexible(20.0 * COUNT) }.build().unwrap();
        joint.wind_up(DiscSide::Motor);
        assert_eq!((joint.motor().position, joint.load().position), (0.0, 0.0), "{d} N m");
        (0..100).for_each(|_| joint.hold(0.0, 1e-3));
        assert_eq!(joint.load().position == 0.0, is_held, "{d} N m");
    }
}
