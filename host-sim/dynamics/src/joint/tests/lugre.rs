//! The joint with a bristle.

use super::*;

fn lugre(counts: f64) -> Description {
    let bristle = Bristle::breaking_at(counts * COUNT, CURVE.stick, INERTIA);
    let train = Train::LuGre { inertia: INERTIA, curve: CURVE, bristle };
    Description::of(train, COUNT)
}

#[test]
fn a_bristle_moves_as_in_time_stepping() {
    for (counts, lag_s) in [(10.0, 0.0), (3.0, 0.7e-3)] {
        let load =
            LoadTorque { constant: 0.8, gravity: Some(Gravity { amplitude: 1.0, angle: 0.4 }) };
        let push = Some(TorquePulse { torque: 5.0, from_s: 0.1004, until_s: 0.2503 });
        let stops = Stops { lower: -0.3, upper: 0.1 };
        let joint = Description { lag_s, load, push, stops, ..lugre(counts) };
        let worst = against_time_stepping(&joint, effort, 1000);
        assert!(worst < 0.05, "{counts} counts, lag {lag_s} s: {worst} counts");
    }
}

/// A slow effort up to `s F_s` and back moves the joint by `-d ln(1 - s)` and then to
/// `-d ln(1 - s^2)`, with d the deflection at the break; there it comes to rest.
#[test]
fn a_joint_below_its_break_gives_way_as_the_bristle_s_closed_form() {
    let mut joint = lugre(5.0).build().unwrap();
    let s: f64 = 0.5;
    let mut ramp = |from: f64, to: f64| {
        for step in 1..=4000 {
            let part = f64::from(step) / 4000.0;
            joint.hold((from + (to - from) * part) * CURVE.stick, 1e-3);
        }
        (0..200).for_each(|_| joint.hold(to * CURVE.stick, 1e-3));
        assert!(joint.is_stuck());
        joint.motor().position / COUNT
    };
    let there = ramp(0.0, s);
    assert!((there + 5.0 * (1.0 - s).ln()).abs() < 0.01, "{there} counts");
    let back = ramp(s, 0.0);
    assert!((back + 5.0 * (1.0 - s * s).ln()).abs() < 0.01, "{back} counts");
    let before = joint.motor();
    joint.hold(0.0, 1e-3);
    assert_eq!(joint.motor(), before);
}

/// In steady motion the effort is `g(v) + B v`.
#[test]
fn steady_sliding_takes_the_effort_of_the_curve() {
    let mut joint = lugre(5.0).build().unwrap();
    (0..4000).for_each(|_| joint.hold(6.5, 1e-3));
    let v = joint.motor().velocity;
    let StribeckCurve { coulomb, stick, stribeck_velocity, viscous } = CURVE;
    let level = coulomb + (stick - coulomb) * (-(v / stribeck_velocity).powi(2)).exp();
    assert!((level + viscous * v - 6.5).abs() < 1e-4, "{v} rad/s");
}
