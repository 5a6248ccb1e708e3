//! Maps a data sheet to the core's units: effort gain, inertia, friction, limits. [`CoreUnits`]
//! converts torques and inertias to volts and degrees, given the effort gain.
//! `docs/reference/units.md` describes both.
//!
//! The core's effort u is a voltage at its output. At the joint it moves
//!
//! ```text
//! J q'' = G u - B q' - F - T        q in rad, J in kg m^2, B in N m s/rad, F and T in N m
//! ```
//!
//! The torque that passes the gear is n eta (K_t i - J_r n q''), with the motor's current i, the
//! ratio n and the efficiency eta. A bridge sets the voltage: i = (u - n K_t q') / R once the
//! current has settled. An amplifier sets the current: i = A u. So
//!
//! ```text
//! J = J_l + eta n^2 J_r
//! voltage:  G = n eta K_t / R      B = B_f + eta (n K_t)^2 / R
//! current:  G = n eta K_t A        B = B_f
//! ```
//!
//! The back-EMF acts as a viscous friction. Divided by G, and with angles in degrees,
//!
//! ```text
//! q'' = kappa (u - b q' - F_v)      kappa = (180/pi) G / J,  b = (pi/180) B / G,  F_v = F / G
//! ```
//!
//! Guarantees: [`Mapping::of`] is exact except for rounding. Its numbers give the stall torque
//! G u_max and, without friction, the motor's speed without load V / K_t. Limits: eta is that of a
//! driving motor, also while the load drives the motor.

use std::f64::consts::TAU;

use super::sheet::DataSheet;
use super::tables::{DrivenBy, EncoderPlace};
use dynamics::joint::CoreUnits;

/// Keys of `[drive]` that the file sets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WrittenDrive {
    /// `full_scale_v`.
    pub full_scale_v: Option<f64>,
    /// `duty_max`.
    pub duty_max: Option<f64>,
}

/// A data sheet mapped to the core's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Effort gain G, with its conversions.
    pub units: CoreUnits,
    /// Inertia J at the joint, kg m^2.
    pub inertia: f64,
    /// Share of the back-EMF in B, N m s/rad.
    pub back_emf: f64,
    /// Viscous friction B at the joint, with the share of the back-EMF, N m s/rad.
    pub viscous: f64,
    /// Output of the controller at full duty, V.
    pub full_scale_v: f64,
    /// Largest duty that the motor's current limit allows at standstill.
    pub duty_max: f64,
    /// Angle of one count at the joint, rad, if the file sets the encoder's lines.
    pub count: Option<f64>,
}

impl Mapping {
    /// Maps a data sheet; `None` if a motor driven by a current has neither a current limit nor a
    /// full scale.
    pub fn of(sheet: &DataSheet, written: WrittenDrive) -> Option<Self> {
        let (motor, gear) = (&sheet.motor, &sheet.gear);
        let torque_per_ampere = gear.ratio * gear.efficiency * motor.kt_nm_per_a;
        // Current at standstill per volt of the controller's output, A/V.
        let amperes_per_volt = match motor.driven_by {
            DrivenBy::Voltage => 1.0 / motor.resistance_ohm?,
            DrivenBy::Current => motor.amplifier_a_per_v?,
        };
        let effort_nm_per_v = torque_per_ampere * amperes_per_volt;
        let back_emf = match motor.driven_by {
            DrivenBy::Voltage => effort_nm_per_v * gear.ratio * motor.kt_nm_per_a,
            DrivenBy::Current => 0.0,
        };
        let limit_v = motor.current_limit_a.map(|limit| limit / amperes_per_volt);
        let full_scale_v = match (motor.driven_by, &sheet.supply) {
            (DrivenBy::Voltage, Some(supply)) => supply.voltage_v,
            _ => written.full_scale_v.or(limit_v)?,
        };
        let borne = limit_v.map_or(1.0, |limit_v| (limit_v / full_scale_v).min(1.0));
        Some(Self {
            units: CoreUnits { effort_gain: effort_nm_per_v },
            inertia: sheet.load.inertia_kg_m2
                + gear.efficiency * gear.ratio.powi(2) * motor.rotor_inertia_kg_m2,
            back_emf,
            viscous: sheet.viscous() + back_emf,
            full_scale_v,
            duty_max: written.duty_max.unwrap_or(borne),
            count: sheet.encoder.lines.map(|lines| {
                let turns = match sheet.encoder.at {
                    Some(EncoderPlace::Motor) => gear.ratio,
                    Some(EncoderPlace::Load) | None => 1.0,
                };
                // Four edges per line.
                TAU / (4.0 * f64::from(lines) * turns)
            }),
        })
    }

    /// Converts a torque at the joint (N m) to volts.
    pub fn volts(&self, torque: f64) -> f64 {
        self.units.volts(torque)
    }

    /// Returns the acceleration of the joint for each volt of effort (kappa), deg/s^2 per V.
    pub fn gain(&self) -> f64 {
        1.0 / self.units.per_degree(self.inertia)
    }

    /// Returns the viscous friction b, V s/deg.
    pub fn viscous_v(&self) -> f64 {
        self.units.per_degree(self.viscous)
    }

    /// Returns the largest torque at standstill, N m.
    pub fn stall(&self) -> f64 {
        self.units.effort(self.full_scale_v * self.duty_max)
    }
}
