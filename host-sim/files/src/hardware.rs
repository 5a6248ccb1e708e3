//! The board that the simulator stands in for.

use stiction::Hardware;

/// The STM32F405 as `src/board` sets it up: TIM1 at 168 MHz, a converter of 12 bits. The image's
/// duties are compared bit for bit with those that the host computes of these.
pub const STM32F405: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};
