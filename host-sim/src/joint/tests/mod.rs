//! Joints against closed forms and second methods.

mod flexible;
mod lugre;
mod reference;
mod rigid;

use super::*;

/// One count of 100,000 a turn, rad.
const COUNT: f64 = std::f64::consts::TAU / 1e5;

/// The nominal joint of the ensemble, with friction that falls over a Stribeck velocity.
const CURVE: Stribeck =
    Stribeck { coulomb: 4.0, stick: 6.0, stribeck_velocity: 0.02, viscous: 1.3 };

/// The ensemble's nominal inertia, kg m^2.
const INERTIA: f64 = 0.34;

fn rigid(curve: Stribeck) -> Description {
    Description::of(Train::Rigid(Body { inertia: INERTIA, friction: curve.into() }), COUNT)
}

/// An effort (N m) that starts, reverses, stops and hunts a joint, at a sample of 1 ms.
fn effort(sample: u32) -> f64 {
    let t = f64::from(sample) * 1e-3;
    9.0 * (17.0 * t).sin() + 5.0 * (61.0 * t).sin() + 3.0 * (7.0 * t).cos()
}

/// How far a joint is from the second method at worst, in counts, over samples of 1 ms; and what
/// halving the second method's step changes, which is the error that it has itself.
fn against_time_stepping(
    joint: &Description,
    effort: impl Fn(u32) -> f64,
    samples: u32,
) -> (f64, f64) {
    let coarse = reference::positions(joint, &effort, samples, 1000);
    let fine = reference::positions(joint, &effort, samples, 2000);
    let mut moved = joint.build().unwrap();
    let (mut worst, mut own) = (0.0_f64, 0.0_f64);
    for sample in 0..samples {
        moved.hold(effort(sample), 1e-3);
        let found = [moved.motor().position, moved.load().position];
        let i = sample as usize;
        for side in 0..2 {
            // The second method's error falls like h: what it tends to.
            let limit = 2.0 * fine[i][side] - coarse[i][side];
            worst = worst.max((found[side] - limit).abs() / joint.count);
            own = own.max((fine[i][side] - coarse[i][side]).abs() / joint.count);
        }
    }
    (worst, own)
}
