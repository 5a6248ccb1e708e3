//! The stopwatch: a free-running counter for the control task's deadline, on TIM5, 32 bits.
//!
//! The processor's own cycle counter is unsuitable. It stands still while the processor sleeps, and
//! the processor sleeps between two ticks: a late tick would look early. A timer keeps counting.

use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// Counter of the clock of the timers on APB1: 84 MHz, or the internal 16 MHz without the PLL.
pub struct Stopwatch {
    timer: pac::TIM5,
}

impl Stopwatch {
    /// Starts the counter at zero.
    pub fn start(timer: pac::TIM5, rcc: &mut Rcc) -> Self {
        pac::TIM5::enable(rcc);
        pac::TIM5::reset(rcc);
        timer.arr().write(|w| w.set(u32::MAX));
        timer.cr1().write(|w| w.cen().enabled());
        Self { timer }
    }

    /// Returns the counter's reading, clocks. It wraps after 51 s.
    #[inline]
    pub fn now(&self) -> u32 {
        self.timer.cnt().read().bits()
    }
}
