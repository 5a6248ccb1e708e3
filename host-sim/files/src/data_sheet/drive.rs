//! Drive of a data sheet: the motor's effort as a function of the controller's output.
//!
//! A bridge with the duty `d = u / V` on a supply with the internal resistance R_s loses the
//! voltage R_s d i, and `V_t = 2 t_d f V` by its dead time t_d, always against the current. With
//! the mean of the PWM and the settled current,
//!
//! ```text
//! i (R + d^2 R_s) = shrink(u - n K_t q', V_t)      shrink(x, a) = sgn(x) max(|x| - a, 0)
//! ```
//!
//! If the supply cannot absorb current, a braking current (`d i < 0`) charges the bridge until none
//! flows: i = 0. An amplifier sets `i = A u` as long as its supply reaches `R i + n K_t q'`. The
//! effort is the output with which an ideal drive ([`super::units`]) has the same current i:
//! `R i + n K_t q'` for a bridge, `i / A` for an amplifier.
//!
//! Guarantees: with R_s = 0, t_d = 0 and a supply that absorbs current, the effort of a bridge
//! equals its output except for rounding. Limits: the formulas use the back-EMF at the start of the
//! sample; in locked antiphase with a current that ripples through zero, a real dead time costs
//! less.

use super::sheet::DataSheet;
use super::tables::DrivenBy;

/// Model of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveModel {
    /// The effort is the output.
    Ideal,
    /// Bridge with losses, on a supply with an internal resistance.
    Bridge {
        /// Resistance R of the winding, ohm.
        resistance: f64,
        /// Internal resistance R_s of the supply, ohm.
        supply_resistance: f64,
        /// Voltage V of the supply, V.
        supply: f64,
        /// Voltage V_t that is lost by the dead time, V.
        dead_time: f64,
        /// Whether the supply absorbs the current of a braking motor.
        takes_current_back: bool,
        /// Back-EMF n K_t at the joint, V s/rad.
        back_emf: f64,
    },
    /// Amplifier that sets the current, within the limits of its supply.
    Amplifier {
        /// Current A per volt of the output, A/V.
        amperes_per_volt: f64,
        /// Resistance R of the winding, ohm.
        resistance: f64,
        /// Voltage V of the supply, V.
        supply: f64,
        /// Back-EMF n K_t at the joint, V s/rad.
        back_emf: f64,
    },
}

/// Returns `sgn(x) max(|x| - a, 0)`.
pub fn shrink(x: f64, a: f64) -> f64 {
    (x.abs() - a).max(0.0).copysign(x)
}

impl DriveModel {
    /// Creates the drive of a data sheet with a PWM of `pwm_hz`.
    pub fn of(sheet: &DataSheet, pwm_hz: f64) -> Self {
        let (motor, Some(supply)) = (&sheet.motor, &sheet.supply) else { return Self::Ideal };
        let Some(resistance) = motor.resistance_ohm else { return Self::Ideal };
        let back_emf = sheet.gear.ratio * motor.kt_nm_per_a;
        match (motor.driven_by, motor.amplifier_a_per_v) {
            (DrivenBy::Current, Some(amperes_per_volt)) => {
                Self::Amplifier { amperes_per_volt, resistance, supply: supply.voltage_v, back_emf }
            }
            _ if !sheet.bridge_is_real() => Self::Ideal,
            _ => Self::Bridge {
                resistance,
                supply_resistance: supply.internal_resistance_ohm,
                supply: supply.voltage_v,
                dead_time: sheet.dead_time_v(pwm_hz),
                takes_current_back: supply.takes_current_back,
                back_emf,
            },
        }
    }

    /// Returns the effort (V) for an output (V) at a speed of the joint (rad/s).
    pub fn effort(&self, output_v: f64, speed: f64) -> f64 {
        match *self {
            Self::Ideal => output_v,
            Self::Bridge {
                resistance,
                supply_resistance,
                supply,
                dead_time,
                takes_current_back,
                back_emf,
            } => {
                let (duty, induced) = (output_v / supply, back_emf * speed);
                let drives = shrink(output_v - induced, dead_time);
                let current = drives / (resistance + duty.powi(2) * supply_resistance);
                let flows = takes_current_back || duty * current >= 0.0;
                induced + if flows { current * resistance } else { 0.0 }
            }
            Self::Amplifier { amperes_per_volt, resistance, supply, back_emf } => {
                let induced = back_emf * speed;
                let [least, most] = [-supply, supply].map(|limit| (limit - induced) / resistance);
                (amperes_per_volt * output_v).max(least).min(most) / amperes_per_volt
            }
        }
    }
}

impl DataSheet {
    /// Returns whether the bridge or its supply differs from an ideal one.
    pub fn bridge_is_real(&self) -> bool {
        self.supply_is_real() || self.motor.dead_time_s > 0.0
    }

    /// Returns whether the supply differs from an ideal one.
    pub fn supply_is_real(&self) -> bool {
        self.supply.as_ref().is_some_and(|supply| {
            supply.internal_resistance_ohm > 0.0 || !supply.takes_current_back
        })
    }

    /// Returns the voltage that a bridge loses by its dead time, V, with a PWM of `pwm_hz`.
    pub fn dead_time_v(&self, pwm_hz: f64) -> f64 {
        let supply_v = self.supply.as_ref().map_or(0.0, |supply| supply.voltage_v);
        2.0 * self.motor.dead_time_s * pwm_hz * supply_v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BRIDGE: DriveModel = DriveModel::Bridge {
        resistance: 2.0,
        supply_resistance: 0.0,
        supply: 24.0,
        dead_time: 0.0,
        takes_current_back: true,
        back_emf: 4.0,
    };

    fn bridge(supply_resistance: f64, dead_time: f64, takes_current_back: bool) -> DriveModel {
        let DriveModel::Bridge { resistance, supply, back_emf, .. } = BRIDGE else { return BRIDGE };
        DriveModel::Bridge {
            resistance,
            supply_resistance,
            supply,
            dead_time,
            takes_current_back,
            back_emf,
        }
    }

    #[test]
    fn an_ideal_bridge_gives_its_output_at_any_speed() {
        for (output_v, speed) in [(24.0, 0.0), (-6.0, 1.5), (12.0, 3.0), (0.0, -2.0)] {
            let effort = BRIDGE.effort(output_v, speed);
            assert!((effort - output_v).abs() < 1e-12, "{effort}");
        }
    }

    /// The power of the source equals the losses in its own and in the motor's resistance.
    #[test]
    fn a_stalled_motor_on_a_weak_supply_balances_its_power() {
        for output_v in [24.0, 12.0, -18.0] {
            let current = bridge(0.5, 0.0, true).effort(output_v, 0.0) / 2.0;
            let from_supply = output_v / 24.0 * current;
            let (given, taken) =
                (24.0 * from_supply, 0.5 * from_supply.powi(2) + 2.0 * current.powi(2));
            assert!((given - taken).abs() < 1e-9 * given, "{given} W, {taken} W");
        }
    }

    #[test]
    fn a_dead_time_takes_its_volts_from_either_sense_and_no_more_than_there_are() {
        let drive = bridge(0.0, 1.0, true);
        assert_eq!([6.0, -6.0, 0.5].map(|volts| drive.effort(volts, 0.0)), [5.0, -5.0, 0.0]);
        // Without current the motor coasts: the effort is that of its own back-EMF.
        assert_eq!(drive.effort(6.5, 1.5), 6.0);
    }

    #[test]
    fn a_supply_that_takes_nothing_back_does_not_brake() {
        // 8 V of back-EMF against 2 V of output: the current would flow back.
        assert_eq!(bridge(0.0, 0.0, true).effort(2.0, 2.0), 2.0);
        assert_eq!(bridge(0.0, 0.0, false).effort(2.0, 2.0), 8.0);
        // A motor that is driven, and one that is shorted, are as before.
        assert_eq!(bridge(0.0, 0.0, false).effort(20.0, 2.0), 20.0);
        assert_eq!(bridge(0.0, 0.0, false).effort(0.0, 2.0), 0.0);
    }

    #[test]
    fn an_amplifier_gives_what_its_supply_can() {
        let drive = DriveModel::Amplifier {
            amperes_per_volt: 2.0,
            resistance: 2.0,
            supply: 24.0,
            back_emf: 4.0,
        };
        assert_eq!(drive.effort(5.0, 0.0), 5.0);
        // (24 V - 4 x 3 V) / 2 ohm = 6 A, which are 3 V of its input.
        assert_eq!(drive.effort(5.0, 3.0), 3.0);
        // Braking has both voltages: (-24 V - 12 V) / 2 ohm = -18 A.
        assert_eq!(drive.effort(-10.0, 3.0), -9.0);
    }
}
