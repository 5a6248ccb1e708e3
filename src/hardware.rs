//! The figures of a board that the core has to know: those of its timers and converters that turn a
//! user's units into codes.

use crate::controller::SAMPLE_TIME;
use crate::device_config::DeviceConfig;
use crate::error::{Allowed, Error, between};
use crate::value::{Key, Table, key};

/// The figures of a board's timers and converters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardware {
    /// Clock of the timer that makes the PWM, Hz.
    pub pwm_clock_hz: f32,
    /// Largest reading of the converter that measures the supply.
    pub supply_top: u16,
    /// Longest dead time that the timer inserts between complementary outputs, s.
    pub dead_time_max: f32,
    /// Shortest and longest time between samples, s: what the tick's timer makes, and what its
    /// deadline leaves time for.
    pub sample_time: [f32; 2],
}

const PWM_HZ: Key = key(crate::drive::DriveConfig::ABOUT, "pwm_hz");
const DEAD_TIME: Key = key(DeviceConfig::ABOUT, "dead_time");

impl Hardware {
    /// Returns the compare value of full duty: the even timer top nearest to `pwm_hz`. The timer
    /// counts up and down (centre-aligned: one period is `2 top` clocks). The top is even, so that
    /// half duty is a whole number.
    ///
    /// # Errors
    /// Refuses a frequency whose top does not fit 16 bits, or that leaves fewer than 16 duties a
    /// side.
    ///
    /// ```
    /// let (pwm_clock_hz, supply_top, dead_time_max) = (168e6, 4095, 6e-6);
    /// let sample_time = [1e-4, 0.02];
    /// let hardware = stiction::Hardware { pwm_clock_hz, supply_top, dead_time_max, sample_time };
    /// assert_eq!(hardware.pwm_top(22e3), Ok(3818)); // 22.001 kHz
    /// ```
    pub fn pwm_top(&self, pwm_hz: f32) -> Result<u16, Error> {
        // The bound is a whole hundred, so that a person can read the message.
        let lowest = libm::ceilf(self.pwm_clock_hz / (4.0 * 32_767.0) / 100.0) * 100.0;
        let allowed = Allowed::Between(lowest, self.pwm_clock_hz / 32.0);
        if !allowed.includes(pwm_hz) {
            return Err(Error { key: PWM_HZ, found: pwm_hz, allowed });
        }
        Ok((libm::roundf(self.pwm_clock_hz / (4.0 * pwm_hz)) as u16).clamp(1, 32_767) * 2)
    }

    /// Refuses a sample time and a dead time (s) that the timers cannot make. A shorter dead time
    /// than was asked for would let both switches of a half-bridge conduct at once.
    ///
    /// # Errors
    /// Names the value.
    pub(crate) fn check_times(&self, sample_time: f32, dead_time: f32) -> Result<(), Error> {
        let [shortest, longest] = self.sample_time;
        between(SAMPLE_TIME, sample_time, shortest, longest)?;
        between(DEAD_TIME, dead_time, 0.0, self.dead_time_max)
    }
}
