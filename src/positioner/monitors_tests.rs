//! The monitors with a joint that works, and with one that has a failed part.

use core::cell::Cell;

use super::tests::{CONFIG, Joint};
use super::*;
use crate::safety::fault::Fault;

const MONITORS: MonitorConfig =
    MonitorConfig { range: [-1.0, 1.0], continuous_effort: 6.0, thermal_time: 10.0 };

/// Runs towards targets (rad, 2 s each) with an encoder that shows other counts, and returns the
/// first fault with its tick.
fn run(
    targets: &[f32],
    config: &MonitorConfig,
    shows: impl Fn(u32, i32) -> i32,
) -> (Joint, Option<(Fault, u32)>) {
    let positioner = Positioner::new(&CONFIG).unwrap();
    let monitors = RunawayMonitors::new(&CONFIG, config).unwrap();
    let (mut state, mut watch) = (positioner.start(), monitors.start(0));
    let mut joint = Joint::AT_ZERO;
    for (k, target) in targets.iter().flat_map(|target| [*target; 2000]).enumerate() {
        let k = k as u32;
        let counts = shows(k, joint.counts());
        let target = Target::at_rest(positioner.position(target));
        let effort = positioner.tick(&mut state, counts, target);
        if let Some(runaway) = monitors.check(&mut watch, counts, target, effort) {
            return (joint, Some((runaway.fault, k)));
        }
        joint.advance(effort);
    }
    (joint, None)
}

#[test]
fn a_joint_that_works_trips_nothing() {
    let (joint, fault) = run(&[0.5, 0.501, -0.9, -0.2, 0.0], &MONITORS, |_, counts| counts);
    assert_eq!(fault, None);
    assert!(joint.position.abs() < 1e-3);
}

#[test]
fn an_encoder_that_fails_in_motion_turns_the_output_off() {
    // It moves from tick 0 on, and fails 0.1 s later.
    let last = Cell::new(0);
    let dead = run(&[0.9], &MONITORS, |k, counts| {
        if k < 100 {
            last.set(counts);
        }
        last.get()
    });
    let reversed = run(&[0.9], &MONITORS, |_, counts| -counts);
    let jumps = run(&[0.9], &MONITORS, |k, counts| counts + if k < 100 { 0 } else { 20_000 });
    for ((joint, fault), allowed) in [
        (dead, &[Fault::Stall, Fault::FollowingError][..]),
        (reversed, &[Fault::EncoderReversed, Fault::FollowingError]),
        (jumps, &[Fault::EncoderJump]),
    ] {
        let (fault, tick) = fault.unwrap();
        assert!(allowed.contains(&fault) && tick < 1000, "{fault:?} {tick}");
        assert!(joint.position.abs() < 1.5, "{fault:?}: {} rad", joint.position);
    }
}

#[test]
fn a_position_outside_the_range_and_a_motor_that_heats_are_faults() {
    let narrow = MonitorConfig { range: [-0.1, 0.1], ..MONITORS };
    let (joint, fault) = run(&[0.5], &narrow, |_, counts| counts);
    assert!(matches!(fault, Some((Fault::PositionLimit, _))), "{fault:?}");
    assert!((0.1..0.15).contains(&joint.position), "{}", joint.position);

    // An effort of 4 against a limit of 2, too small for a stall: `10 s ln(4^2 / (4^2 - 2^2))` =
    // 2.88 s.
    let config = MonitorConfig { continuous_effort: 2.0, ..MONITORS };
    let monitors = RunawayMonitors::new(&CONFIG, &config).unwrap();
    let mut watch = monitors.start(0);
    let mut counts = 0;
    let hot = (0..4000).find_map(|k| {
        counts += if k / 200 % 2 == 0 { 10 } else { -10 };
        let effort = if k / 200 % 2 == 0 { 4.0 } else { -4.0 };
        let target = Target::at_rest(Position::from_counts(counts));
        let runaway = monitors.check(&mut watch, counts, target, effort)?;
        Some((runaway.fault, k))
    });
    let Some((Fault::Overheat, k)) = hot else { panic!("{hot:?}") };
    assert!((2850..2900).contains(&k), "{k}");
    // The motor is still hot when it is armed again, and cools without output.
    let mut again = monitors.armed(&watch, counts);
    let target = Target::at_rest(Position::from_counts(counts));
    let hot = monitors.check(&mut again, counts, target, 4.0).map(|runaway| runaway.fault);
    assert_eq!(hot, Some(Fault::Overheat));
    (0..10_000).for_each(|_| monitors.idle(&mut again, counts));
    let mut cool = monitors.armed(&again, counts);
    assert_eq!(monitors.check(&mut cool, counts, target, 0.0), None);
}

#[test]
fn what_the_monitors_have_to_know_is_validated() {
    let refused =
        |config: MonitorConfig| RunawayMonitors::new(&CONFIG, &config).err().map(|why| why.field);
    assert_eq!(refused(MONITORS), None);
    assert_eq!(refused(MonitorConfig { range: [1.0, 0.9], ..MONITORS }), Some("range[1]"));
    assert_eq!(
        refused(MonitorConfig { continuous_effort: 16.1, ..MONITORS }),
        Some("continuous_effort")
    );
    assert_eq!(refused(MonitorConfig { thermal_time: 0.0, ..MONITORS }), Some("thermal_time"));
}
