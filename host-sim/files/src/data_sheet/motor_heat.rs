//! Heat of the motor: the effort that its winding can hold forever, and its back-EMF at the joint.
//!
//! ```text
//! rated current     motor.rated_current_a, or a tenth of the stall current V / R
//! voltage driven    u = R i + n K_t q'       continuous: R i_rated      back-EMF: n K_t
//! current driven    u = i / A                continuous: i_rated / A    back-EMF: 0
//! ```
//!
//! The tenth is a guess for motors whose rated current is not in the file. Limits: the case and the
//! room are unknown.

use super::sheet::DataSheet;
use super::tables::DrivenBy;

/// Current that a motor without a rated current can hold forever, as a part of its stall current.
const OF_STALL: f64 = 0.1;

/// Continuous effort and back-EMF of a motor, in the controller's volts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorHeat {
    /// Effort that the winding can hold forever at standstill, V.
    pub continuous_v: f64,
    /// Back-EMF at the joint, V s/rad.
    pub back_emf: f64,
    /// Whether the data sheet has the rated current; if not, it is a guess.
    pub is_rated: bool,
}

impl DataSheet {
    /// Returns the heat limits of the motor; `None` if neither its rated current nor its stall
    /// current is known.
    pub fn motor_heat(&self) -> Option<MotorHeat> {
        let motor = &self.motor;
        let stall_a = || Some(self.supply.as_ref()?.voltage_v / motor.resistance_ohm?);
        let rated_a = motor.rated_current_a.or_else(|| Some(OF_STALL * stall_a()?))?;
        let (continuous_v, back_emf) = match motor.driven_by {
            DrivenBy::Voltage => {
                (motor.resistance_ohm? * rated_a, self.gear.ratio * motor.kt_nm_per_a)
            }
            DrivenBy::Current => (rated_a / motor.amplifier_a_per_v?, 0.0),
        };
        Some(MotorHeat { continuous_v, back_emf, is_rated: motor.rated_current_a.is_some() })
    }
}
