//! Derived numbers of a data sheet in both systems of units, each with its formula.

use std::f64::consts::TAU;

use super::sheet::DataSheet;
use super::tables::{DrivenBy, EncoderPlace};
use super::units::Mapping;
use crate::error::shown;

/// Number that is derived from a data sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedNumber {
    /// Name of the quantity.
    pub what: &'static str,
    /// Value in SI, with its unit; empty if it has none.
    pub si: String,
    /// Value in the core's units; empty if the core has none.
    pub core: String,
    /// Formula.
    pub how: String,
}

/// Formats a number with five digits, which is more than a data sheet has.
fn digits(number: f64) -> String {
    shown(format!("{number:.4e}").parse().unwrap_or(number))
}

fn with(number: f64, unit: &str) -> String {
    format!("{} {unit}", digits(number))
}

/// Lists all numbers that are derived from a data sheet.
pub fn rows(sheet: &DataSheet, mapping: &Mapping) -> Vec<DerivedNumber> {
    let mut rows = vec![effort(sheet, mapping)];
    rows.extend(body(sheet, mapping));
    rows.extend(friction(sheet, mapping));
    rows.extend(shape(sheet, mapping));
    rows.extend(limits(sheet, mapping));
    rows.extend(encoder(sheet, mapping));
    rows.extend(load_encoder(sheet));
    rows
}

fn effort(sheet: &DataSheet, mapping: &Mapping) -> DerivedNumber {
    let (motor, gear) = (&sheet.motor, &sheet.gear);
    let torque = format!(
        "{} x {} x {}",
        digits(gear.ratio),
        digits(gear.efficiency),
        digits(motor.kt_nm_per_a)
    );
    let how = match motor.driven_by {
        DrivenBy::Voltage => {
            let resistance = motor.resistance_ohm.map(digits).unwrap_or_default();
            format!("G = n eta K_t / R = {torque} / {resistance}")
        }
        DrivenBy::Current => {
            let amplifier = motor.amplifier_a_per_v.map(digits).unwrap_or_default();
            format!("G = n eta K_t A = {torque} x {amplifier}")
        }
    };
    DerivedNumber {
        what: "effort per volt",
        si: with(mapping.units.effort_gain, "N m"),
        core: "1 V".into(),
        how,
    }
}

fn body(sheet: &DataSheet, mapping: &Mapping) -> Vec<DerivedNumber> {
    let (motor, gear, load) = (&sheet.motor, &sheet.gear, &sheet.load);
    let mut rows = vec![DerivedNumber {
        what: "inertia",
        si: with(mapping.inertia, "kg m^2"),
        core: with(mapping.units.per_degree(mapping.inertia), "V s^2/deg"),
        how: format!(
            "J = J_l + eta n^2 J_r = {} + {} x {}^2 x {}",
            digits(load.inertia_kg_m2),
            digits(gear.efficiency),
            digits(gear.ratio),
            digits(motor.rotor_inertia_kg_m2)
        ),
    }];
    rows.push(DerivedNumber {
        what: "acceleration per volt",
        si: with(mapping.units.effort_gain / mapping.inertia, "rad/s^2"),
        core: with(mapping.gain(), "deg/s^2"),
        how: "kappa = (180/pi) G / J".into(),
    });
    let viscous_core = |viscous: f64| with(mapping.units.per_degree(viscous), "V s/deg");
    if mapping.back_emf > 0.0 {
        rows.push(DerivedNumber {
            what: "back-EMF",
            si: with(mapping.back_emf, "N m s/rad"),
            core: viscous_core(mapping.back_emf),
            how: "eta (n K_t)^2 / R: a viscous friction for the core".into(),
        });
    }
    rows.push(DerivedNumber {
        what: "total viscous friction",
        si: with(mapping.viscous, "N m s/rad"),
        core: viscous_core(mapping.viscous),
        how: if mapping.back_emf > 0.0 {
            format!("B = {} + back-EMF; b = (pi/180) B / G", digits(sheet.viscous()))
        } else {
            "b = (pi/180) B / G".into()
        },
    });
    rows
}

fn friction(sheet: &DataSheet, mapping: &Mapping) -> Vec<DerivedNumber> {
    let level = |what, torque: f64, how: &str| DerivedNumber {
        what,
        si: with(torque, "N m"),
        core: with(mapping.volts(torque), "V"),
        how: how.into(),
    };
    let [stick, stick_back] = sheet.stick();
    let [slip, slip_back] = sheet.slip();
    let mut rows =
        vec![level("stick friction", stick, "F_s / G"), level("slip friction", slip, "F_c / G")];
    if [stick_back, slip_back] != [stick, slip] {
        rows.push(level("stick friction, negative way", stick_back, "F_s / G"));
        rows.push(level("slip friction, negative way", slip_back, "F_c / G"));
    }
    let loads = [("constant load", sheet.load.constant_nm), ("unbalance", sheet.load.unbalance_nm)];
    for (what, torque) in loads.into_iter().filter(|(_, torque)| *torque != 0.0) {
        rows.push(level(what, torque, "T / G"));
    }
    rows
}

/// Lists effects that an axis in closed form does not have.
fn shape(sheet: &DataSheet, mapping: &Mapping) -> Vec<DerivedNumber> {
    let angle = |what, radians: Option<f64>, per: &str| {
        radians.filter(|radians| *radians != 0.0).map(|radians| DerivedNumber {
            what,
            si: with(radians, &format!("rad{per}")),
            core: with(radians.to_degrees(), &format!("deg{per}")),
            how: "180/pi".into(),
        })
    };
    let spring = |what, stiffness: Option<f64>| {
        stiffness.map(|stiffness| DerivedNumber {
            what,
            si: with(stiffness, "N m/rad"),
            core: with(mapping.units.per_degree(stiffness), "V/deg"),
            how: "(pi/180) k / G".into(),
        })
    };
    [
        angle("Stribeck velocity", sheet.stribeck(), "/s"),
        spring("bristle's stiffness", sheet.bristle_stiffness()),
        spring("gear's stiffness", sheet.stiffness()),
        angle("backlash", sheet.backlash(), ""),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn limits(sheet: &DataSheet, mapping: &Mapping) -> Vec<DerivedNumber> {
    let how = match (sheet.motor.driven_by, &sheet.supply) {
        (DrivenBy::Voltage, Some(_)) => "full duty is the supply's voltage",
        _ => "the current limit, or `drive.full_scale_v`",
    };
    let mut rows = vec![DerivedNumber {
        what: "full scale",
        si: with(mapping.units.effort(mapping.full_scale_v), "N m"),
        core: with(mapping.full_scale_v, "V"),
        how: how.into(),
    }];
    if mapping.duty_max < 1.0 {
        let limit = sheet
            .motor
            .current_limit_a
            .map_or("what is written".into(), |limit| format!("{} A at standstill", digits(limit)));
        rows.push(DerivedNumber {
            what: "largest duty",
            si: with(mapping.stall(), "N m"),
            core: digits(mapping.duty_max),
            how: limit,
        });
    }
    // Without a supply the voltage limit of an amplifier is unknown.
    if let Some(supply) = &sheet.supply {
        let speed = supply.voltage_v / (sheet.gear.ratio * sheet.motor.kt_nm_per_a);
        rows.push(DerivedNumber {
            what: "speed without load",
            si: with(speed, "rad/s"),
            core: with(speed.to_degrees(), "deg/s"),
            how: "V / (n K_t), at the joint and without friction".into(),
        });
    }
    if let (DrivenBy::Voltage, Some(resistance)) =
        (sheet.motor.driven_by, sheet.motor.resistance_ohm)
    {
        rows.push(DerivedNumber {
            what: "time constants",
            si: with(mapping.inertia / mapping.viscous, "s"),
            core: with(sheet.motor.inductance_h / resistance, "s"),
            how: "mechanical J / B, and electrical L / R".into(),
        });
    }
    rows
}

fn load_encoder(sheet: &DataSheet) -> Option<DerivedNumber> {
    let load = sheet.load_encoder?;
    let count_deg = load.count_deg();
    Some(DerivedNumber {
        what: "load encoder's count",
        si: with(count_deg.to_radians(), "rad"),
        core: with(count_deg, "deg"),
        how: format!("360 / {0}; {0} counts a turn of the joint", load.counts_per_turn),
    })
}

fn encoder(sheet: &DataSheet, mapping: &Mapping) -> Option<DerivedNumber> {
    let (count, lines) = (mapping.count?, sheet.encoder.lines?);
    let how = match sheet.encoder.at {
        Some(EncoderPlace::Motor) => format!("360 / (4 x {lines} x {})", digits(sheet.gear.ratio)),
        _ => format!("360 / (4 x {lines})"),
    };
    Some(DerivedNumber {
        what: "encoder's count",
        si: with(count, "rad"),
        core: with(count.to_degrees(), "deg"),
        how: format!("{how}; {} counts a turn", digits(TAU / count)),
    })
}
