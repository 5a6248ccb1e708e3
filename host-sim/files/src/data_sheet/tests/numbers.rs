//! Compares the mapped numbers with closed forms of a motor with a gear.

use super::*;

#[test]
fn full_scale_gives_the_stall_torque_of_the_motor() {
    let (_, mapping) = sheet(&[]);
    // 24 V / 2 ohm = 12 A; x 0.05 N m/A x 100 x 0.8 = 48 N m.
    assert!(off(mapping.stall(), 48.0) < 1e-12);
    // Half of that current, by a duty of one half.
    let (_, limited) = sheet(&[("motor.current_limit_a", "6")]);
    assert!(off(limited.duty_max, 0.5) < 1e-12 && off(limited.stall(), 24.0) < 1e-12);
}

/// Without friction, the final speed of the core's joint is u / b, deg/s.
#[test]
fn without_friction_full_scale_ends_at_the_speed_without_load() {
    let (_, mapping) = sheet(&[("friction.viscous_nm_s_per_rad", "0")]);
    let found = mapping.full_scale_v / mapping.viscous_v();
    // 24 V / 0.05 V s/rad = 480 rad/s; / 100 = 4.8 rad/s.
    assert!(off(found, 4.8_f64.to_degrees()) < 1e-12, "{found} deg/s");
}

/// With friction, the motor's torque equals the friction at the final speed.
#[test]
fn with_friction_it_ends_where_the_torques_are_equal() {
    let (_, mapping) = sheet(&[]);
    let found = (mapping.full_scale_v - mapping.volts(4.0)) / mapping.viscous_v();
    let speed = found.to_radians();
    let current = (24.0 - 0.05 * 100.0 * speed) / 2.0;
    assert!(off(100.0 * 0.8 * 0.05 * current, 4.0 + 3.0 * speed) < 1e-12, "{found} deg/s");
}

/// The time constant has the same unit in both systems.
#[test]
fn the_time_constant_is_that_of_the_inertia_and_all_that_damps() {
    let (_, mapping) = sheet(&[]);
    let found = 1.0 / (mapping.gain() * mapping.viscous_v());
    // J = 0.2 + 0.8 x 100^2 x 1e-4 = 1 kg m^2; B = 3 + 0.8 x 5^2 / 2 = 13 N m s/rad.
    assert!(off(found, 1.0 / 13.0) < 1e-12, "{found} s");
}

#[test]
fn counts_are_those_of_the_disc_where_it_sits() {
    let turn = |at| std::f64::consts::TAU / sheet(&[("encoder.at", at)]).1.count.unwrap();
    assert!(off(turn("'motor'"), 200_000.0) < 1e-12 && off(turn("'load'"), 2000.0) < 1e-12);
}

#[test]
fn degrees_and_radians_say_the_same() {
    let radians = sheet(&[
        ("friction.viscous_nm_s_per_rad", "3.0"),
        ("friction.stribeck_rad_per_s", "0.1"),
        ("friction.bristle_stiffness_nm_per_rad", "2000.0"),
        ("friction.bristle_damping_nm_s_per_rad", "20.0"),
        ("gear.stiffness_nm_per_rad", "9000.0"),
        ("gear.damping_nm_s_per_rad", "9.0"),
        ("gear.backlash_rad", "0.001"),
        ("load.hangs_at_rad", "0.5"),
        ("motor.no_load_rad_per_s", "480.0"),
    ]);
    let in_degrees = |per_rad: f64| format!("{:e}", per_rad.to_radians());
    let to_degrees = |radians: f64| format!("{:e}", radians.to_degrees());
    let mut table: Table = BRIDGE.parse().unwrap();
    table["friction"].as_table_mut().unwrap().remove("viscous_nm_s_per_rad");
    for (of, key, value) in [
        ("friction", "viscous_nm_s_per_deg", in_degrees(3.0)),
        ("friction", "stribeck_deg_per_s", to_degrees(0.1)),
        ("friction", "bristle_stiffness_nm_per_deg", in_degrees(2000.0)),
        ("friction", "bristle_damping_nm_s_per_deg", in_degrees(20.0)),
        ("gear", "stiffness_nm_per_deg", in_degrees(9000.0)),
        ("gear", "damping_nm_s_per_deg", in_degrees(9.0)),
        ("gear", "backlash_deg", to_degrees(0.001)),
        ("load", "hangs_at_deg", to_degrees(0.5)),
        ("motor", "no_load_rpm", format!("{:e}", 480.0 * 30.0 / std::f64::consts::PI)),
    ] {
        let value = value.parse::<f64>().unwrap();
        table[of].as_table_mut().unwrap().insert(key.into(), value.into());
    }
    let degrees = table.try_into::<SheetTables>().unwrap().sheet().unwrap().unwrap();
    let all = |sheet: &DataSheet| {
        [
            Some(sheet.viscous()),
            sheet.stribeck(),
            sheet.bristle_stiffness(),
            sheet.bristle_damping(),
            sheet.stiffness(),
            sheet.damping(),
            sheet.backlash(),
            sheet.hangs_at(),
            sheet.no_load(),
        ]
    };
    for (one, other) in all(&radians.0).into_iter().zip(all(&degrees)) {
        assert!(off(one.unwrap(), other.unwrap()) < 1e-12, "{one:?}, {other:?}");
    }
}

/// An amplifier has no back-EMF, and its volts are amperes.
#[test]
fn a_motor_that_is_driven_by_a_current_has_the_friction_of_its_joint_alone() {
    let (_, mapping) = sheet(&[
        ("motor.driven_by", "'current'"),
        ("motor.amplifier_a_per_v", "3.0"),
        ("motor.current_limit_a", "15.0"),
    ]);
    assert!(off(mapping.units.effort_gain, 100.0 * 0.8 * 0.05 * 3.0) < 1e-12);
    assert_eq!((mapping.viscous, mapping.back_emf, mapping.duty_max), (3.0, 0.0, 1.0));
    assert!(off(mapping.full_scale_v, 5.0) < 1e-12);
}

/// The joint has 24 V, 2 ohm, and 100 times 0.05 V s of back-EMF.
#[test]
fn a_motor_bears_its_rated_current_or_a_tenth_of_the_stall_current_forever() {
    let current = ("motor.driven_by", "'current'");
    let amplifier = ("motor.amplifier_a_per_v", "3.0");
    let limit = ("motor.current_limit_a", "9.0");
    let rated = ("motor.rated_current_a", "1.5");
    for (set, expected) in [
        (&[][..], (2.4, 5.0)),
        (&[rated], (3.0, 5.0)),
        (&[current, amplifier, limit, rated], (0.5, 0.0)),
        (&[current, amplifier, limit], (0.4, 0.0)),
    ] {
        let found = sheet(set).0.motor_heat().unwrap();
        let (volts, back_emf) = expected;
        assert!(off(found.continuous_v, volts) < 1e-12 && found.back_emf == back_emf, "{found:?}");
    }
    let mut unknown = sheet(&[current, amplifier, limit]).0;
    unknown.motor.resistance_ohm = None;
    assert_eq!(unknown.motor_heat(), None);
    // A load of 10 N m less 5 N m of friction takes 2.5 V of 2 N m/V, and one of 9.7 N m 2.35 V.
    assert!(doubts(&[("load.unbalance_nm", "10")]).contains("takes 2.5 V to hold, but the motor"));
    assert!(!doubts(&[("load.unbalance_nm", "9.7")]).contains("to hold"));
    assert!(!doubts(&[("load.unbalance_nm", "10"), rated]).contains("to hold"));
}

fn doubts(set: &[(&str, &str)]) -> String {
    let (sheet, mapping) = sheet(set);
    sheet.doubts(&mapping).join("\n")
}

#[test]
fn a_plausible_sheet_has_no_doubts_and_an_implausible_one_is_reported() {
    // 24 V / 0.05 V s/rad are 4584 1/min; a fifth less or more is what sheets differ by.
    for rpm in ["4584", "3800", "5400"] {
        assert_eq!(doubts(&[("motor.no_load_rpm", rpm)]), "", "{rpm}");
    }
    for (set, expected) in [
        (("motor.no_load_rpm", "3000"), "`motor.no_load_rpm` is 3000, but"),
        (("motor.no_load_rpm", "45840"), "off by a factor of 10"),
        (("motor.no_load_rad_per_s", "600"), "give 480 rad/s"),
        // 0.8 kg m^2 of the rotor, so that a thousand times as much is 800.
        (("load.inertia_kg_m2", "900"), "1125 times more than the rotor's"),
        (("load.inertia_kg_m2", "7e-4"), "1143 times less than the rotor's"),
        (("friction.stick_nm", "30"), "stall torque is 48 N m"),
        (("friction.stick_nm", "17"), "`friction.stick_nm` is 17 and `slip_nm` 4;"),
        (("load.constant_nm", "-6"), "moves when the motor is off"),
        (("load.unbalance_nm", "45"), "in one direction, the joint cannot start"),
        (("supply.voltage_v", "12000"), "12000 V: are these mV? The key is in V"),
        (("gear.ratio", "1e6"), "Is this number right? The key has no unit"),
        (("motor.inductance_h", "20"), "`motor.inductance_h` is 20 H; usual is 1e-9 to 10 H"),
    ] {
        let found = doubts(&[set]);
        assert!(found.contains(expected), "{set:?}: {found}");
    }
    // Makers of gears write minutes of arc.
    let stiff = ("gear.stiffness_nm_per_rad", "1e4");
    let minutes = doubts(&[("gear.backlash_deg", "15"), stiff]);
    assert!(minutes.contains("15 deg: are these arcmin? The key is in deg"), "{minutes}");
    assert_eq!(doubts(&[("gear.backlash_deg", "0.6"), stiff]), "");
    for fine in [("load.inertia_kg_m2", "700"), ("load.inertia_kg_m2", "9e-4")] {
        assert_eq!(doubts(&[fine]), "");
    }
    for fine in [("friction.stick_nm", "15.9"), ("load.constant_nm", "-4.9")] {
        assert_eq!(doubts(&[fine]), "");
    }
}

#[test]
fn what_cannot_move_either_way_is_refused_and_what_moves_one_way_is_not() {
    let can_move = |set: &[(&str, &str)]| {
        let (sheet, mapping) = sheet(set);
        sheet.can_move(&mapping).map_err(|why| why.to_string())
    };
    let why = can_move(&[("friction.stick_nm", "49")]).unwrap_err();
    assert!(why.starts_with("`friction.stick_nm` is 49; must be a number below 48,"), "{why}");
    assert_eq!(can_move(&[("friction.stick_nm", "47")]), Ok(()));
    // The key that is far from any real joint is blamed, and not the friction.
    let why = can_move(&[("supply.voltage_v", "1e-3")]).unwrap_err();
    assert!(
        why.starts_with("`supply.voltage_v` is 0.001 V; usual is 1 to 1000 V: the joint cannot")
            && why.contains("(`friction.stick_nm`) is 5 N m"),
        "{why}"
    );
    // An odd key that is not in the stall torque is not blamed for it.
    let why = can_move(&[("motor.inductance_h", "20"), ("friction.stick_nm", "49")]).unwrap_err();
    assert!(why.starts_with("`friction.stick_nm` is 49;"), "{why}");
    // A load helps one way.
    assert_eq!(can_move(&[("friction.stick_nm", "49"), ("load.constant_nm", "2")]), Ok(()));
    assert_eq!(can_move(&[("friction.stick_nm", "49"), ("load.constant_nm", "-2")]), Ok(()));
}
