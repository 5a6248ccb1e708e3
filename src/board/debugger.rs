//! The debugger: what goes on while it halts the core (RM0090, DBGMCU).
//!
//! A breakpoint must not leave the motor at its last duty. Two bits see to it, and debuggers change
//! them: OpenOCD, for one, stops both watchdogs with the core. So the task that feeds the watchdog
//! sets them again each time.
//!
//! - The watchdogs run on, and reset the part (`DBG_IWDG_STOP`, `DBG_WWDG_STOP` clear).
//! - TIM1 stops with the core (`DBG_TIM1_STOP` set). Its outputs are then disabled as if `MOE` were
//!   clear (RM0090, 17.3.21), at once: low in the modes of a bridge, let go before an analog
//!   amplifier (`output_control.rs`). The enable pin stays high until the watchdog's reset.
//!
//! The emulated part stores the bits, and cannot be halted so: the halt is on the form of
//! docs/reference/wiring.md.

use stm32f4xx_hal::pac;

/// The bits that say what stops with the core.
pub struct FreezeBits {
    registers: pac::DBGMCU,
}

impl FreezeBits {
    /// Takes the registers.
    pub const fn new(registers: pac::DBGMCU) -> Self {
        Self { registers }
    }

    /// Sets the bits, whatever a debugger has made of them. Those of other timers stay as they are.
    #[inline]
    pub fn set(&self) {
        self.registers
            .apb1_fz()
            .modify(|_, w| w.dbg_iwdg_stop().clear_bit().dbg_wwdg_stop().clear_bit());
        self.registers.apb2_fz().modify(|_, w| w.dbg_tim1_stop().set_bit());
    }
}
