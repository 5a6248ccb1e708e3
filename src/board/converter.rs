//! The converter ADC1: the supply voltage on PC0 and the motor's current on PC1.
//!
//! ```text
//! TIM1   /\    /\    /\    the PWM is centre-aligned
//!       /  \  /  \  /  \
//!      /    \/    \/    \
//!         ^     ^     ^     TRGO at the upper end, one count before: converts the current (PC1)
//! ```
//!
//! The current is converted once a period of the PWM, at the upper end of the timer's count: the
//! current of a motor ripples around its mean, and passes it there. The timer starts the conversion
//! (injected group, TIM1_TRGO), so no task waits and none takes time for it. A tick reads the last
//! one. While the bridge is on, the converter's own watchdog compares every conversion with the
//! limits of the current, and its interrupt turns the bridge off. The interrupt is above the
//! control task, which it interrupts.
//!
//! If the effort is a current, the end of every conversion is an interrupt as well, which runs the
//! [current loop](super::current_loop).
//!
//! The supply is converted once a tick (regular group), and read at the next one. A conversion of
//! the current restarts it.
//!
//! Not measured on hardware: noise of the switching bridge at the instant of the conversion.

use stm32f4xx_hal::gpio::{Analog, PC0, PC1};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::bridge;

/// Channels of PC0 and PC1.
const SUPPLY: u8 = 10;
const CURRENT: u8 = 11;

/// TIM1_TRGO as the trigger of the injected group (`JEXTSEL`), and its rising edge (`JEXTEN`):
/// RM0090, table "External trigger for injected channels".
const TIM1_TRGO: u8 = 0b0001;

/// The converter of supply voltage and motor current.
pub struct Converter {
    adc: pac::ADC1,
    _pins: (PC0<Analog>, PC1<Analog>),
    is_guarded: bool,
}

impl Converter {
    /// Sets the converter up, and begins the first conversion of the supply.
    pub fn start(adc: pac::ADC1, pins: (PC0<Analog>, PC1<Analog>), rcc: &mut Rcc) -> Self {
        pac::ADC1::enable(rcc);
        pac::ADC1::reset(rcc);
        // 84 MHz / 4: the converter takes 36 MHz at most.
        // SAFETY: one field of the register that is common to the converters, none of which is
        // used elsewhere.
        unsafe { (*pac::ADC_COMMON::ptr()).ccr().modify(|_, w| w.adcpre().div4()) };
        // Sampling times of 144 clocks, 7 us, for a divider of up to 50 kOhm, and of 15 clocks, 0.7
        // us, for an amplifier.
        adc.smpr1().modify(|_, w| w.smp10().cycles144().smp11().cycles15());
        // SAFETY: 10 is a channel of this converter; the length field 0 means one conversion.
        adc.sqr3().write(|w| unsafe { w.sq1().bits(SUPPLY) });
        // SAFETY: 11 is a channel of this converter. With the length field 0, the group is the last
        // of its four places.
        adc.jsqr().write(|w| unsafe { w.jsq4().bits(CURRENT) });
        // The watchdog judges this channel of the injected group alone. Its limits are the whole
        // range until the bridge is on.
        // SAFETY: 11 is a channel of this converter.
        adc.cr1()
            .write(|w| unsafe { w.jawden().set_bit().awdsgl().set_bit().awdch().bits(CURRENT) });
        // SAFETY: the value is one of the table of triggers.
        adc.cr2().write(|w| unsafe { w.jextsel().bits(TIM1_TRGO).adon().enabled() });
        let converter = Self { adc, _pins: pins, is_guarded: false };
        converter.begin();
        converter
    }

    fn begin(&self) {
        self.adc.cr2().modify(|_, w| w.swstart().start());
    }

    /// Returns the reading of the supply whose conversion the last call has begun, and begins the
    /// next one.
    #[inline]
    pub fn supply(&mut self) -> u16 {
        let reading = self.adc.dr().read().data().bits();
        self.begin();
        reading
    }

    /// Returns the reading that the next call of [`supply`](Self::supply) returns, once its
    /// conversion is over.
    #[inline]
    pub fn last_supply(&self) -> u16 {
        self.adc.dr().read().data().bits()
    }

    /// Returns the last reading of the motor's current.
    #[inline]
    pub fn current(&self) -> u16 {
        self.adc.jdr1().read().jdata().bits()
    }

    /// Starts or ends the conversions of the current. Each one restarts a running conversion of the
    /// supply, so a board without a sensor has none.
    pub fn sense(&mut self, is_on: bool) {
        self.release();
        self.adc.cr2().modify(|_, w| match is_on {
            true => w.jexten().rising_edge(),
            false => w.jexten().disabled(),
        });
    }

    /// Starts the watchdog over the current: a reading below the first limit or above the second
    /// turns the bridge off. `is_regulated` starts the interrupts of the current loop, too.
    #[inline(never)]
    pub fn guard(&mut self, [low, high]: [u16; 2], is_regulated: bool) {
        self.adc.ltr().write(|w| w.lt().set(low));
        self.adc.htr().write(|w| w.ht().set(high));
        // A conversion before the limits were written may have set the flags.
        self.adc.sr().write(|w| w.awd().clear_bit().jeoc().clear_bit());
        self.is_guarded = true;
        self.adc.cr1().modify(|_, w| w.awdie().set_bit().jeocie().bit(is_regulated));
    }

    /// Ends the interrupts of the current loop. The watchdog over the current stays on.
    pub fn end_loop(&mut self) {
        self.adc.cr1().modify(|_, w| w.jeocie().clear_bit());
    }

    /// Ends the watchdog over the current.
    #[inline]
    pub fn release(&mut self) {
        if self.is_guarded {
            self.is_guarded = false;
            self.adc.cr1().modify(|_, w| w.awdie().clear_bit().jeocie().clear_bit());
        }
    }
}

/// If the current is beyond its limits, turns the bridge off and returns the reading. The
/// converter's interrupt calls this, and is then disabled until the next [`Converter::guard`].
#[inline]
pub fn over_current() -> Option<u16> {
    // SAFETY: only the control task changes these registers, which this interrupts; what it
    // overwrites are the enable bits of this interrupt, which the next tick clears again.
    let adc = unsafe { &*pac::ADC1::ptr() };
    if adc.sr().read().awd().bit_is_clear() {
        return None;
    }
    bridge::off_now();
    adc.cr1().modify(|_, w| w.awdie().clear_bit().jeocie().clear_bit());
    adc.sr().write(|w| w.awd().clear_bit().jeoc().clear_bit());
    Some(adc.jdr1().read().jdata().bits())
}

/// Acknowledges a conversion of the current, and returns its reading.
#[inline]
pub fn take_conversion() -> u16 {
    // SAFETY: the flag belongs to the interrupt that calls this; the reading is only read.
    let adc = unsafe { &*pac::ADC1::ptr() };
    adc.sr().write(|w| w.jeoc().clear_bit());
    adc.jdr1().read().jdata().bits()
}
