//! The joint of a data sheet in motion, against closed forms and the axis that it maps to.

use super::*;
use crate::data_sheet::SheetAxis;
use dynamics::friction::{AddedFriction, Coulomb};
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, ExactAxis};

const SAMPLE_S: f64 = 1e-3;

/// Returns the joint of a data sheet, and the friction of its axis, V.
fn axis(set: &[(&str, &str)]) -> (SheetAxis, Coulomb) {
    let (sheet, mapping) = sheet(set);
    let friction =
        Coulomb { stick: mapping.volts(sheet.stick()[0]), slip: mapping.volts(sheet.slip()[0]) };
    let count_deg = mapping.count.unwrap().to_degrees();
    (SheetAxis::always(&sheet, &mapping, [count_deg, 20e3]).unwrap(), friction)
}

fn hold(axis: &mut impl AxisSolver, friction: &Coulomb, effort_v: f64, duration_s: f64) {
    for _ in 0..(duration_s / SAMPLE_S).round() as u32 {
        axis.advance(effort_v, SAMPLE_S, friction, &mut |_| {});
    }
}

/// Converts a torque of these joints (N m) to volts: 2 N m/V.
fn volts(torque: f64) -> f64 {
    torque / 2.0
}

#[test]
fn a_plain_joint_moves_like_the_axis_in_closed_form() {
    let (mut joint, friction) = axis(&[]);
    let (_, mapping) = sheet(&[]);
    let robot = RobotAxis {
        gain: mapping.gain(),
        viscous: mapping.viscous_v(),
        friction,
        added: AddedFriction::default(),
    };
    let mut exact = ExactAxis::at_rest(&robot, SAMPLE_S);
    for effort_v in [24.0, 3.0, -20.0, 2.4, 0.0, 2.6, -2.3] {
        hold(&mut joint, &friction, effort_v, 0.1);
        hold(&mut exact, &friction, effort_v, 0.1);
        let apart = joint.position() - exact.position();
        // A thousandth of a count.
        assert!(apart.abs() < 1.8e-6, "{effort_v} V: {apart} deg");
        assert_eq!(joint.stuck(), exact.stuck(), "{effort_v} V");
    }
}

#[test]
fn a_brake_holds_it_as_it_holds_the_axis() {
    let (mut joint, friction) = axis(&[]);
    // 5 N m of its own and 1 N m of a hand.
    let braked = friction.raised(volts(1.0));
    hold(&mut joint, &braked, volts(5.9), 0.05);
    assert!(joint.stuck() && joint.position() == 0.0);
    hold(&mut joint, &braked, volts(6.1), 0.05);
    assert!(!joint.stuck());
}

#[test]
fn a_friction_that_differs_breaks_away_at_its_level_either_way() {
    let set = [("friction.stick_reverse_nm", "7.0"), ("friction.slip_reverse_nm", "6.0")];
    for (torque, is_stuck) in [(4.9, true), (5.1, false), (-6.9, true), (-7.1, false)] {
        let (mut joint, friction) = axis(&set);
        hold(&mut joint, &friction, volts(torque), 0.01);
        assert_eq!(joint.stuck(), is_stuck, "{torque} N m");
    }
}

#[test]
fn a_constant_load_pushes_its_way() {
    for (torque, is_stuck) in [(2.9, true), (3.1, false), (-6.9, true), (-7.1, false)] {
        let (mut joint, friction) = axis(&[("load.constant_nm", "2.0")]);
        hold(&mut joint, &friction, volts(torque), 0.01);
        assert_eq!(joint.stuck(), is_stuck, "{torque} N m");
    }
}

/// A strongly damped joint falls until the torque of its load is the slip friction.
#[test]
fn an_unbalanced_load_falls_to_where_it_hangs_but_for_its_friction() {
    let (mut joint, friction) =
        axis(&[("load.unbalance_nm", "40.0"), ("load.hangs_at_deg", "30.0")]);
    hold(&mut joint, &friction, 0.0, 10.0);
    let expected = 30.0 - (4.0_f64 / 40.0).asin().to_degrees();
    assert!((joint.position() - expected).abs() < 1e-3, "{} deg", joint.position());
}

/// In steady motion, a lag in front of a linear joint delays its position by its time constant.
#[test]
fn an_inductance_delays_the_joint_by_its_time_constant() {
    let free = [("friction.stick_nm", "0"), ("friction.slip_nm", "0")];
    let (mut quick, none) = axis(&free);
    let (mut slow, _) = axis(&[free[0], free[1], ("motor.inductance_h", "0.01")]);
    hold(&mut quick, &none, 10.0, 3.0);
    hold(&mut slow, &none, 10.0, 3.0);
    // L/R = 5 ms at the speed that both have.
    let expected = 0.005 * quick.velocity();
    assert!(off(quick.position() - slow.position(), expected) < 1e-4);
}

/// The load sticks, and the motor twists the shaft by torque over stiffness.
#[test]
fn an_elastic_gear_is_seen_by_an_encoder_on_the_motor_alone() {
    let set = |at| {
        [
            ("gear.stiffness_nm_per_rad", "1000.0"),
            ("gear.damping_nm_s_per_rad", "5.0"),
            ("friction.motor_share", "0.0"),
            ("encoder.at", at),
        ]
    };
    let (mut joint, friction) = axis(&set("'motor'"));
    hold(&mut joint, &friction, volts(2.0), 3.0);
    assert_eq!(joint.position(), 0.0);
    assert!(off(joint.measured(), 0.002_f64.to_degrees()) < 1e-3, "{} deg", joint.measured());
    let (mut joint, friction) = axis(&set("'load'"));
    hold(&mut joint, &friction, volts(2.0), 3.0);
    assert_eq!(joint.measured(), 0.0);
}

/// A bristle gives way by effort over stiffness, and comes back.
#[test]
fn a_bristle_bends_before_the_joint_breaks_away() {
    let (mut joint, friction) = axis(&[
        ("friction.bristle_stiffness_nm_per_rad", "5000.0"),
        ("friction.stribeck_rad_per_s", "0.05"),
    ]);
    hold(&mut joint, &friction, volts(1.0), 1.0);
    let bent = joint.position().to_radians();
    // z = T / sigma0 while the bristle is far from its breakaway: 0.2 mrad.
    assert!(off(bent, 2e-4) < 0.3, "{bent} rad");
    hold(&mut joint, &friction, 0.0, 1.0);
    assert!(joint.position().to_radians().abs() < 0.3 * bent);
}

#[test]
fn a_ripple_raises_and_lowers_the_breakaway_with_the_angle() {
    // At position zero the phase alone counts: 5 N m x (1 +- 0.2).
    for (phase, torque, is_stuck) in
        [("90", 5.9, true), ("90", 6.1, false), ("-90", 3.9, true), ("-90", 4.1, false)]
    {
        let set = [
            ("friction.ripple", "0.2"),
            ("friction.ripple_per_turn", "200"),
            ("friction.ripple_phase_deg", phase),
        ];
        let (mut joint, friction) = axis(&set);
        hold(&mut joint, &friction, volts(torque), 0.01);
        assert_eq!(joint.stuck(), is_stuck, "{phase} deg, {torque} N m");
    }
}

#[test]
fn noise_is_a_count_either_way_on_the_readings_alone() {
    let (mut joint, friction) = axis(&[("encoder.noise_counts", "1")]);
    let count_deg = 360.0 / 200_000.0;
    let mut seen = [0; 3];
    for _ in 0..300 {
        joint.advance(0.0, SAMPLE_S, &friction, &mut |_| {});
        assert_eq!(joint.position(), 0.0);
        let counts = joint.measured() / count_deg;
        seen[(counts.round() + 1.0) as usize] += 1;
    }
    assert!(seen.iter().all(|times| *times > 60), "{seen:?}");
}

#[test]
fn each_of_two_encoders_has_its_own_side_and_its_own_noise() {
    let elastic = ("gear.stiffness_nm_per_rad", "100.0");
    let load = ("load_encoder.counts_per_turn", "16384");
    let (mut joint, friction) = axis(&[elastic, load]);
    // 3 N m on the motor, whose friction is 0.7 of 5 N m: 3.5 N m hold it. 4 N m move the motor,
    // and wind the gear up by less than 1.5 N m / 100 N m/rad, which hold the load.
    hold(&mut joint, &friction, volts(3.0), 0.2);
    assert_eq!((joint.measured(), joint.measured_at_motor()), (0.0, 0.0));
    hold(&mut joint, &friction, volts(4.0), 0.2);
    assert_eq!(joint.measured(), 0.0);
    let twist = joint.measured_at_motor().to_radians();
    assert!((1e-3..1.5e-2).contains(&twist), "{twist}");
    let noises = [
        ("load_encoder.noise_counts", 360.0 / 16384.0, 0.0),
        ("encoder.noise_counts", 0.0, 360.0 / 200_000.0),
    ];
    for (key, of_load, of_motor) in noises {
        let (mut joint, friction) = axis(&[elastic, load, (key, "1")]);
        let mut largest = [0.0_f64; 2];
        for _ in 0..30 {
            joint.advance(0.0, SAMPLE_S, &friction, &mut |_| {});
            for (largest, of) in
                largest.iter_mut().zip([joint.measured(), joint.measured_at_motor()])
            {
                *largest = largest.max(of.abs());
            }
        }
        let off = [largest[0] - of_load, largest[1] - of_motor];
        assert!(off.iter().all(|off| off.abs() < 1e-12), "{key}: {largest:?}");
    }
}
