//! The figures of a board that the core has to know: those of its timers and converters that turn a
//! user's units into codes.

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
