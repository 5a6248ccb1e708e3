//! The law around a rigid joint that differs from its configured one: it ends on the count, also
//! far away, holds a configured load, and gives up at an end stop.

use stiction::control::laws::RobustGains;
use stiction::control::laws::robust::Mode;

use super::joint::*;

/// Frictions (static, dynamic) over the configured range, V.
const FRICTIONS: [(f64, f64); 4] = [(2.1, 2.0), (4.0, 2.5), (8.0, 6.0), (11.5, 6.0)];

#[test]
fn joint_rests_within_two_counts_whatever_its_friction() {
    for (stick, slip) in FRICTIONS {
        let mut run = ClosedLoop::new(Joint::new(stick, slip), &configured());
        for target in [5.0, 4.97, -20.003, -20.0] {
            run.run(target, 3.0, |_| {});
            assert!(run.off(target).abs() <= 2.0, "{stick} V: {} off {target}", run.off(target));
            assert_eq!(run.state.mode(), Mode::Hold, "{stick} V, {target}");
        }
    }
}

/// A thousand turns are 10^8 counts, of which an `f32` has every eighth.
#[test]
fn last_count_is_kept_after_a_thousand_turns() {
    let fast = RobustGains { speed: 1500.0, ..configured() };
    let mut run = ClosedLoop::new(Joint::new(4.0, 2.5), &fast);
    for target in [360_000.0, 360_000.02, 359_999.0, 0.0] {
        run.run(target, if target == 359_999.0 { 3.0 } else { 260.0 }, |_| {});
        assert!(run.off(target).abs() <= 2.0, "{} off {target}", run.off(target));
        assert_eq!(run.state.mode(), Mode::Hold, "{target}");
    }
}

/// The load is 2.5 times the static friction: it drives the joint as soon as no effort holds it.
fn overhauled(gains: &RobustGains, load: f64, target: f64) -> (ClosedLoop, f64) {
    let joint = Joint { load, ..Joint::new(4.0, 3.0) };
    let mut run = ClosedLoop::new(joint, gains);
    let mut beyond = 0f64;
    run.run(target, 4.0, |run| {
        let position = run.joint.position;
        beyond = beyond.max(position - target).max(-position);
    });
    (run, beyond)
}

#[test]
fn a_load_that_drives_is_held_if_it_is_configured_and_runs_away_if_not() {
    for load in [10.0, -10.0] {
        let (run, beyond) = overhauled(&RobustGains { load: 36.0, ..configured() }, load, 5.0);
        assert!(run.off(5.0).abs() <= 2.0, "{load}: {} counts off", run.off(5.0));
        assert_eq!(run.state.mode(), Mode::Hold, "{load}");
        // It holds what friction does not: between 10 - 4 and 10 + 4 V.
        let held = -run.applied * load.signum() as f32;
        assert!((6.0..=14.0).contains(&held), "{load}: holds {held} V");
        assert!(beyond < 1500.0 * 0.0036, "{load}: {beyond} deg beyond");
        let (lost, _) = overhauled(&configured(), load, 5.0);
        assert_ne!(lost.state.mode(), Mode::Hold, "without the rule");
    }
}

/// The load grows by 8 V while the joint is held, and then it slides: the hold effort of 10 V and
/// the dynamic friction of 3 V do not hold 18 V.
#[test]
fn a_load_that_grows_until_the_joint_slides_is_held_again_without_a_long_way() {
    for load in [10.0, -10.0] {
        let (mut run, _) = overhauled(&RobustGains { load: 36.0, ..configured() }, load, 5.0);
        assert_eq!(run.state.mode(), Mode::Hold, "{load}");
        run.joint.load *= 1.8;
        let (mut furthest, mut least) = (0f64, f32::INFINITY);
        run.run(5.0, 3.0, |run| {
            furthest = furthest.max(run.off(5.0).abs());
            least = least.min(-run.state.hold_effort() * load.signum() as f32);
        });
        assert!(run.off(5.0).abs() <= 2.0, "{load}: {} counts off", run.off(5.0));
        let held = -run.applied * load.signum() as f32;
        assert!((14.0..=22.0).contains(&held), "{load}: holds {held} V");
        // It was lost, at 64 counts, and it never let go of half of what it held.
        assert!(furthest > 64.0 && least > 5.0, "{load}: {furthest} counts, {least} V");
    }
}

#[test]
fn a_configured_hold_effort_leaves_no_drop_at_enabling() {
    let gains = RobustGains { load: 36.0, ..configured() };
    let (_, without) = overhauled(&gains, -10.0, 0.0);
    let (run, with) = overhauled(&RobustGains { hold_effort: 9.0, ..gains }, -10.0, 0.0);
    assert!(run.off(0.0).abs() <= 2.0, "{} counts", run.off(0.0));
    // The friction holds the volt that is missing: it does not drop by a count.
    assert!(with < 0.0036 && without > 3.0 * 0.0036, "{with} and {without} deg");
}

#[test]
fn it_gives_up_at_an_end_stop_and_tries_again_at_the_next_motion() {
    for (stick, slip) in FRICTIONS {
        let wall = 5.0 - 5.0 * 0.0036;
        let mut run = ClosedLoop::new(Joint { wall, ..Joint::new(stick, slip) }, &configured());
        let (mut tick, mut gave_up) = (0, None);
        run.run(5.0, 2.5, |run| {
            tick += 1;
            if run.state.mode() == Mode::GiveUp && gave_up.is_none() {
                gave_up = Some((tick, run.applied));
            }
        });
        assert!(gave_up.is_some_and(|(tick, _)| tick <= 2000), "{stick} V: {gave_up:?}");
        assert_eq!(run.signal("robust_mode"), 5.0, "{stick} V");
        let (mut least, mut most) = (f32::MAX, f32::MIN);
        run.run(5.0, 1.0, |run| {
            (least, most) = (least.min(run.applied), most.max(run.applied));
        });
        assert!(least == most && most.abs() <= 0.8 * 12.0, "{stick} V: {least} to {most} V");
        run.run(3.0, 3.0, |_| {});
        assert!(run.off(3.0).abs() <= 2.0 && run.state.mode() == Mode::Hold, "{stick} V");
    }
}

#[test]
fn without_a_number_of_attempts_it_pulses_against_the_stop_for_ever() {
    let wall = 5.0 - 5.0 * 0.0036;
    let gains = RobustGains { attempts: 0, ..configured() };
    let mut run = ClosedLoop::new(Joint { wall, ..Joint::new(4.0, 2.5) }, &gains);
    run.run(5.0, 20.0, |_| {});
    let mut strongest = 0f32;
    run.run(5.0, 1.0, |run| strongest = strongest.max(run.applied.abs()));
    assert!(strongest > 12.0, "{strongest} V");
    assert!(run.signal("robust_attempts") > 50.0);
}

/// A reference that jumps in the middle of everything, and noise of a count: the effort stays
/// within the full scale, and the gain within its bounds.
#[test]
fn effort_and_gain_stay_within_their_bounds() {
    let mut run = ClosedLoop::new(Joint::new(8.0, 3.0), &configured());
    for k in 0..200 {
        let target = f64::from(k * 7919 % 1000) * 0.01 - 5.0;
        run.run(target, 0.037, |run| {
            assert!(run.applied.abs() <= 60.0);
            assert!((0.1..=1.0).contains(&run.state.gain()));
            assert!(run.state.hold_effort().abs() <= 0.8 * 12.0);
        });
    }
}
