//! The measurement of the winding: a joint at rest, pulses of voltage, and the current that they
//! cause.
//!
//! The board makes the pulses in each period of the PWM
//! ([`winding_pulses`](crate::control::winding_pulses)). The control tick watches the joint
//! meanwhile: the travel and the time of a jog bound it, and so do the monitors of the servo,
//! except for those of the current, which compare it with the configured winding. The effort of a
//! jog bounds the voltage. A tick that measures a current beyond `peak_a` by a quarter ends the
//! pulses, and the converter's watchdog turns the bridge off at `trip_a`.
//!
//! The client calculates resistance and inductance from the readings.

use serde::{Deserialize, Serialize};

use crate::control::drive::{Drive, DriveConfig};
use crate::control::winding_pulses::{GroupSums, MOST_CYCLES, MOST_PERIODS, WindingPulses};
use crate::motion::jog::{EFFORT, JogBounds};
use crate::units::error::{InvalidValue, above, between};
use crate::units::value::Key;

/// Names of a request's values in messages.
pub(crate) const PERIODS: Key = Key(0x0610);
pub(crate) const CYCLES: Key = Key(0x0611);

/// Request of a client for a measurement of the winding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WindingRequest {
    /// Voltage of the pulses, V: at most the effort of a jog.
    pub effort: f32,
    /// Periods of the PWM in a group of readings, 1 to 64.
    pub periods: u8,
    /// Counted cycles, 1 to 2000.
    pub cycles: u16,
}

/// End of a measurement of the winding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WindingEnd {
    /// It has not ended.
    #[default]
    Not,
    /// All cycles are over.
    Done,
    /// The joint has moved by the travel of a jog.
    Travel,
    /// The time of a jog is over.
    Time,
    /// A tick has measured a current beyond `peak_a` by a quarter.
    Current,
}

/// Findings of a measurement of the winding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WindingFindings {
    /// What has ended it.
    pub ended: WindingEnd,
    /// Voltage of the pulses, V: the effort of the request in whole codes.
    pub effort: f32,
    /// Current of a reading, A, with the sign of the sensor's direction.
    pub unit: f32,
    /// Largest distance of the joint from its place, counts.
    pub moved: u32,
    /// Sums of the readings.
    pub sums: GroupSums,
}

/// A measurement of the winding with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindingTest {
    pulses: WindingPulses,
    travel: u32,
    ticks: u32,
    findings: WindingFindings,
}

impl WindingTest {
    /// Prepares a measurement for a drive that has been validated, within the bounds of a jog.
    /// `unit` is the current of a reading, A; `sample_time` in s, and `count` is the angle of a
    /// count, deg.
    ///
    /// # Errors
    /// Returns an error that names the value that is not allowed.
    pub fn new(
        asked: &WindingRequest,
        bounds: &JogBounds,
        (drive, config): (Drive, &DriveConfig),
        [sample_time, count, unit]: [f32; 3],
    ) -> Result<Self, InvalidValue> {
        let WindingRequest { effort, periods, cycles } = *asked;
        above(EFFORT, effort, 0.0, bounds.effort)?;
        between(PERIODS, periods.into(), 1.0, MOST_PERIODS.into())?;
        between(CYCLES, cycles.into(), 1.0, MOST_CYCLES.into())?;
        let pulses = WindingPulses::new(effort, periods, cycles, drive);
        let findings =
            WindingFindings { effort: pulses.volts(config), unit, ..WindingFindings::default() };
        // The conversions saturate.
        let ticks = libm::roundf(bounds.time / sample_time) as u32;
        Ok(Self { pulses, travel: (bounds.travel / count) as u32, ticks, findings })
    }

    /// Returns the pulses for the board.
    pub const fn pulses(&self) -> WindingPulses {
        self.pulses
    }

    /// Runs one tick with the joint at `counts` from where the measurement began. The effort of the
    /// tick is zero: the board makes the voltage.
    pub fn update(&mut self, counts: i32) -> f32 {
        if self.is_over() {
            return 0.0;
        }
        self.findings.moved = self.findings.moved.max(counts.unsigned_abs());
        self.ticks = self.ticks.saturating_sub(1);
        if self.findings.moved > self.travel {
            self.findings.ended = WindingEnd::Travel;
        } else if self.ticks == 0 {
            self.findings.ended = WindingEnd::Time;
        }
        0.0
    }

    /// Ends the measurement, because the current exceeds its limit.
    pub const fn exceed(&mut self) {
        if !self.is_over() {
            self.findings.ended = WindingEnd::Current;
        }
    }

    /// Takes the readings of pulses that are over.
    pub fn take(&mut self, sums: &GroupSums) {
        if !self.is_over() {
            self.findings.sums = *sums;
            self.findings.ended = WindingEnd::Done;
        }
    }

    /// Restarts the measurement.
    pub fn restart(&mut self) {
        let WindingFindings { effort, unit, .. } = self.findings;
        self.findings = WindingFindings { effort, unit, ..WindingFindings::default() };
    }

    /// Returns whether the measurement has ended.
    pub const fn is_over(&self) -> bool {
        !matches!(self.findings.ended, WindingEnd::Not)
    }

    /// Returns the findings so far.
    pub const fn findings(&self) -> &WindingFindings {
        &self.findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::hardware::Hardware;
    use crate::units::value::Table;

    const COUNT: f32 = 0.01;

    fn test(asked: WindingRequest) -> Result<WindingTest, InvalidValue> {
        let hardware = Hardware {
            pwm_clock_hz: 168e6,
            supply_top: 4095,
            dead_time_max: 6e-6,
            sample_time: [1e-4, 0.02],
        };
        let config = DriveConfig::EXAMPLE;
        let bounds = JogBounds { effort: 1.5, travel: 0.5, time: 2.0, ..JogBounds::EXAMPLE };
        let drive = Drive::new(&config, &hardware).unwrap();
        WindingTest::new(&asked, &bounds, (drive, &config), [0.001, COUNT, 0.01])
    }

    const ASKED: WindingRequest = WindingRequest { effort: 1.0, periods: 4, cycles: 10 };

    #[test]
    fn travel_and_time_of_a_jog_end_a_measurement_whose_readings_then_come_too_late() {
        for (counts, ticks, ended) in [
            (51, 1, WindingEnd::Travel),
            (-51, 1, WindingEnd::Travel),
            (50, 2000, WindingEnd::Time),
        ] {
            let mut test = test(ASKED).unwrap();
            for tick in 1..=ticks {
                assert!(!test.is_over(), "{counts}: {tick}");
                assert_eq!(test.update(counts), 0.0);
            }
            test.take(&[7; crate::control::winding_pulses::GROUPS]);
            let found = test.findings();
            assert_eq!((found.ended, found.moved), (ended, counts.unsigned_abs()));
            assert_eq!(found.sums, GroupSums::default());
            test.restart();
            assert!(!test.is_over() && test.findings().moved == 0);
        }
    }

    #[test]
    fn an_effort_beyond_that_of_a_jog_and_numbers_out_of_range_are_named() {
        for (asked, key) in [
            (WindingRequest { effort: 1.6, ..ASKED }, EFFORT),
            (WindingRequest { effort: -1.0, ..ASKED }, EFFORT),
            (WindingRequest { effort: f32::NAN, ..ASKED }, EFFORT),
            (WindingRequest { periods: 0, ..ASKED }, PERIODS),
            (WindingRequest { periods: 65, ..ASKED }, PERIODS),
            (WindingRequest { cycles: 0, ..ASKED }, CYCLES),
            (WindingRequest { cycles: 2001, ..ASKED }, CYCLES),
        ] {
            assert_eq!(test(asked).map(|_| ()).unwrap_err().key, key, "{asked:?}");
        }
        for asked in [ASKED, WindingRequest { effort: 1.5, periods: 64, cycles: 2000 }] {
            assert!(test(asked).is_ok(), "{asked:?}");
        }
    }
}
