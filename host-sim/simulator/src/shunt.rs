//! The sensor of the motor's current as a simulated board has it: shunt, amplifier and converter.
//!
//! ```text
//! pin = V_ref / 2 (1 +- i / full scale)      whole millivolts, within 0 to V_ref
//! reading = floor(pin 4095 / V_ref)          V_ref = 3.3 V
//! ```
//!
//! The emulated converter takes whole millivolts, so the host does as well.

use dynamics::joint::CountNoise;
use files::hardware::STM32F405;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::encoder::Direction;

/// Reference of the converter, mV.
pub const REFERENCE_MV: u32 = 3300;

/// A shunt with its amplifier, and what is wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shunt {
    full_scale_a: f64,
    direction: Direction,
    /// State of the sensor.
    pub state: ShuntState,
    noise: CountNoise,
}

/// State of a sensor of the current.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShuntState {
    /// It works.
    #[default]
    Sound,
    /// Its wires are swapped.
    Reversed,
    /// Its output is stuck at a voltage, mV.
    Stuck(u32),
    /// Its output has noise: a voltage more, the same or less, mV, equally often.
    Noisy(u32),
}

impl Shunt {
    /// Creates the shunt of a sensor.
    pub fn of(sensor: &CurrentSensor) -> Self {
        let CurrentSensor { full_scale, direction, .. } = *sensor;
        Self {
            full_scale_a: full_scale.into(),
            direction,
            state: ShuntState::Sound,
            noise: CountNoise::new(1),
        }
    }

    /// Returns the voltage on the converter's pin at a current (A), mV.
    pub fn pin_mv(&mut self, current_a: f64) -> u32 {
        let middle = 0.5 * f64::from(REFERENCE_MV);
        let is_forward =
            (self.direction == Direction::Forward) == (self.state != ShuntState::Reversed);
        let share = if is_forward { current_a } else { -current_a } / self.full_scale_a;
        let noise = match self.state {
            ShuntState::Stuck(mv) => return mv,
            ShuntState::Noisy(mv) => self.noise.next() as f64 * f64::from(mv),
            ShuntState::Sound | ShuntState::Reversed => 0.0,
        };
        (middle * (1.0 + share) + noise).round().clamp(0.0, REFERENCE_MV.into()) as u32
    }

    /// Returns the converter's reading at a current, A.
    pub fn reading(&mut self, current_a: f64) -> u16 {
        let top = u32::from(STM32F405.supply_top);
        (self.pin_mv(current_a) * top / REFERENCE_MV).min(top) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_current_is_a_share_of_the_reference_around_its_middle_and_the_ends_are_the_rails() {
        let mut shunt = Shunt::of(&CurrentSensor::derived(8.25, [1.0, 0.0]));
        // 1.65 V and 0.2 V for each ampere.
        for (current_a, mv) in [(0.0, 1650), (1.0, 1850), (-8.0, 50), (9.0, 3300), (-9.0, 0)] {
            assert_eq!(shunt.pin_mv(current_a), mv, "{current_a} A");
        }
        assert_eq!([0.0, 9.0, -9.0].map(|a| shunt.reading(a)), [2047, 4095, 0]);
        shunt.state = ShuntState::Reversed;
        assert_eq!(shunt.pin_mv(1.0), 1450);
        shunt.state = ShuntState::Stuck(1700);
        assert_eq!(shunt.pin_mv(1.0), 1700);
        shunt.state = ShuntState::Noisy(30);
        let seen: std::collections::BTreeSet<u32> = (0..100).map(|_| shunt.pin_mv(1.0)).collect();
        assert_eq!(Vec::from_iter(seen), [1820, 1850, 1880]);
    }
}
