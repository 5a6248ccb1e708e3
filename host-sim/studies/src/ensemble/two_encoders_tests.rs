//! `robust` with an encoder on motor and load, on a few joints of each family. All required values
//! are in tests/evidence/two-encoders.md.

use super::case::run_and_show;
use super::case_result::CaseResult;
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use super::motions::Motions;
use simulator::rules::rules;

/// Runs `robust` on joints of a seed that nothing was tuned on.
fn ran(family: Family, joints: u64, hard: bool) -> Vec<CaseResult> {
    let rule = rules(&["robust".into()]).unwrap()[0];
    let kind = DrawOptions { hard, ..DrawOptions::ORDINARY };
    let run = |number| {
        let case = Case::draw(77, family, number, kind);
        run_and_show(&case, "robust", &case.gains(rule), Motions::default(), |_, _, _| {}).unwrap()
    };
    (0..joints).map(run).collect()
}

fn successes(rows: &[CaseResult]) -> usize {
    rows.iter().filter(|row| row.success_at_load).count()
}

fn faults(rows: &[CaseResult]) -> Vec<&str> {
    let of = |row: &'_ CaseResult| [row.step_fault.is_some(), row.tracking_fault.is_some()];
    rows.iter().filter(|row| of(row) != [false; 2]).map(|row| row.family.as_str()).collect()
}

/// Returns whether the step ended in GIVE_UP.
fn has_given_up(row: &CaseResult) -> bool {
    let mode = row.law_signals.split(' ').next().unwrap();
    mode.strip_prefix("robust_mode=").unwrap() == "5"
}

/// Of 500 joints of each family, 500 and 499 succeed.
#[test]
fn load_rests_at_its_target_behind_a_gear_that_nothing_is_known_of() {
    for family in [Family::TwoEncoders, Family::TwoEncodersBacklash] {
        let rows = ran(family, 40, false);
        assert!(successes(&rows) >= 39, "{family:?}: {} of 40", successes(&rows));
        assert!(faults(&rows).len() <= 1, "{family:?}");
    }
}

/// Of 500 joints each, 488, 495 and 494 succeed. PID in the classical dual loop succeeds on a fifth
/// of the joints, and on 4 % of the hard ones.
#[test]
fn hard_friction_known_noise_and_a_driving_load_cost_few_joints() {
    for (family, hard) in [
        (Family::TwoEncoders, true),
        (Family::TwoEncodersNoisy, false),
        (Family::TwoEncodersOverhauling, false),
    ] {
        let rows = ran(family, 40, hard);
        assert!(successes(&rows) >= 36, "{family:?}: {} of 40", successes(&rows));
        assert!(faults(&rows).len() <= 2, "{family:?}");
    }
}

/// At the end of its step, the law has given up no joint of ordinary friction, but nearly every one
/// before a wall.
#[test]
fn law_gives_up_at_walls_and_nowhere_else() {
    let walls = ran(Family::TwoEncodersEndStop, 30, false);
    let given_up = walls.iter().filter(|row| row.gave_up_s.is_some()).count();
    assert!(given_up >= 26, "{given_up} of 30");
    let free = ran(Family::TwoEncodersBacklash, 40, false);
    assert!(!free.iter().any(has_given_up));
}

/// Joints whose load jumps by hundreds of counts swing about their targets for 30 s if nothing ends
/// it: five of these 200. With 100 attempts, all are at rest before.
#[test]
fn joint_that_swings_about_its_target_is_left_near_it() {
    let rows = ran(Family::TwoEncoders, 200, true);
    let unsettled: Vec<_> = rows.iter().filter(|row| row.settled_at_load_s.is_none()).collect();
    assert!((1..=12).contains(&unsettled.len()), "{}", unsettled.len());
    for row in unsettled {
        assert!(has_given_up(row), "{}: {}", row.case, row.law_signals);
    }
}

/// The ninth decile of the rms error of the load is 8.0 and 8.6 mrad of 500 joints of another seed,
/// and 17.4 and 17.1 mrad with hard friction. Without the integral of the load's lag it was 11.9 to
/// 22.9 mrad.
#[test]
fn load_follows_its_trajectory() {
    for (hard, most_mrad) in [(false, 12.0), (true, 20.0)] {
        for family in [Family::TwoEncoders, Family::TwoEncodersBacklash] {
            let rows = ran(family, 300, hard);
            let mut errors: Vec<f64> = rows
                .iter()
                .map(|row| row.tracking_at_load_rms.unwrap_or(f64::INFINITY) * 1e3)
                .collect();
            errors.sort_by(f64::total_cmp);
            assert!(errors[270] < most_mrad, "{family:?}: {} mrad", errors[270]);
            assert!(errors[150] > 0.5, "{family:?}: {} mrad", errors[150]);
        }
    }
}
