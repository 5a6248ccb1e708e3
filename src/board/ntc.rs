//! The motor's NTC on PC2, with the converter ADC2. The converter of supply and current has no time
//! between two ticks that nothing restarts.
//!
//! The task of the log begins a conversion after each tick, and takes that of the tick before: the
//! control tick has no part in it. Without an NTC in the parameters the reading is not used.
//!
//! Not measured on hardware.

use stm32f4xx_hal::gpio::{Analog, PC2};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// Channel of PC2.
const NTC: u8 = 12;

/// The input of the motor's NTC.
pub struct NtcInput {
    adc: pac::ADC2,
    _pin: PC2<Analog>,
}

impl NtcInput {
    /// Sets the converter up, and begins a conversion. Its clock is that of
    /// [`Converter`](super::converter::Converter), which has to be set up before.
    pub fn start(adc: pac::ADC2, pin: PC2<Analog>, rcc: &mut Rcc) -> Self {
        pac::ADC2::enable(rcc);
        // No reset: one line resets all converters of the part, that of the supply included.
        // 480 clocks of 21 MHz, 23 us, for a divider of up to 100 kOhm.
        adc.smpr1().modify(|_, w| w.smp12().cycles480());
        // SAFETY: 12 is a channel of this converter; the length field 0 means one conversion.
        adc.sqr3().write(|w| unsafe { w.sq1().bits(NTC) });
        adc.cr2().write(|w| w.adon().enabled());
        let input = Self { adc, _pin: pin };
        input.begin();
        input
    }

    fn begin(&self) {
        self.adc.cr2().modify(|_, w| w.swstart().start());
    }

    /// Returns the reading whose conversion the last call has begun, and begins the next one.
    pub fn reading(&mut self) -> u16 {
        let reading = self.adc.dr().read().data().bits();
        self.begin();
        reading
    }
}
