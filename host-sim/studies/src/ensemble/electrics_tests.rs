//! Electrics of drawn joints: the winding against closed forms, and a few joints under `robust`
//! with a current loop. tests/evidence/current.md has more joints.

use dynamics::joint::{AnyJoint, Joint, Train};

use super::assemble::parameters;
use super::bridge::Bridge;
use super::case::run_and_show;
use super::case_result::CaseResult;
use super::condition::Condition;
use super::drawn_case::{Case, DrawOptions};
use super::electrics::{DrivenWinding, Winding};
use super::family::Family;
use super::motions::Motions;
use super::statistics::SortedValues;
use simulator::current_periods::SensedMotor;
use simulator::rules::rules;

fn drawn(family: Family, number: u64, bridge: Bridge, condition: Condition) -> Case {
    Case::draw(77, family, number, DrawOptions { bridge, condition, ..DrawOptions::ORDINARY })
}

fn viscous(case: &Case) -> f64 {
    match case.joint.train {
        Train::Rigid(body) | Train::Flexible { motor: body, .. } => body.friction.curve.viscous,
        Train::LuGre { curve, .. } => curve.viscous,
    }
}

/// Returns a winding with its joint held by a brake.
fn held(case: &Case) -> (Winding, AnyJoint) {
    let rule = rules(&["pd".into()]).unwrap()[0];
    let mut parameters = parameters(&case.bounds, &case.gains(rule)[0]);
    let electrics = case.electrics.unwrap();
    electrics.configure(&mut parameters, case.scale);
    let mut joint = case.joint.build().unwrap();
    joint.set_brake(1e6);
    (Winding::new(electrics, case, &parameters), joint)
}

#[test]
fn the_back_emf_and_the_rest_of_the_viscous_friction_are_that_of_the_ideal_joint() {
    for family in [Family::Rigid, Family::LuGre, Family::FlexibleMotor, Family::ThesisAxis] {
        let ideal = drawn(family, 3, Bridge::Ideal, Condition::Nominal);
        assert!(ideal.electrics.is_none());
        for (bridge, known) in [(Bridge::Voltage, false), (Bridge::Current, true)] {
            let case = drawn(family, 3, bridge, Condition::Nominal);
            let damping = case.electrics.unwrap().damping;
            let sum = viscous(&case) + damping;
            assert!((sum / viscous(&ideal) - 1.0).abs() < 1e-12 && damping > 0.0, "{family:?}");
            let less = (ideal.bounds.viscous - case.bounds.viscous) * case.scale.effort;
            let expected = if known { damping * case.scale.angle } else { 0.0 };
            assert!((less - expected).abs() < 1e-12, "{family:?}, {bridge:?}: {less}");
        }
    }
}

/// A held joint has no back-EMF: T = s u / r (1 - exp(-t r / tau)).
#[test]
fn a_held_winding_has_the_current_of_its_voltage_supply_and_resistance() {
    for (condition, tau_s) in [(Condition::SlowWinding5, 5e-3), (Condition::SlowWinding1, 1e-3)] {
        let case = drawn(Family::Rigid, 4, Bridge::Voltage, condition);
        for ratios in [[1.0, 1.0], [0.8, 1.4], [1.2, 0.7]] {
            let (mut winding, mut joint) = held(&case);
            let mut motor = DrivenWinding { winding: &mut winding, joint: &mut joint, ratios };
            let code = 500;
            let volts = f64::from(code) * case.bounds.sampled.lsb;
            for k in 1..=20 {
                let current_a = motor.hold(code, true, 0.5e-3);
                let time_s = f64::from(k) * 0.5e-3;
                let [supply, ohm] = ratios;
                let settles = 1.0 - (-time_s * ohm / tau_s).exp();
                let expected = supply * volts / ohm * settles;
                assert!((current_a / expected - 1.0).abs() < 1e-9, "{condition:?}, {ratios:?}");
            }
            assert_eq!(motor.hold(code, false, 1e-3), 0.0);
        }
    }
}

fn ran(family: Family, joints: u64, bridge: Bridge, condition: Condition) -> Vec<CaseResult> {
    let rule = rules(&["robust".into()]).unwrap()[0];
    let run = |number| {
        let case = drawn(family, number, bridge, condition);
        run_and_show(&case, "robust", &case.gains(rule), Motions::default(), |_, _, _| {}).unwrap()
    };
    (0..joints).map(run).collect()
}

fn tracking(rows: &[CaseResult]) -> f64 {
    let rms = rows.iter().map(|row| row.tracking_rms.unwrap_or(f64::INFINITY));
    SortedValues::new(rms).quantile(0.5).unwrap()
}

/// Of 200 joints, the medians with a hot winding and a low supply are 1.0 and 5 times the nominal
/// one.
#[test]
fn a_current_loop_keeps_success_and_tracking_of_a_hot_winding_on_a_low_supply() {
    let family = Family::Rigid;
    let of = |bridge, condition| ran(family, 12, bridge, condition);
    let nominal = tracking(&of(Bridge::Current, Condition::Nominal));
    let rows = of(Bridge::Current, Condition::HotLow);
    assert!(rows.iter().all(|row| row.success_at_encoder && row.step_fault.is_none()));
    assert!(tracking(&rows) < 1.1 * nominal, "{} {nominal}", tracking(&rows));
    let without = tracking(&of(Bridge::Voltage, Condition::HotLow));
    assert!(without > 1.5 * nominal, "{without} {nominal}");
}

/// Pulses that a winding of 5 ms does not follow are no missing current.
#[test]
fn a_slow_winding_in_a_current_loop_trips_no_monitor() {
    for family in [Family::FlexibleMotor, Family::LuGre] {
        let rows = ran(family, 12, Bridge::Current, Condition::SlowWinding5);
        let trips = rows.iter().filter_map(|row| row.step_fault.as_ref());
        assert_eq!(trips.collect::<Vec<_>>(), Vec::<&String>::new(), "{family:?}");
    }
}
