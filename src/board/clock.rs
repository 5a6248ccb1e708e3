//! The clocks: 168 MHz from the 8 MHz crystal, or 16 MHz from the internal oscillator if there is
//! none.
//!
//! The HAL waits for the crystal for ever, so the crystal is started here first, with a bounded
//! wait. Once it runs, the clock security system watches it. If it stops, the part falls back to
//! the internal oscillator, TIM1's break input turns the outputs off, and [`super::fatal`] tells of
//! it after a reset.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

/// Time that the crystal may take to start, cycles of the internal 16 MHz: 50 ms. Data sheet: 2 ms,
/// typically.
const PATIENCE: u32 = 16_000_000 / 20;

/// Time that the PLL may take to lock, cycles of the internal 16 MHz: 1 ms. Data sheet: 300 us at
/// most.
const PLL_PATIENCE: u32 = 16_000;

/// Whether the part was started on the crystal.
static RAN: AtomicBool = AtomicBool::new(false);

/// Sets up the clocks, and returns whether the crystal runs. The cycle counter must be running.
pub fn start(rcc: pac::RCC) -> (Rcc, bool) {
    let runs = crystal_runs(&rcc);
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

/// Starts the crystal, lets the PLL lock on it once, and returns whether both went well. The ready
/// flag alone counts pulses, and can be wrong about a crystal that dies again. What the HAL waits
/// for afterwards has then been seen to happen.
fn crystal_runs(rcc: &pac::RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().on());
    if !within(PATIENCE, || rcc.cr().read().hserdy().is_ready()) {
        return false;
    }
    // SAFETY: 8 MHz / 8 * 192 is within the range of the oscillator in the PLL; nothing runs from
    // it yet.
    rcc.pllcfgr().write(|w| unsafe {
        w.pllsrc().hse().pllm().bits(8).plln().bits(192).pllp().div8().pllq().bits(4)
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    let locks = within(PLL_PATIENCE, || rcc.cr().read().pllrdy().is_ready());
    rcc.cr().modify(|_, w| w.pllon().off());
    locks && within(PLL_PATIENCE, || rcc.cr().read().pllrdy().is_not_ready())
}

/// Returns whether something happens within so many cycles.
fn within(cycles: u32, happens: impl Fn() -> bool) -> bool {
    let begin = DWT::cycle_count();
    while !happens() {
        if DWT::cycle_count().wrapping_sub(begin) > cycles {
            return false;
        }
    }
    true
}

/// Returns whether the part was started on the crystal and has fallen back to the internal
/// oscillator.
pub fn has_lost_crystal() -> bool {
    // SAFETY: reads a status register, which changes nothing.
    let rcc = unsafe { &*pac::RCC::ptr() };
    rcc.cfgr().read().sws().is_hsi() && RAN.load(Ordering::Relaxed)
}
