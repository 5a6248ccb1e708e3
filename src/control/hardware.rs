//! Properties of a board's timers and converters, with which the core converts a user's units into
//! codes.

/// Properties of a board's timers and converters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardware {
    /// Clock of the timer that generates the PWM, Hz.
    pub pwm_clock_hz: f32,
    /// Largest reading of the converter that measures the supply.
    pub supply_top: u16,
    /// Longest dead time that the timer inserts between complementary outputs, s.
    pub dead_time_max: f32,
    /// Shortest and longest time between samples, s: the range for which the tick's timer and its
    /// deadline are made.
    pub sample_time: [f32; 2],
}
