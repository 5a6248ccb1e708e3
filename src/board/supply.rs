//! The supply voltage on PC0, through a divider: ADC1, channel 10.
//!
//! One conversion is started each tick and read at the next one, so that no task waits.

use stm32f4xx_hal::gpio::{Analog, PC0};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// The converter of the supply voltage.
pub struct Supply {
    converter: pac::ADC1,
    _pin: PC0<Analog>,
}

impl Supply {
    /// Sets the converter up, and begins the first conversion.
    pub fn start(converter: pac::ADC1, pin: PC0<Analog>, rcc: &mut Rcc) -> Self {
        pac::ADC1::enable(rcc);
        pac::ADC1::reset(rcc);
        // 84 MHz / 4: the converter takes 36 MHz at most.
        // SAFETY: one field of the register that is common to the converters, none of which is
        // used elsewhere.
        unsafe { (*pac::ADC_COMMON::ptr()).ccr().modify(|_, w| w.adcpre().div4()) };
        // A sampling time of 144 clocks is 7 us: enough for a divider of up to 50 kOhm.
        converter.smpr1().modify(|_, w| w.smp10().cycles144());
        // SAFETY: 10 is a channel of this converter; the length field 0 means one conversion.
        converter.sqr3().write(|w| unsafe { w.sq1().bits(10) });
        converter.cr2().write(|w| w.adon().enabled());
        let supply = Self { converter, _pin: pin };
        supply.begin();
        supply
    }

    fn begin(&self) {
        self.converter.cr2().modify(|_, w| w.swstart().start());
    }

    /// Returns the reading of the conversion that the last call has begun, and begins the next
    /// conversion.
    #[inline]
    pub fn read(&mut self) -> u16 {
        let reading = self.converter.dr().read().data().bits();
        self.begin();
        reading
    }
}
