//! The flexible joint.

use super::*;

fn flexible(backlash: f64) -> Description {
    let half = Stribeck { coulomb: 2.0, stick: 3.0, stribeck_velocity: 0.05, viscous: 0.65 };
    let body = |inertia| Body { inertia, friction: half.into() };
    let shaft = Shaft { stiffness: 900.0, damping: 0.4, backlash };
    Description::of(Train::Flexible { motor: body(0.14), load: body(0.2), shaft }, COUNT)
}

#[test]
fn two_bodies_stick_and_slip_as_in_time_stepping() {
    for (backlash, lag_s) in [(0.0, 0.0), (4.0 * COUNT, 0.7e-3), (20.0 * COUNT, 0.0)] {
        let gravity = Some(Gravity { amplitude: 0.6, angle: 0.4 });
        let load = Load { constant: 0.2, gravity };
        let push = Some(Push { torque: 5.0, from_s: 0.1004, until_s: 0.2503 });
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
    let smooth = Stribeck { coulomb: 0.0, stick: 0.0, stribeck_velocity: 0.0, viscous: 0.0 };
    let (jm, jl, k, effort) = (0.14, 0.2, 900.0, 2.0);
    let body = |inertia| Body { inertia, friction: smooth.into() };
    let shaft = Shaft { stiffness: k, damping: 0.0, backlash: 0.0 };
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
    let levels = Stribeck { coulomb: 2.0, stick: 3.0, stribeck_velocity: 0.0, viscous: 0.0 };
    let body = |inertia| Body { inertia, friction: levels.into() };
    let shaft = Shaft { stiffness: 900.0, damping: 0.0, backlash: 0.0 };
    let train = Train::Flexible { motor: body(0.14), load: body(0.2), shaft };
    for (torque, wanted) in [(2.99, 0.0), (3.5, 2.0 * (3.5 - 2.0) / 900.0)] {
        let push = Some(Push { torque, from_s: 0.0105, until_s: 1.0 });
        let mut joint = Description { push, ..Description::of(train, COUNT) }.build().unwrap();
        joint.set_brake(100.0);
        (0..200).for_each(|_| joint.hold(0.0, 1e-3));
        assert!(joint.is_stuck() && joint.motor().position == 0.0);
        assert!((joint.load().position - wanted).abs() < 1e-3 * COUNT);
    }
}
