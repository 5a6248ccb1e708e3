//! The reset's flags and the option bytes, as the registers have them; [`super::reset_cause`] says
//! what they mean.

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
