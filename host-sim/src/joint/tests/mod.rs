//! Joints against closed forms and second methods.

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
