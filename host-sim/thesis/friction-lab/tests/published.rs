//! Closed forms, and numbers of an independent simulation (thesis Tables 1-2, 7-8, 10-11).

use dynamics::solver::EventKind::{self, Break, Reverse, Stick};
use friction_lab::mechanism::{Pull, SpringMass};
use friction_lab::solver::event_driven;

use super::common::{
    ARM, ARM_LEVELS, Everything, PENDULUM, PENDULUM_LEVELS, SPRING_MASS, SPRING_MASS_LEVELS,
    assert_events, exact,
};

/// Closed form: stuck until K V_o t = F_s; then x = V_o (t - sin(w t)/w) + (F_s - F_d)/K (1 - cos(w
/// t)), w = 31.6 rad/s.
#[test]
fn the_block_on_a_spring_climbs_the_closed_form_s_staircase() {
    let (events, finish) = exact(&SPRING_MASS, &SPRING_MASS_LEVELS, 1e-9, 5.0);
    let (slip_s, period_s) = (0.107303620967653, 0.607303620967653);
    let mut expected: Vec<(f64, usize, EventKind)> = Vec::new();
    for i in 0..7 {
        let break_s = 1.25 + f64::from(i) * period_s;
        expected.extend([(break_s, 1, Break), (break_s + slip_s, 1, Stick)]);
    }
    expected.pop();
    assert_events(&events, &expected, 1e-8);
    // The height of a step, by a run that ends on it.
    for step in 1..=6_u32 {
        let (_, stuck) =
            exact(&SPRING_MASS, &SPRING_MASS_LEVELS, 1e-9, 0.95 + f64::from(step) * period_s);
        let height = f64::from(step) * 1.21460724193531e-3;
        assert!((stuck.q[0] / height - 1.0).abs() < 1e-7 && stuck.v[0] == 0.0, "{step}: {stuck:?}");
    }
    assert!(finish.v[0] > 0.0, "it ends in mid-slip");
}

/// Stuck until `(1 + d) sin(w t) = 1`, and for ever if `d` is negative, however little is missing.
#[test]
fn a_force_that_just_reaches_the_limit_breaks_the_block_loose_and_no_smaller_one_does() {
    for frequency in [0.7, 3.0, 8.0, 20.0] {
        for over in [-5e-5, -1e-6, 1e-6, 5e-5_f64] {
            let speed = 0.0025 * (1.0 + over) * frequency;
            let mechanism = SpringMass { pull: Pull::Cosine { speed, frequency }, ..SPRING_MASS };
            let (events, _) = exact(&mechanism, &SPRING_MASS_LEVELS, 1e-8, 5.0);
            match events.first() {
                None => assert!(over < 0.0, "{frequency} rad/s, {over}: it does not break away"),
                Some(first) => {
                    let at_s = first.time_s;
                    assert!(over > 0.0, "{frequency} rad/s, {over}: breaks away at {at_s} s");
                    // At the limit the force is flat: an error of 1e-10 of it is one of this time.
                    let expected_s = (1.0 / (1.0 + over)).asin() / frequency;
                    let flat_s = 1e-9 / ((2.0 * over).sqrt() * frequency);
                    assert!(
                        (at_s - expected_s).abs() < flat_s,
                        "{frequency}, {over}: {at_s} s, not {expected_s}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_pendulum_turns_twice_and_sticks_the_third_time() {
    let (events, finish) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, 5.0);
    assert_events(
        &events,
        &[
            (0.0, 1, Break),
            (1.120988049917, 1, Reverse),
            (2.340084599805, 1, Reverse),
            (3.423533715457, 1, Stick),
        ],
        1e-9,
    );
    assert!((finish.q[0] - 0.611246279747176).abs() < 1e-9 && finish.v[0] == 0.0);
    for (turn_s, angle) in [(1.120988049917, 1.148277007771), (2.340084599805, 0.468892537842)] {
        let (_, turned) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, turn_s);
        assert!((turned.q[0] - angle).abs() < 1e-10, "{turned:?}");
    }
}

#[test]
fn the_arm_sticks_and_slips_as_the_simultaneous_decision_has_it() {
    let (events, finish) = exact(&ARM, &ARM_LEVELS, 1e-10, 5.0);
    assert_events(
        &events,
        &[
            (0.0, 2, Break),
            (0.420702877109, 1, Break),
            (0.726914373526, 2, Stick),
            (1.250820656225, 1, Reverse),
            (1.892725888652, 2, Break),
            (2.526265737564, 2, Stick),
            (2.564718794948, 1, Reverse),
            (3.859631084155, 1, Stick),
        ],
        1e-8,
    );
    let expected = [0.00449854385477193, 0.0252895664467873];
    for (found, expected) in finish.q.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-8, "{finish:?}");
    }
    assert_eq!(finish.v, [0.0; 2]);
}

/// Both torques exceed their T_s, and yet joint 1 sticks: what joint 2 does as it slips holds it
/// back, by T_1 - M_12/M_22 (T_2 - T_d2) = 0.4 - 2 (0.3 - 0.06) N m.
#[test]
fn at_the_start_joint_1_is_held_by_the_motion_of_joint_2() {
    let mut run = Everything::default();
    event_driven::run(&ARM, &ARM_LEVELS, 1e-10, 0.1, &mut run).unwrap();
    let begun = run.samples.iter().rfind(|s| s.time_s == 0.0).unwrap();
    assert_eq!((begun.slip, begun.v, begun.a[0]), ([0, 1], [0.0; 2], 0.0));
    assert!((begun.friction[0] + 0.08).abs() < 1e-15 && begun.friction[1] == 0.06, "{begun:?}");
}
