//! The encoder: quadrature on TIM2, PA0 and PA1. The counter has 32 bits, and every edge counts, in
//! both directions.

use stm32f4xx_hal::gpio::{Alternate, PA0, PA1, Pull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::traits::EncoderInput;

/// The counter of the encoder's edges.
pub struct Quadrature {
    timer: pac::TIM2,
    pins: (PA0<Alternate<1>>, PA1<Alternate<1>>),
    pulls_down: bool,
}

/// The input filter `ICxF`: an edge counts when 8 samples at 84 MHz agree. Spikes of the bridge
/// below 95 ns do not count; up to 5 million edges a second do.
const FILTER: u8 = 0b0011;

impl Quadrature {
    /// Starts counting at zero.
    pub fn start(
        timer: pac::TIM2,
        a: PA0<Alternate<1>>,
        b: PA1<Alternate<1>>,
        rcc: &mut Rcc,
    ) -> Self {
        pac::TIM2::enable(rcc);
        pac::TIM2::reset(rcc);
        timer.arr().write(|w| w.set(u32::MAX));
        timer
            .ccmr1_input()
            .write(|w| w.cc1s().ti1().ic1f().set(FILTER).cc2s().ti2().ic2f().set(FILTER));
        timer.smcr().write(|w| w.sms().encoder_mode_3());
        timer.cr1().write(|w| w.cen().enabled());
        Self { timer, pins: (a, b), pulls_down: false }
    }
}

impl EncoderInput for Quadrature {
    fn counter(&self) -> u32 {
        self.timer.cnt().read().bits()
    }

    fn lines(&self) -> u8 {
        // SAFETY: a read without an effect, of a port that the parts share.
        unsafe { (*pac::GPIOA::ptr()).idr().read().bits() as u8 & 0b11 }
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
