//! The board with its STM32F405RG: everything that accesses a register or a pin.
//!
//! `docs/reference/wiring.md` has the pins. Each part is one module. The control task uses the
//! parts through the traits of [`traits`], since embedded-hal has none for an encoder, a bridge or
//! a watchdog.

#[cfg(feature = "two-encoders")]
pub mod absolute_encoder;
pub mod brake_resistor;
pub mod bridge;
pub mod clock;
pub mod control_task;
pub mod converter;
mod copy;
pub mod crystal;
pub mod current_loop;
pub mod debugger;
pub mod encoder;
pub mod fatal;
mod hard_fault;
pub mod last_tick;
pub mod liveness;
pub mod machine;
mod note;
pub mod ntc;
mod option_bytes;
mod output_control;
mod receive_ring;
pub mod report;
pub mod reset;
pub mod reset_cause;
pub mod retained;
pub mod sectors;
pub mod setup;
pub mod stopwatch;
pub mod tick;
pub mod traits;
pub mod usart;
pub mod voltage_detector;
pub mod watchdog;

use stiction::Hardware;

/// The figures of this board: TIM1 is clocked at 168 MHz (`clock.rs`), the converter has 12 bits,
/// and the longest dead time is 1008 clocks of TIM1 (`output_control.rs`). TIM3, its prescaler, the
/// deadline and the watchdog support ticks of 50 Hz to 10 kHz.
pub const HARDWARE: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};
