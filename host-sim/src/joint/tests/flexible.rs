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
        let joint = Description { lag_s, ..flexible(backlash) };
        let (worst, own) = against_time_stepping(&joint, effort, 1000);
        println!("{backlash} {lag_s} {worst} {own}");
    }
}
