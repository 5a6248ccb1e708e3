//! The control tick: TIM3's update, 50 Hz to 10 kHz.

use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// The timer of the control tick.
pub struct TickTimer {
    timer: pac::TIM3,
}

/// The period of the ticks: a sample time, in units of the timer.
#[derive(Clone, Copy)]
pub struct Period {
    /// Length of the period, clocks of the timers on APB1; the stopwatch counts the same clock.
    pub clocks: u32,
    divider: u32,
}

impl Period {
    /// Returns the period of a sample time (s) at a clock (Hz).
    pub fn new(sample_time: f32, clock: u32) -> Self {
        let clocks = libm::roundf(sample_time * clock as f32) as u32;
        Self { clocks, divider: divider(clocks) }
    }
}

impl TickTimer {
    /// Starts the timer. Its interrupt waits until the tasks run.
    pub fn start(timer: pac::TIM3, period: &Period, rcc: &mut Rcc) -> Self {
        pac::TIM3::enable(rcc);
        pac::TIM3::reset(rcc);
        timer.dier().write(|w| w.uie().enabled());
        let mut this = Self { timer };
        this.set(period);
        this
    }

    /// Begins a period, which the timer then repeats with the same length.
    pub fn set(&mut self, period: &Period) {
        let Period { clocks, divider } = *period;
        let timer = &self.timer;
        // The update that loads the prescaler is not a tick.
        timer.cr1().write(|w| w.urs().counter_only());
        timer.psc().write(|w| w.psc().set((divider - 1) as u16));
        timer.arr().write(|w| w.arr().set(((clocks + divider / 2) / divider - 1) as u16));
        timer.egr().write(|w| w.ug().set_bit());
        timer.sr().write(|w| w.uif().clear_bit());
        timer.cr1().write(|w| w.urs().counter_only().cen().enabled());
    }

    /// Stops the ticks until the next [`set`](Self::set).
    pub fn stop(&mut self) {
        self.timer.cr1().write(|w| w.urs().counter_only());
    }

    /// Acknowledges a tick.
    #[inline]
    pub fn acknowledge(&mut self) {
        self.timer.sr().write(|w| w.uif().clear_bit());
    }
}

/// Returns the smallest prescaler with which the period fits 16 bits. If one nearby divides the
/// period exactly, it returns that one: 20 ms is then 20 ms, not 6 ppm off.
fn divider(clocks: u32) -> u32 {
    let smallest = clocks / 65_536 + 1;
    (smallest..smallest + 32).find(|divider| clocks.is_multiple_of(*divider)).unwrap_or(smallest)
}
