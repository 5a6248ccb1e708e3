//! Conditions: each one has the effect of its line in the table, and no other.

use std::f64::consts::TAU;

use super::condition::{Condition, EccentricDisc, JitteringTicks, SHIFT};
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use dynamics::joint::{SetValuedFriction, Train};
use simulator::plant::Delay;

fn drawn(family: Family, condition: Condition) -> Case {
    Case::draw(3, family, 4, DrawOptions { condition, ..DrawOptions::ORDINARY })
}

fn friction(case: &Case) -> SetValuedFriction {
    let Train::Rigid(body) = case.joint.train else { panic!("{case:?}") };
    body.friction
}

#[test]
fn a_condition_is_the_only_difference_to_the_joint_of_its_family() {
    for family in [Family::Rigid, Family::FlexibleMotor, Family::ThesisAxis] {
        let nominal = drawn(family, Condition::Nominal);
        for condition in Condition::ALL {
            let case = drawn(family, condition);
            assert!(case.joint.build().is_ok(), "{condition:?}");
            let is_late = condition == Condition::LateOutput;
            assert_eq!(case.delay == Delay::TwoSamples, is_late, "{condition:?}");
            let (joint, delay) = (nominal.joint, nominal.delay);
            let same = Case { joint, delay, condition: Condition::Nominal, ..case };
            assert_eq!(Case { phase: 0.0, ..same }, Case { phase: 0.0, ..nominal.clone() });
        }
    }
}

/// The levels at the start are exp(-T) times those at the end.
#[test]
fn friction_drifts_from_three_fifths_to_eight_fifths_of_its_levels_or_back() {
    let (mut rising, cases) = (0, 200);
    for number in 0..cases {
        let of = |condition| {
            let options = DrawOptions { condition, ..DrawOptions::ORDINARY };
            friction(&Case::draw(3, Family::Rigid, number, options))
        };
        let (nominal, drifts) = (of(Condition::Nominal), of(Condition::Drift));
        let end = drifts.curve.stick / nominal.curve.stick;
        let start = end * (-drifts.thermal.unwrap().start_k).exp();
        let is_rising = end > 1.0;
        let [from, to] = if is_rising { [0.6, 1.6] } else { [1.6, 0.6] };
        assert!((start - from).abs() < 1e-9 && (end - to).abs() < 1e-9, "{start} {end}");
        rising += u64::from(is_rising);
    }
    // Five standard deviations of a fair coin.
    assert!(rising.abs_diff(cases / 2) < 36, "{rising}");
}

/// A turn is 2 pi rad for one family and 360 deg for the other.
#[test]
fn uneven_friction_has_its_periods_in_a_turn() {
    for (family, turn) in [(Family::Rigid, TAU), (Family::ThesisAxis, 360.0)] {
        for (condition, periods) in [(Condition::Uneven40, 40.0), (Condition::Uneven200, 200.0)] {
            let ripple = friction(&drawn(family, condition)).ripple.unwrap();
            assert!((ripple.cycles * turn / TAU - periods).abs() < 1e-9, "{ripple:?}");
        }
    }
}

#[test]
fn the_supply_sags_for_a_tenth_of_the_time() {
    let low = (0..10_000).filter(|k| Condition::Sag.share(f64::from(*k) * 1e-3) < 0.8).count();
    assert!(low.abs_diff(1000) <= 10, "{low}");
    assert!((Condition::HotWinding.share(0.0) * 1.4 - 1.0).abs() < 1e-12);
}

/// Jitter of a timer does not add up: after any number of ticks it is at most a shift off.
#[test]
fn ticks_that_jitter_stay_near_their_time() {
    let (mut ticks, mut time, mut extremes) = (JitteringTicks::new(7), 0.0, [1.0f64; 2]);
    for k in 1..=1000 {
        let until = ticks.next();
        extremes = [extremes[0].min(until), extremes[1].max(until)];
        time += until;
        assert!((time - f64::from(k)).abs() < SHIFT + 1e-9, "{k}: {time}");
    }
    assert!((extremes[0] - 0.9).abs() < 1e-9 && (extremes[1] - 1.1).abs() < 1e-9);
}

/// 1.33 mrad are 21 counts of 100 000 a turn.
#[test]
fn an_eccentric_disc_is_off_by_the_same_angle_in_every_unit() {
    for family in [Family::Rigid, Family::ThesisAxis] {
        let case = drawn(family, Condition::Eccentric);
        let disc = EccentricDisc::new(case.scale.angle, case.phase);
        let turn = 360.0 * case.scale.angle;
        let worst = (0..1000)
            .map(|k| f64::from(k) * turn / 1000.0)
            .map(|position| (disc.shows(position) - position).abs())
            .fold(0.0, f64::max);
        assert!((worst / turn * 1e5 - 21.2).abs() < 0.1, "{worst}");
    }
}

#[test]
fn a_bristle_and_an_arm_are_refused_where_they_have_no_such_friction() {
    assert!(!Condition::Drift.fits(Family::LuGre) && Condition::Sag.fits(Family::LuGre));
    assert!(!Condition::Sag.fits(Family::Arm) && Condition::Nominal.fits(Family::Arm));
}
