//! 168 MHz from the 8 MHz crystal, or 16 MHz from the internal oscillator if there is none.
//!
//! The HAL waits for the crystal for ever, so it is started here first, with a bounded wait. Once it runs, the clock
//! security system watches it: if it stops, the part falls back to the internal oscillator, TIM1's break input turns
//! the outputs off, and [`super::fatal`] tells it after a reset.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

/// How long the crystal may take, in cycles of the internal 16 MHz: 50 ms. Data sheet: 2 ms, typically.
const PATIENCE: u32 = 16_000_000 / 20;

/// The part was started on the crystal.
static RAN: AtomicBool = AtomicBool::new(false);

/// Sets up the clocks; the cycle counter must be running. Also says whether the crystal runs.
pub fn start(rcc: pac::RCC) -> (Rcc, bool) {
    rcc.cr().modify(|_, w| w.hseon().on());
    let begin = DWT::cycle_count();
    let runs = loop {
        if rcc.cr().read().hserdy().is_ready() {
            break true;
        }
        if DWT::cycle_count().wrapping_sub(begin) > PATIENCE {
            break false;
        }
    };
    if !runs {
        rcc.cr().modify(|_, w| w.hseon().off());
        return (rcc.freeze(Config::hsi()), false);
    }
    let config = Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz());
    let rcc = rcc.freeze(config);
    rcc.cr().modify(|_, w| w.csson().on());
    RAN.store(true, Ordering::Relaxed);
    (rcc, true)
}

/// Whether the part was started on the crystal and has fallen back to the internal oscillator.
pub fn has_lost_crystal() -> bool {
    // SAFETY: reads a status register, which changes nothing.
    let rcc = unsafe { &*pac::RCC::ptr() };
    rcc.cfgr().read().sws().is_hsi() && RAN.load(Ordering::Relaxed)
}
