//! Families that ask one question each: arms, walls, loads that drive.

use super::case::{self, Row};
use super::draw::{Case, Kind};
use super::family::Family;
use super::rules::rules;

const EASY: Kind = Kind { hard: false, rate_hz: 1000.0 };

fn ran(case: &Case, law: &str) -> Row {
    let rule = rules(&[law.into()]).unwrap()[0];
    case::run(case, law, &case.gains(rule), [1, 0]).unwrap()
}

#[test]
fn an_arm_moves_under_two_controllers_and_a_success_is_one_of_both() {
    for number in 0..3 {
        let case = Case::draw(4, Family::Arm, number, EASY);
        let row = ran(&case, "robust");
        assert!(row.is_success(5.0) && row.rest_counts <= 2.0, "{row:?}");
        assert!(row.tracking_rms.is_some_and(|rms| rms > 0.0), "{row:?}");
    }
    // A second joint that nothing moves is no success, however well the first one does.
    let mut case = Case::draw(4, Family::Arm, 0, EASY);
    let curve = &mut case.arm.as_mut().unwrap().arm.friction[1];
    (curve.coulomb, curve.stick) = (100.0, 100.0);
    let row = ran(&case, "pd");
    let way = case.arm.as_ref().unwrap().step.abs() / case.count();
    assert!(row.settled_s.is_none() && (row.rest_counts / way - 1.0).abs() < 0.01, "{row:?}");
}

#[test]
fn joints_of_an_arm_without_coupling_move_as_if_the_other_stood_still() {
    let case = Case::draw(4, Family::ArmUncoupled, 2, EASY);
    let mut still = case.clone();
    still.arm.as_mut().unwrap().step = 0.0;
    // The second joint's angle is in the first one's inertia and gravity: let it weigh nothing.
    for case in [&case, &still] {
        assert!(ran(case, "pd").step_fault.is_none());
    }
    let light = |mut case: Case| {
        let arm = &mut case.arm.as_mut().unwrap().arm;
        (arm.mass[1], arm.friction[1].coulomb) = (1e-9, 1e-3);
        arm.friction[1].stick = 1e-3;
        ran(&case, "pd").rest_counts
    };
    let (moving, resting) = (light(case), light(still));
    assert!((moving - resting).abs() < 1e-3, "{moving} {resting}");
}

#[test]
fn robust_gives_up_before_a_wall_and_then_holds_no_more_than_it_may() {
    for family in [Family::EndStop, Family::EndStopLuGre, Family::EndStopThesis] {
        for number in 0..4 {
            let case = Case::draw(6, family, number, EASY);
            let row = ran(&case, "robust");
            let most = 0.8 * case.told.breakaway[1] * case.scale.effort;
            assert!(row.gave_up_s.is_some_and(|time_s| time_s < 5.0), "{row:?}");
            // The effort of the tick is rounded to a step of the converter.
            let step = case.told.lsb * case.scale.effort;
            assert!(row.effort_after.is_some_and(|effort| effort <= most + step), "{row:?}");
            assert!(row.step_fault.is_none() && row.tracking_rms.is_none(), "{row:?}");
            // PD does not: it has no attempts that could end.
            let row = ran(&case, "pd");
            assert!(row.gave_up_s.is_none() && !row.is_success(2.0), "{row:?}");
        }
    }
}

#[test]
fn no_overhauled_joint_of_any_kind_spins_away_under_robust_without_a_fault() {
    for family in Family::all().filter(|family| family.is_overhauling()) {
        for number in 0..6 {
            let row = ran(&Case::draw(3, family, number, EASY), "robust");
            assert!(row.step_fault.is_some() || row.rest_counts < 1000.0, "{row:?}");
        }
    }
}

#[test]
fn a_joint_of_the_thesis_s_axis_is_near_its_target_before_it_is_on_the_count() {
    let row = ran(&Case::draw(1, Family::ThesisAxis, 0, EASY), "robust");
    let (near_s, settled_s) = (row.near_s.unwrap(), row.settled_s.unwrap());
    // 2.5 deg at 33.75 deg/s^2 take 2 sqrt(2.5/33.75) = 0.54 s; 0.05 deg are left 0.04 s earlier.
    assert!((0.4..settled_s + 1e-9).contains(&near_s), "{row:?}");
    assert_eq!(ran(&Case::draw(1, Family::Rigid, 0, EASY), "pd").near_s, None);
}
