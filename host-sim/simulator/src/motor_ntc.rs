//! The temperature sensor of the motor as a simulated board has it: an NTC at the winding, and the
//! resistor to the converter's reference.
//!
//! ```text
//! R = R_25 exp(B (1/T - 1/298.15 K))          pin = V_ref R / (divider + R)
//! ```
//!
//! The pin has whole millivolts, as the one of [`shunt`](crate::shunt). The NTC has the temperature
//! of the winding at once: a real one follows tens of seconds later.

use files::hardware::STM32F405;
use stiction::control::motor_ntc::MotorNtc;

use crate::shunt::REFERENCE_MV;
use crate::winding_heat::{REFERENCE_C, Temperatures};

/// An NTC with its resistor, and what is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ntc {
    resistance_25_ohm: f64,
    beta_k: f64,
    divider_ohm: f64,
    /// State of the sensor.
    pub state: NtcState,
}

/// State of a temperature sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NtcState {
    /// It has the temperature of the winding.
    #[default]
    Sound,
    /// It is open, or one of its wires is.
    Open,
    /// It is shorted.
    Shorted,
    /// It has a temperature of its own, deg C.
    At(f64),
}

impl Ntc {
    /// Creates the sensor of the parameters; `None` without one.
    pub fn of(ntc: &MotorNtc) -> Option<Self> {
        let MotorNtc { resistance_25, beta, divider, .. } = *ntc;
        ntc.is_there().then(|| Self {
            resistance_25_ohm: resistance_25.into(),
            beta_k: beta.into(),
            divider_ohm: divider.into(),
            state: NtcState::Sound,
        })
    }

    /// Returns the voltage on the converter's pin, mV. A motor without temperatures has those of
    /// the reference.
    pub fn pin_mv(&self, motor: Option<Temperatures>) -> u32 {
        let celsius = match self.state {
            NtcState::Open => return REFERENCE_MV,
            NtcState::Shorted => return 0,
            NtcState::At(celsius) => celsius,
            NtcState::Sound => motor.map_or(REFERENCE_C, |motor| motor.winding_c),
        };
        let apart = 1.0 / (celsius + 273.15) - 1.0 / 298.15;
        let ohm = self.resistance_25_ohm * (self.beta_k * apart).exp();
        (f64::from(REFERENCE_MV) * ohm / (self.divider_ohm + ohm)).round() as u32
    }

    /// Returns the converter's reading.
    pub fn reading(&self, motor: Option<Temperatures>) -> u16 {
        let top = u32::from(STM32F405.supply_top);
        (self.pin_mv(motor) * top / REFERENCE_MV).min(top) as u16
    }
}
