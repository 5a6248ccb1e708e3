//! The control tick: TIM3's update, 50 Hz to 10 kHz.

use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// The timer of the control tick.
pub struct TickTimer {
    timer: pac::TIM3,
}

impl TickTimer {
    /// Prepares a tick of `sample_time` (s); the interrupt waits until the tasks run.
    pub fn start(timer: pac::TIM3, sample_time: f32, rcc: &mut Rcc) -> Self {
        pac::TIM3::enable(rcc);
        pac::TIM3::reset(rcc);
        let clock = rcc.clocks.timclk1().raw();
        let clocks = libm::roundf(sample_time * clock as f32) as u32;
        let divider = divider(clocks);
        timer.psc().write(|w| w.psc().set((divider - 1) as u16));
        timer.arr().write(|w| w.arr().set(((clocks + divider / 2) / divider - 1) as u16));
        timer.egr().write(|w| w.ug().set_bit());
        timer.sr().write(|w| w.uif().clear_bit());
        timer.dier().write(|w| w.uie().enabled());
        timer.cr1().write(|w| w.cen().enabled());
        Self { timer }
    }

    /// Acknowledges a tick.
    #[inline]
    pub fn acknowledge(&mut self) {
        self.timer.sr().write(|w| w.uif().clear_bit());
    }
}

/// The smallest prescaler that leaves 16 bits, and if one nearby divides the period exactly, that one: 20 ms is then
/// 20 ms, not 6 ppm off.
fn divider(clocks: u32) -> u32 {
    let smallest = clocks / 65_536 + 1;
    (smallest..smallest + 32).find(|divider| clocks.is_multiple_of(*divider)).unwrap_or(smallest)
}
