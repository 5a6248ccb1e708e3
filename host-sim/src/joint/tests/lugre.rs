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
        let load = Load { constant: 0.8, gravity: Some(Gravity { amplitude: 1.0, angle: 0.4 }) };
        let joint = Description { lag_s, load, ..lugre(counts) };
        let (worst, own) = against_time_stepping(&joint, effort, 1000);
        println!("{counts} {lag_s} {worst} {own}");
    }
}
