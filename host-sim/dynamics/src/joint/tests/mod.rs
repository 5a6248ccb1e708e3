//! Compares joints with closed forms and with second methods.

mod arm;
mod flexible;
mod lugre;
mod reference;
mod rigid;

use super::*;

/// One count of 100,000 a turn, rad.
const COUNT: f64 = std::f64::consts::TAU / 1e5;

/// The nominal joint of the ensemble, with friction that falls over a Stribeck velocity.
const CURVE: StribeckCurve =
    StribeckCurve { coulomb: 4.0, stick: 6.0, stribeck_velocity: 0.02, viscous: 1.3 };

/// The ensemble's nominal inertia, kg m^2.
const INERTIA: f64 = 0.34;

fn rigid(curve: StribeckCurve) -> Description {
    Description::of(Train::Rigid(Body { inertia: INERTIA, friction: curve.into() }), COUNT)
}

/// Returns an effort (N m) that starts, reverses, stops and hunts a joint; a sample is 1 ms.
fn effort(sample: u32) -> f64 {
    let t = f64::from(sample) * 1e-3;
    9.0 * (17.0 * t).sin() + 5.0 * (61.0 * t).sin() + 3.0 * (7.0 * t).cos()
}

/// Returns the largest deviation of a joint from the second method, counts, over samples of 1 ms.
/// The second method runs with two steps h and is extrapolated to h = 0, since its error falls like
/// h. At switches the error falls by leaps, and a hundredth of a count remains.
fn against_time_stepping(joint: &Description, effort: impl Fn(u32) -> f64, samples: u32) -> f64 {
    let coarse = reference::positions(joint, &effort, samples, 500);
    let fine = reference::positions(joint, &effort, samples, 1000);
    let mut moved = joint.build().unwrap();
    let (mut worst, mut travel) = (0.0_f64, 0.0_f64);
    let mut last = joint.start;
    for (sample, (coarse, fine)) in (0..samples).zip(coarse.iter().zip(&fine)) {
        moved.hold(effort(sample), 1e-3);
        let found = [moved.motor().position, moved.load().position];
        for side in 0..2 {
            let limit = 2.0 * fine[side] - coarse[side];
            worst = worst.max((found[side] - limit).abs() / joint.count);
        }
        travel += (found[0] - last).abs() / joint.count;
        last = found[0];
    }
    assert!(travel > 5000.0, "the joint has moved {travel} counts only");
    worst
}
