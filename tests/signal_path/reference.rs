//! A reference depends on each of its parameters.

use stiction::control::reference::{Corner, Reference, Setpoint, Step, Trajectory};
use stiction::units::position::Position;

use super::trajectory::thesis;
use super::{RESOLUTION, SAMPLE_TIME};

#[test]
fn every_parameter_of_a_reference_changes_it() {
    let positions =
        |reference: &Reference| (0..1300).map(|tick| reference.at(tick)).collect::<Vec<_>>();
    let trajectory = |change: &dyn Fn(&mut Vec<Corner>, &mut [f32; 3])| {
        let mut corners = thesis();
        let mut numbers = [0.25, SAMPLE_TIME, RESOLUTION];
        change(&mut corners, &mut numbers);
        let [half_blend_s, sample_time, resolution] = numbers;
        positions(&Reference::Trajectory(
            Trajectory::new(&corners, half_blend_s, sample_time, resolution).unwrap(),
        ))
    };
    let base = trajectory(&|_, _| {});
    for i in 0..4 {
        assert_ne!(trajectory(&|corners, _| corners[i].tick += 1), base, "time of corner {i}");
        assert_ne!(
            trajectory(&|corners, _| corners[i].position.counts += 1),
            base,
            "counts of corner {i}"
        );
        assert_ne!(
            trajectory(&|corners, _| corners[i].position.fraction += 0.25),
            base,
            "fraction of corner {i}"
        );
    }
    assert_ne!(trajectory(&|corners, _| corners.truncate(3)), base, "number of corners");
    for (i, name) in ["half blend", "sample time", "resolution"].iter().enumerate() {
        assert_ne!(trajectory(&|_, numbers| numbers[i] *= 1.05), base, "{name}");
    }

    let step =
        Step { from: Position::from_counts(3), to: Position::from_counts(2066), at_tick: 50 };
    let at = positions(&Reference::Step(step));
    let [from, to] = [3, 2066].map(|counts| Setpoint::at_rest(Position::from_counts(counts)));
    assert_eq!((at[0], at[49], at[50], at[1299]), (from, from, to, to));
}
