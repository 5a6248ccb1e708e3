//! The registers of the reset's flags and of the option bytes; [`super::reset_cause`] defines their
//! meaning.

use stm32f4xx_hal::pac;

use super::reset_cause::{BrownOut, ResetCause};

/// Reads the cause of the last reset, and clears its flags for the next time.
pub fn take_cause(rcc: &pac::RCC) -> ResetCause {
    let flags = rcc.csr().read().bits();
    rcc.csr().modify(|_, w| w.rmvf().clear());
    ResetCause::of(flags)
}

/// Reads the level of the brown-out reset.
pub fn brown_out(flash: &pac::FLASH) -> BrownOut {
    BrownOut::of(flash.optcr().read().bits())
}
