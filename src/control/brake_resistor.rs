//! The brake resistor: a resistor across the supply of the bridge, which turns into heat what a
//! braking motor feeds back into a supply that does not take it.
//!
//! ```text
//! d  = (V - from) / (full - from)            from 0 to duty_max: share of the next tick
//! d <= (E_max - E) R / (V^2 h)
//! E  = E + d V^2 h / R - P h                 from 0; J
//! ```
//!
//! V is the reading of the supply, h the sample time, R the resistance. P is the power that the
//! resistor tolerates forever, and E_max the energy that it tolerates beyond that. Once E has
//! reached E_max, d is the duty of the power P. A joint that goes on to brake then lifts the supply
//! until its monitor trips (fault 20). The board runs the law in every tick, beside the servo, also
//! with the output off and after a fault: a joint that coasts, or another drive on the supply,
//! feeds back as well.
//!
//! A reading is one tick old, so the supply with a capacitance C follows
//! `V'' = V' - a (V - from) + ...`, with `a = h full / (R C (full - from))`. It is stable for
//! `a < 1`, and swings do not occur for `a <= 1/4`: `C >= 4 h full / (R (full - from))`. A smaller
//! capacitor lets the supply swing by up to `2 h V / (R C)`, and the resistor takes power from the
//! supply.
//!
//! Does badly: the capacitance is not known, so nothing refuses one that is too small. E follows
//! the readings, which lag a rising supply by one to two ticks. After a reset the resistor counts
//! as hot, E = E_max, since its heat is not known; it is cold after `E_max / P`. A resistor that is
//! not connected, or a transistor that conducts forever, is not detected.

use crate::control::hardware::Hardware;
use crate::units::error::HUGE;
use crate::units::value::{Table, table};

/// Steps of the duty in a whole tick.
pub const STEPS: u16 = 1024;

/// Largest duty: the output of a tick is over before the next tick begins.
const LARGEST: f32 = 0.9;

table! {
    /// The brake resistor and its limits.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct BrakeResistor (resistor) "brake_resistor" if (resistor.is_there()) {
        /// Resistance, ohm, with the switch. Its power at `full_v`, times `duty_max`, has to exceed
        /// what the braking motor feeds back.
        resistance: f32 = 0x0E01 "resistance_ohm", Above(0.0, HUGE), Needed(22.0);
        /// Supply above which the resistor is switched on, V: above the highest voltage of the
        /// supply itself, which it would load otherwise.
        from: f32 = 0x0E02 "from_v", Above(0.0, HUGE), Needed(52.0);
        /// Supply of the full duty, V, up to `limits.supply_max_v`.
        full: f32 = 0x0E03 "full_v", Above(resistor.from, HUGE), Needed(58.0);
        /// Largest duty: share of a tick for which the resistor is on.
        duty_max: f32 = 0x0E04 "duty_max", Above(0.0, LARGEST), Default(LARGEST);
        /// Power that the resistor tolerates forever, W: the rated power of its data sheet at the
        /// temperature around it.
        power: f32 = 0x0E05 "power_w", Above(0.0, HUGE), Needed(10.0);
        /// Energy that the cold resistor tolerates beyond that power, J: from the overload curve of
        /// its data sheet, the least of (overload power - rated power) times duration.
        energy: f32 = 0x0E06 "energy_j", Above(0.0, HUGE), Needed(100.0);
    }
}

impl BrakeResistor {
    /// A supply without a brake resistor.
    pub const NONE: Self = Self { resistance: 0.0, ..Self::EXAMPLE };

    /// Returns whether there is a resistor.
    #[inline]
    pub const fn is_there(&self) -> bool {
        self.resistance > 0.0
    }
}

/// The law of a brake resistor, prepared from its parameters, with the heat of the resistor.
#[derive(Clone, Copy, Debug)]
pub struct BrakeResistorLaw {
    /// Readings of the supply's converter.
    from: f32,
    /// Duty of one reading more.
    slope: f32,
    duty_max: f32,
    /// Energy of a whole tick at a reading of one, J.
    heat: f32,
    /// Energy that the resistor gives off in a tick, J.
    cools: f32,
    most: f32,
    energy: f32,
    /// What the rounding of the sum has left out, J: at an energy of 3e7 times what a tick gives
    /// off, that is below half of the last bit, and the sum alone would never cool.
    rest: f32,
}

impl BrakeResistorLaw {
    /// Prepares the law of a validated resistor; none without one. `full_scale` is the supply (V)
    /// at the converter's largest reading, `sample_time` the time of a tick, s.
    pub fn of(
        resistor: &BrakeResistor,
        [full_scale, sample_time]: [f32; 2],
        hardware: &Hardware,
    ) -> Option<Self> {
        let BrakeResistor { resistance, from, full, duty_max, power, energy } = *resistor;
        let unit = full_scale / f32::from(hardware.supply_top);
        resistor.is_there().then(|| Self {
            from: from / unit,
            slope: unit / (full - from),
            duty_max,
            heat: unit * unit * sample_time / resistance,
            cools: power * sample_time,
            most: energy,
            energy,
            rest: 0.0,
        })
    }

    /// Returns the duty until the next tick, in [`STEPS`] of the tick, for a reading of the supply.
    /// It has to be called once a tick.
    pub fn step(&mut self, reading: u16) -> u16 {
        let reading = f32::from(reading);
        let heat = self.heat * reading * reading;
        self.add(-self.cools);
        let duty = ((reading - self.from) * self.slope).max(0.0).min(self.duty_max);
        // Without a supply the second one is infinite.
        let duty = duty.min((self.most - self.energy) / heat);
        let steps = (duty * f32::from(STEPS)) as u16;
        self.add(f32::from(steps) / f32::from(STEPS) * heat);
        steps
    }

    /// Adds to the energy, which is not below 0, and carries what rounding leaves out (Kahan).
    fn add(&mut self, change: f32) {
        let change = change + self.rest;
        let sum = self.energy + change;
        self.rest = if sum > 0.0 { change - (sum - self.energy) } else { 0.0 };
        self.energy = sum.max(0.0);
    }

    /// Returns the energy in the resistor beyond its rated power, J.
    pub const fn energy(&self) -> f32 {
        self.energy
    }

    /// Returns this law with the heat of the one that it replaces.
    #[must_use]
    pub const fn after(self, before: Option<&Self>) -> Self {
        match before {
            Some(before) => Self { energy: before.energy, rest: before.rest, ..self },
            None => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::value::Values;

    const BOARD: Hardware = Hardware {
        pwm_clock_hz: 168e6,
        supply_top: 4095,
        dead_time_max: 6e-6,
        sample_time: [1e-4, 0.02],
    };

    /// A reading is 10 mV, and a tick 1 ms.
    fn law(resistor: BrakeResistor) -> BrakeResistorLaw {
        assert_eq!(resistor.validate(), Ok(()));
        BrakeResistorLaw::of(&resistor, [40.95, 1e-3], &BOARD).unwrap()
    }

    /// 10 ohm from 25 V, full at 30 V.
    const RESISTOR: BrakeResistor = BrakeResistor {
        resistance: 10.0,
        from: 25.0,
        full: 30.0,
        duty_max: 0.9,
        power: 4.0,
        energy: 2.0,
    };

    fn cold() -> BrakeResistorLaw {
        let mut law = law(RESISTOR);
        // 2 J at 4 W.
        (0..501).for_each(|_| assert_eq!(law.step(2400), 0));
        assert_eq!(law.energy(), 0.0);
        law
    }

    #[test]
    fn the_duty_rises_with_the_supply_up_to_its_limit() {
        for (reading, expected) in
            [(0, 0), (2500, 0), (2600, 204), (2750, 512), (2950, 921), (3000, 921), (4095, 921)]
        {
            let found = cold().step(reading);
            assert!(found.abs_diff(expected) <= 1, "{reading}: {found}, not {expected}");
        }
        assert!(BrakeResistorLaw::of(&BrakeResistor::NONE, [40.95, 1e-3], &BOARD).is_none());
    }

    /// 27.5 V and half of the time are 37.8 W, of which 33.8 W are too much: 2 J last for 59.2 ms.
    /// From then on it is 4 W, a duty of 4 W 10 ohm / 27.5^2 V^2 = 0.0529.
    #[test]
    fn energy_beyond_the_limit_leaves_the_power_that_the_resistor_tolerates_forever() {
        let mut law = cold();
        let whole = (1..1000).find(|_| law.step(2750) < 510).unwrap();
        assert!((59..=61).contains(&whole), "{whole} ticks");
        let mut steps = 0;
        for _ in 0..2000 {
            steps += u32::from(law.step(2750));
            assert!(law.energy() <= 2.0, "{} J", law.energy());
        }
        let mean = f64::from(steps) / 2000.0 / 1024.0;
        assert!((mean / 0.0529 - 1.0).abs() < 0.01, "{mean}");
    }

    /// 2e5 J less 4 W for 100 s. A tick gives off 4 mJ, and half of the last bit of 2e5 J is 8 mJ.
    #[test]
    fn a_large_resistor_cools_by_less_than_the_last_bit_of_its_energy_in_a_tick() {
        let mut law = law(BrakeResistor { energy: 2e5, ..RESISTOR });
        (0..100_000).for_each(|_| assert_eq!(law.step(2400), 0));
        assert!((law.energy() - (2e5 - 400.0)).abs() < 0.1, "{} J", law.energy());
    }

    #[test]
    fn a_resistor_is_hot_after_a_reset_and_stays_so_with_other_parameters() {
        let mut new = law(RESISTOR);
        assert!(new.step(2750) < 60);
        let mut before = cold();
        (0..30).for_each(|_| assert!(before.step(2750) > 510));
        new = new.after(Some(&before));
        assert_eq!(new.energy(), before.energy());
        let mut smaller = law(BrakeResistor { energy: 0.5, ..RESISTOR }).after(Some(&before));
        assert_eq!(smaller.energy(), before.energy());
        assert_eq!(smaller.step(2750), 0);
    }
}
