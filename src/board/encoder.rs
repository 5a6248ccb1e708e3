//! The encoders: quadrature on TIM2 (PA0 and PA1, with the index on PA2) and, with the feature
//! `two-encoders`, on TIM4 (PB6 and PB7). Every edge counts, in both directions.
//!
//! The counter of TIM2 has 32 bits. That of TIM4 has 16, and is extended to 32 at each reading. It
//! must be read before the encoder has travelled by 32 768 counts: 33 million counts a second at a
//! sample time of 1 ms, 1.6 million at 20 ms. While a sector of the flash is erased, nothing is
//! read for seconds: the servo then judges the load's travel by that of the motor.

use stiction::servo::Input;
use stm32f4xx_hal::gpio::{Alternate, Pull};
use stm32f4xx_hal::gpio::{PA0, PA1, PA2};
#[cfg(feature = "two-encoders")]
use stm32f4xx_hal::gpio::{PB6, PB7};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::traits::{EncoderInput, IndexInput};

/// The input filter `ICxF`: an edge counts when 8 samples at 84 MHz agree. Spikes of the bridge
/// below 95 ns do not count; up to 5 million edges a second do.
const FILTER: u8 = 0b0011;

/// Defines the counter of an encoder's edges: its timer, its two pins with their alternate
/// function, their port with the number of the first of them and the other pins that are read with
/// them, and how a reading becomes a number of 32 bits.
macro_rules! quadrature {
    (
        $(#[$doc:meta])* $Quadrature:ident,
        $TIM:ident, $A:ident, $B:ident, $function:literal,
        $GPIO:ident from $first:literal with $more:expr,
        |$before:ident, $now:ident| $extended:expr
    ) => {
        $(#[$doc])*
        pub struct $Quadrature {
            timer: pac::$TIM,
            pins: ($A<Alternate<$function>>, $B<Alternate<$function>>),
            pulls_down: bool,
            /// The last reading.
            counter: u32,
        }

        impl $Quadrature {
            /// Starts counting at zero.
            pub fn start(
                timer: pac::$TIM,
                a: $A<Alternate<$function>>,
                b: $B<Alternate<$function>>,
                rcc: &mut Rcc,
            ) -> Self {
                pac::$TIM::enable(rcc);
                pac::$TIM::reset(rcc);
                // SAFETY: any number is a valid end of the count; a counter of 16 bits ignores the
                // rest.
                timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
                timer
                    .ccmr1_input()
                    .write(|w| w.cc1s().ti1().ic1f().set(FILTER).cc2s().ti2().ic2f().set(FILTER));
                timer.smcr().write(|w| w.sms().encoder_mode_3());
                timer.cr1().write(|w| w.cen().enabled());
                Self { timer, pins: (a, b), pulls_down: false, counter: 0 }
            }
        }

        impl EncoderInput for $Quadrature {
            #[inline]
            fn counter(&mut self) -> u32 {
                let ($before, $now) = (self.counter, self.timer.cnt().read().bits());
                self.counter = $extended;
                self.counter
            }

            #[inline]
            fn lines(&self) -> u8 {
                // SAFETY: a read without an effect. Other parts use other pins of the port.
                let levels = unsafe { (*pac::$GPIO::ptr()).idr().read().bits() };
                (levels >> $first) as u8 & (0b11 | $more)
            }

            #[inline]
            fn pull(&mut self, down: bool) {
                if self.pulls_down != down {
                    self.pulls_down = down;
                    let resistor = if down { Pull::Down } else { Pull::Up };
                    self.pins.0.set_internal_resistor(resistor);
                    self.pins.1.set_internal_resistor(resistor);
                }
            }
        }
    };
}

quadrature! {
    /// The counter of the encoder: of two, that of the motor. With its lines, the inputs of the
    /// emergency stop (PA6) and of the homing switch (PA7) are read.
    Quadrature, TIM2, PA0, PA1, 1,
    GPIOA from 0 with Input::CONTACT | Input::SWITCH, |_before, now| now
}

/// The index is on PA2. Its filter is that of the lines, so that both have the same delay.
impl IndexInput for Quadrature {
    type Pin = PA2<Alternate<1>>;

    fn capture_index(&self, _pin: &Self::Pin) {
        self.timer.ccmr2_input().write(|w| w.cc3s().ti3().ic3f().set(FILTER));
        self.timer.ccer().write(|w| w.cc3e().set_bit());
    }

    /// The flag of an over-capture stays set, and has no effect.
    fn index(&self) -> Option<u32> {
        let has_passed = self.timer.sr().read().cc3if().bit_is_set();
        // The reading clears the flag.
        has_passed.then(|| self.timer.ccr3().read().bits())
    }
}

#[cfg(feature = "two-encoders")]
quadrature! {
    /// The counter of the load's encoder.
    LoadQuadrature, TIM4, PB6, PB7, 2, GPIOB from 6 with 0, |before, now| {
        let travel = (now as u16).wrapping_sub(before as u16) as i16;
        before.wrapping_add_signed(i32::from(travel))
    }
}
