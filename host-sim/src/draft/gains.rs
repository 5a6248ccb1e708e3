//! Rules for the gains of a first controller, from a joint's data sheet alone.
//!
//! With the joint in the core's units, `J_v q'' = u - b q' - F`, the sample time h and the angle q
//! of one count:
//!
//! ```text
//! w_n   = min(2 pi 8, 0.14 / h)                  rad/s, the loop's natural frequency
//! zeta  = 0.9
//! Kp    = J_v w_n^2
//! Kd    = max(0, 2 zeta J_v w_n - b)
//! v_ms  = F_s                                    SRNF: what starts the joint
//! alpha = min(0.25 / q, (J_v (0.66 / h)^2 - Kp) / v_ms), not below 0
//! v_slip = 0.9 F_c, V_ff = one count a second    feedforward
//! J_v, b, F_lo = F_c / 2, F_hi = 2 F_s           robust: what it is told
//! load   = what drives the joint, if that is more than F_c holds
//! ```
//!
//! Why: 0.14/h leaves two samples of delay a phase of 0.28 rad. 8 Hz is below the resonance of most
//! geared joints. Near the target SRNF adds the stiffness `v_ms alpha` to `Kp`; with 0.66/h it has
//! the natural frequency that the thesis's own gains have at 20 ms (`Kp` = 1, `v_ms` = 0.4,
//! `alpha` = 100, and there `alpha q` = 0.24). Feedforward that is more than the friction drives
//! the joint by itself, so it is a tenth less. `robust` bears any friction in the range that it is
//! told, and a data sheet says nothing of place, direction and temperature, hence the factors of
//! two.
//!
//! Guarantees: on the rigid joint of the data sheet PD has the damping ratio `zeta`. Does badly:
//! knows nothing of resonances and backlash, and is as good as the data sheet. Nothing of it has
//! been tried on a motor.

use std::f64::consts::TAU;

use crate::data_sheet::tables::Side;
use crate::data_sheet::{DataSheet, Mapping};

/// Damping ratio of PD on the joint.
pub const DAMPING_RATIO: f64 = 0.9;

/// Natural frequency times sample time that SRNF's stiffness may reach, as on the thesis's axis.
const STIFFEST: f64 = 0.66;

/// Gains of the controllers of a first file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstGains {
    /// w_n, rad/s.
    pub natural_frequency: f64,
    /// Kp, V/deg.
    pub kp: f64,
    /// Kd, V/(deg/s).
    pub kd: f64,
    /// v_ms, V.
    pub v_ms: f64,
    /// alpha, 1/deg.
    pub alpha: f64,
    /// v_slip, V.
    pub v_slip: f64,
    /// V_ff, deg/s.
    pub v_ff: f64,
    /// What `robust` is told.
    pub robust: Told,
}

/// What `robust` is told of a joint, in the core's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// J_v, V s^2/deg.
    pub inertia: f64,
    /// b, V s/deg.
    pub viscous: f64,
    /// F_lo and F_hi, V.
    pub breakaway: [f64; 2],
    /// Whether the encoder sees the load behind a transmission that springs.
    pub behind_a_spring: bool,
    /// The load that drives the joint, V; 0 if its friction holds it.
    pub load: f64,
}

impl Told {
    fn of(sheet: &DataSheet, mapping: &Mapping) -> Self {
        let lowest = mapping.volts(sheet.slip()[0].min(sheet.slip()[1]));
        let highest = mapping.volts(sheet.stick()[0].max(sheet.stick()[1]));
        let load = mapping.volts(sheet.load.constant_nm.abs() + sheet.load.unbalance_nm.abs());
        let springs = sheet.gear.stiffness_nm_per_rad.or(sheet.gear.stiffness_nm_per_deg).is_some();
        Self {
            inertia: mapping.units.per_degree(mapping.inertia),
            viscous: mapping.viscous_v(),
            breakaway: [0.5 * lowest, 2.0 * highest],
            behind_a_spring: springs && sheet.encoder.at == Some(Side::Load),
            load: if load > lowest { load } else { 0.0 },
        }
    }
}

impl FirstGains {
    /// Finds the gains for a joint; `count_deg` is the angle of one count.
    pub fn of(sheet: &DataSheet, mapping: &Mapping, [sample_time_s, count_deg]: [f64; 2]) -> Self {
        let inertia = mapping.units.per_degree(mapping.inertia);
        let natural_frequency = (TAU * 8.0).min(0.14 / sample_time_s);
        let kp = inertia * natural_frequency.powi(2);
        let kd = 2.0 * DAMPING_RATIO * inertia * natural_frequency - mapping.viscous_v();
        let v_ms = mapping.volts(sheet.stick()[0].max(sheet.stick()[1]));
        let stiffest = inertia * (STIFFEST / sample_time_s).powi(2) - kp;
        let alpha = if v_ms > 0.0 { (0.25 / count_deg).min(stiffest / v_ms) } else { 0.0 };
        Self {
            natural_frequency,
            kp,
            kd: kd.max(0.0),
            v_ms,
            alpha: alpha.max(0.0),
            v_slip: 0.9 * mapping.volts(sheet.slip()[0].min(sheet.slip()[1])),
            v_ff: count_deg,
            robust: Told::of(sheet, mapping),
        }
    }
}
