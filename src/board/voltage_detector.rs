//! The detector of the microcontroller's own supply (RM0090: PVD). It is read before the flash is
//! erased or written, which requires 2.7 V at 32 bits of parallelism.
//!
//! Level 5 falls at 2.75 to 2.89 V and rises at 2.85 to 2.99 V (data sheet).

use stm32f4xx_hal::pac;

/// The level of the detector.
const LEVEL: u8 = 5;

/// Starts the detector. It is ready microseconds later.
pub fn start(rcc: &pac::RCC, power: &pac::PWR) {
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    // The clock has to arrive before the register is written.
    cortex_m::asm::dsb();
    // SAFETY: the field has three bits, and takes any level.
    power.cr().modify(|_, w| unsafe { w.pls().bits(LEVEL).pvde().set_bit() });
}

/// Returns whether the supply is too low for the flash.
pub fn is_low() -> bool {
    // SAFETY: reads a status register, which changes nothing.
    unsafe { (*pac::PWR::ptr()).csr().read().pvdo().bit_is_set() }
}
