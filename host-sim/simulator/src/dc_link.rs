//! The supply of the bridge with its capacitor: a source that takes current back or one that does
//! not, the motor, and a brake resistor.
//!
//! ```text
//! source -- R_s --(diode)--+-- C --+-- bridge: draws W in a tick, or returns it (W < 0)
//!                          |       |
//!                          +-- R --+ for a share d of the tick
//!
//! C V^2 / 2  ->  C V^2 / 2 exp(-2 d h / (R C)) - W + P h      P: other drives on the same supply
//! V          ->  V_s + (V - V_s) exp(-h / (R_s C))            if V < V_s, or without the diode
//! ```
//!
//! Limits: the three act one after the other in each tick. A bridge that is off returns nothing:
//! its diodes conduct for a back-EMF above the supply only, which no motor here reaches.

use files::data_sheet::tables::SupplyTable;
use files::hardware::STM32F405;
use stiction::Parameters;
use stiction::control::brake_resistor::STEPS;

use crate::shunt::REFERENCE_MV;

/// The supply of a bridge, with its capacitor.
#[derive(Clone, Debug, PartialEq)]
pub struct DcLink {
    /// Power that other drives on this supply feed back, W.
    pub feed_w: f64,
    /// Whether the brake resistor is connected.
    pub has_resistor: bool,
    supply: SupplyTable,
    /// Resistance of the brake resistor, ohm; 0 without one.
    resistor_ohm: f64,
    /// Supply at the full scale of its converter, V.
    full_scale_v: f64,
    volts: f64,
    resistor_j: f64,
    source_j: f64,
}

impl DcLink {
    /// Creates the supply of a data sheet, with the resistor and the divider of a device's
    /// parameters; `None` without a capacitor.
    pub fn of(supply: &SupplyTable, parameters: &Parameters) -> Option<Self> {
        (supply.capacitance_f > 0.0).then(|| Self {
            feed_w: 0.0,
            has_resistor: true,
            resistor_ohm: parameters.brake_resistor.resistance.into(),
            full_scale_v: parameters.device.supply_full_scale.into(),
            volts: supply.voltage_v,
            supply: supply.clone(),
            resistor_j: 0.0,
            source_j: 0.0,
        })
    }

    /// Returns the voltage, V.
    pub const fn volts(&self) -> f64 {
        self.volts
    }

    /// Returns the ratio of the voltage to that of the source without load.
    pub fn ratio(&self) -> f64 {
        self.volts / self.supply.voltage_v
    }

    /// Returns the energy that the resistor has turned into heat, J.
    pub const fn resistor_j(&self) -> f64 {
        self.resistor_j
    }

    /// Returns the energy that the source has put into the capacitor, J.
    pub const fn source_j(&self) -> f64 {
        self.source_j
    }

    /// Returns the energy in the capacitor, J.
    pub fn stored_j(&self) -> f64 {
        0.5 * self.supply.capacitance_f * self.volts * self.volts
    }

    /// Returns the voltage on the converter's pin, mV; none if the supply is not measured.
    pub fn pin_mv(&self) -> Option<u32> {
        let top = f64::from(REFERENCE_MV);
        let share = self.volts / self.full_scale_v;
        (self.full_scale_v > 0.0).then(|| (share * top).round().clamp(0.0, top) as u32)
    }

    /// Returns the converter's reading; none if the supply is not measured.
    pub fn reading(&self) -> Option<u16> {
        let top = u32::from(STM32F405.supply_top);
        self.pin_mv().map(|pin_mv| (pin_mv * top / REFERENCE_MV).min(top) as u16)
    }

    /// Passes a time (s) in which the motor draws an energy (J), and the resistor is on for a share
    /// of it, in steps of the core's duty.
    pub fn pass(&mut self, drawn_j: f64, steps: u16, duration_s: f64) {
        let SupplyTable { voltage_v, internal_resistance_ohm, capacitance_f, .. } = self.supply;
        let mut stored_j = self.stored_j();
        if self.has_resistor && self.resistor_ohm > 0.0 {
            let on_s = f64::from(steps) / f64::from(STEPS) * duration_s;
            let heat_j = stored_j * -(-2.0 * on_s / (self.resistor_ohm * capacitance_f)).exp_m1();
            self.resistor_j += heat_j;
            stored_j -= heat_j;
        }
        stored_j = (stored_j - drawn_j + self.feed_w * duration_s).max(0.0);
        self.volts = (2.0 * stored_j / capacitance_f).sqrt();
        if self.volts < voltage_v || self.supply.takes_current_back {
            let keeps = (-duration_s / (internal_resistance_ohm * capacitance_f)).exp();
            self.volts = voltage_v + (self.volts - voltage_v) * keeps;
            self.source_j += self.stored_j() - stored_j;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::units::value::Table as _;

    fn link(takes_current_back: bool, internal_resistance_ohm: f64) -> DcLink {
        let supply = SupplyTable {
            voltage_v: 48.0,
            internal_resistance_ohm,
            takes_current_back,
            capacitance_f: 1e-3,
        };
        let mut parameters = Parameters::EXAMPLE;
        parameters.brake_resistor.resistance = 20.0;
        parameters.device.supply_full_scale = 66.0;
        DcLink::of(&supply, &parameters).unwrap()
    }

    #[test]
    fn what_a_motor_returns_charges_the_capacitor_unless_the_source_takes_it() {
        // 0.5 mF (52^2 - 48^2) = 0.2 J.
        let mut alone = link(false, 0.0);
        alone.pass(-0.2, 0, 1e-3);
        assert!((alone.volts() - 52.0).abs() < 1e-9 && alone.source_j() == 0.0, "{alone:?}");
        // 3300 mV 52 / 66 = 2600 mV.
        assert_eq!((alone.pin_mv(), alone.reading()), (Some(2600), Some(3226)));
        let mut taken = link(true, 0.0);
        taken.pass(-0.2, 0, 1e-3);
        assert!((taken.volts() - 48.0).abs() < 1e-9, "{taken:?}");
        assert!((taken.source_j() + 0.2).abs() < 1e-12, "{taken:?}");
        // What it draws comes from either source, within ten time constants of 0.1 ms.
        for takes_current_back in [false, true] {
            let mut drawn = link(takes_current_back, 0.1);
            drawn.pass(0.2, 0, 1e-3);
            assert!((drawn.volts() - 48.0).abs() < 1e-3, "{drawn:?}");
        }
    }

    #[test]
    fn the_resistor_discharges_the_capacitor_by_its_share_of_the_time() {
        let mut alone = link(false, 0.0);
        alone.pass(-1.0, 0, 1e-3);
        let (volts, stored_j) = (alone.volts(), alone.stored_j());
        // Half of a tick of 1 ms with R C = 20 ms.
        alone.pass(0.0, STEPS / 2, 1e-3);
        assert!((alone.volts() / volts - (-0.5f64 / 20.0).exp()).abs() < 1e-12, "{alone:?}");
        assert!((stored_j - alone.stored_j() - alone.resistor_j()).abs() < 1e-12, "{alone:?}");
        alone.has_resistor = false;
        let volts = alone.volts();
        alone.pass(0.0, STEPS / 2, 1e-3);
        assert!((alone.volts() - volts).abs() < 1e-12, "{alone:?}");
    }
}
