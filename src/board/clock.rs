//! The clocks: 168 MHz from a crystal of 8, 12, 16 or 25 MHz, or from the internal oscillator if
//! there is none of these.
//!
//! ```text
//! crystal, or 16 MHz -> / PLLM -> PLL -> 168 MHz processor, timers of APB2
//!                                         84 MHz timers of APB1, USART1
//! ```
//!
//! The HAL waits for the crystal forever, so the crystal is started here first, with a bounded
//! wait. Its frequency is measured against the internal oscillator before anything runs from it,
//! the PLL included ([`super::crystal`]). The measured frequency sets PLLM. Once the
//! microcontroller runs from the crystal, the clock security system watches the crystal. If the
//! crystal stops, the microcontroller falls back to the internal oscillator, TIM1's break input
//! turns the outputs off, and [`super::fatal`] reports the fault after a reset.
//!
//! Without a usable crystal the joint cannot be armed, and the PLL multiplies the internal
//! oscillator. The link's rate then has the error of that oscillator and no other
//! (docs/reference/faults.md states it), so that a person can read what is wrong.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::pac::rcc::pllcfgr::PLLSRC;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

use super::crystal::{CAPTURES, Crystal, DIVIDER};

/// Frequency of the internal oscillator, MHz.
const INTERNAL_MHZ: u8 = 16;

/// Time that the crystal may take to start, cycles of the internal 16 MHz: 50 ms. Data sheet: 2 ms,
/// typically.
const PATIENCE: u32 = 16_000_000 / 20;

/// Time that the PLL may take to lock, cycles of the internal 16 MHz: 1 ms. Data sheet: 300 us at
/// most.
const PLL_PATIENCE: u32 = 16_000;

/// Time that a capture of the crystal may take, cycles of the internal 16 MHz: 10 ms. At 8 MHz it
/// takes 31 us.
const CAPTURE_PATIENCE: u32 = 160_000;

/// Whether the microcontroller was started on the crystal.
static RAN: AtomicBool = AtomicBool::new(false);

/// Sets up the clocks, and returns the state of the crystal. The cycle counter must be running. The
/// timer measures the crystal, and is reset afterwards.
pub fn start(rcc: pac::RCC, timer: &pac::TIM11) -> (Rcc, Crystal) {
    let crystal = if oscillates(&rcc) {
        Crystal::of(measure(&rcc, timer)).with_pll(|mhz| pll_locks(&rcc, PLLSRC::Hse, mhz))
    } else {
        Crystal::Absent
    };
    let config = if let Some(mhz) = crystal.mhz() {
        Config::hse(u32::from(mhz).MHz())
    } else {
        rcc.cr().modify(|_, w| w.hseon().off());
        if !pll_locks(&rcc, PLLSRC::Hsi, INTERNAL_MHZ) {
            // The HAL would wait for this PLL forever.
            return (rcc.freeze(Config::hsi()), crystal);
        }
        Config::hsi()
    };
    let rcc = rcc.freeze(config.sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz()));
    if crystal.mhz().is_some() {
        rcc.cr().modify(|_, w| w.csson().on());
        RAN.store(true, Ordering::Relaxed);
    }
    (rcc, crystal)
}

/// Measures the crystal, and returns the counts of the internal oscillator in [`CAPTURES`]
/// captures; none if a capture does not come in time, or has been missed.
fn measure(rcc: &pac::RCC, timer: &pac::TIM11) -> Option<u32> {
    // SAFETY: any divider from 2 to 31; the real-time clock, which it is for, does not run.
    rcc.cfgr().modify(|_, w| unsafe { w.rtcpre().bits(DIVIDER) });
    rcc.apb2enr().modify(|_, w| w.tim11en().enabled());
    // The timer's clock has to arrive before the timer is written.
    cortex_m::asm::dsb();
    // SAFETY: input 2 is the divided crystal.
    timer.or().write(|w| unsafe { w.rmp().bits(2) });
    timer.ccmr1_input().write(|w| w.cc1s().ti1().ic1psc().eight_events());
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().enabled());
    let capture = || timer.ccr1().read().ccr().bits();
    let mut last = capture();
    let mut counts = 0;
    let mut captured = Some(0);
    for index in 0..=CAPTURES {
        // Two captures in a row are never alike: that would be a crystal of 61 kHz.
        if !within(CAPTURE_PATIENCE, || capture() != last) || timer.sr().read().cc1of().bit_is_set()
        {
            captured = None;
            break;
        }
        let now = capture();
        // The first capture has none before it.
        if index > 0 {
            counts += u32::from(now.wrapping_sub(last));
            captured = Some(counts);
        }
        last = now;
    }
    rcc.apb2rstr().modify(|_, w| w.tim11rst().set_bit());
    rcc.apb2rstr().modify(|_, w| w.tim11rst().clear_bit());
    rcc.apb2enr().modify(|_, w| w.tim11en().disabled());
    // SAFETY: no clock.
    rcc.cfgr().modify(|_, w| unsafe { w.rtcpre().bits(0) });
    captured
}

/// Starts the crystal, and returns whether its ready flag is set in time.
fn oscillates(rcc: &pac::RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().on());
    within(PATIENCE, || rcc.cr().read().hserdy().is_ready())
}

/// Tries to lock the PLL once on its source of `mhz` (MHz), and returns whether it locks. The ready
/// flag of the crystal only counts pulses, and can be set for a crystal that stops again. After
/// this test, the lock that the HAL waits for has been observed once.
fn pll_locks(rcc: &pac::RCC, source: PLLSRC, mhz: u8) -> bool {
    // SAFETY: 1 MHz * 192 is within the range of the oscillator in the PLL; nothing runs from it
    // yet.
    rcc.pllcfgr().write(|w| unsafe {
        w.pllsrc().variant(source).pllm().bits(mhz).plln().bits(192).pllp().div8().pllq().bits(4)
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    let locks = within(PLL_PATIENCE, || rcc.cr().read().pllrdy().is_ready());
    rcc.cr().modify(|_, w| w.pllon().off());
    locks && within(PLL_PATIENCE, || rcc.cr().read().pllrdy().is_not_ready())
}

/// Returns whether `happens` returns true within `cycles` cycles of the processor.
fn within(cycles: u32, happens: impl Fn() -> bool) -> bool {
    let begin = DWT::cycle_count();
    while !happens() {
        if DWT::cycle_count().wrapping_sub(begin) > cycles {
            return false;
        }
    }
    true
}

/// Returns whether the microcontroller was started on the crystal and has fallen back to the
/// internal oscillator.
pub fn has_lost_crystal() -> bool {
    // SAFETY: reads a status register, which changes nothing.
    let rcc = unsafe { &*pac::RCC::ptr() };
    rcc.cfgr().read().sws().is_hsi() && RAN.load(Ordering::Relaxed)
}
