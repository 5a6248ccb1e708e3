//! The board that the simulator models.

use stiction::Hardware;

/// The STM32F405 as `src/board` configures it: TIM1 at 168 MHz, a converter of 12 bits. Duties of
/// the image are compared bit for bit with those that the host computes from these values.
pub const STM32F405: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};
