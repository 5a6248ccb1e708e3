//! The debugger: peripherals that run on, or stop, while it halts the core (RM0090, DBGMCU).
//!
//! A breakpoint must not leave the motor at its last duty. The bits below prevent that, and
//! debuggers change them: OpenOCD, for one, stops both watchdogs with the core. So the task that
//! feeds the watchdog sets the bits again each time.
//!
//! - The watchdogs run on, and reset the microcontroller (`DBG_IWDG_STOP`, `DBG_WWDG_STOP` clear).
//! - TIM1 stops with the core (`DBG_TIM1_STOP` set). Its outputs are then disabled as if `MOE` were
//!   clear (RM0090, 17.3.21), at once: low in the modes of a bridge, released with an analog
//!   amplifier (`output_control.rs`). The enable pin stays high until the watchdog's reset.
//! - TIM8 stops with the core as well (`DBG_TIM8_STOP` set): the brake resistor's output is low.
//!
//! The emulated microcontroller only stores the bits and cannot be halted in this way: the form in
//! docs/reference/wiring.md has a test of the halt.

use stm32f4xx_hal::pac;

/// Bits that define which peripherals stop with the core.
pub struct FreezeBits {
    registers: pac::DBGMCU,
}

impl FreezeBits {
    /// Makes the bits from their registers.
    pub const fn new(registers: pac::DBGMCU) -> Self {
        Self { registers }
    }

    /// Sets the bits, whatever a debugger has set. The bits of other timers are unchanged.
    #[inline]
    pub fn set(&self) {
        self.registers
            .apb1_fz()
            .modify(|_, w| w.dbg_iwdg_stop().clear_bit().dbg_wwdg_stop().clear_bit());
        self.registers
            .apb2_fz()
            .modify(|_, w| w.dbg_tim1_stop().set_bit().dbg_tim8_stop().set_bit());
    }
}
