//! Positions consist of counts and a fraction.

use stiction::units::position::Position;

use super::HALF_ULP;

#[test]
fn displaced_position_keeps_its_fraction_below_one() {
    let zero = Position::default();
    let almost_one = 1f32.next_down();
    // The first three end nearer to a whole count than an `f32` below one can resolve.
    for (from, displacement, to) in [
        (zero, -1e-9, zero),
        (zero, -f32::from_bits(1), zero),
        (
            Position { counts: i32::MAX, fraction: almost_one },
            4e-8,
            Position::from_counts(i32::MIN),
        ),
        (zero, -HALF_ULP as f32, Position { counts: -1, fraction: almost_one }),
        (Position { counts: i32::MAX, fraction: 0.75 }, 0.25, Position::from_counts(i32::MIN)),
        (
            Position { counts: i32::MIN, fraction: 0.25 },
            -0.5,
            Position { counts: i32::MAX, fraction: 0.75 },
        ),
    ] {
        assert_eq!(from.displaced(displacement), to, "{from:?} by {displacement}");
    }
}
