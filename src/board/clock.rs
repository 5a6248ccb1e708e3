//! The clocks: 168 MHz from the 8 MHz crystal, or 16 MHz from the internal oscillator if there is
//! none.
//!
//! The HAL waits for the crystal for ever, so the crystal is started here first, with a bounded
//! wait. Its frequency is measured against the internal oscillator before anything runs from it,
//! the PLL included ([`super::crystal`]); another one than 8 MHz is not used. Once it runs, the
//! clock security system watches it. If it stops, the part falls back to the internal oscillator,
//! TIM1's break input turns the outputs off, and [`super::fatal`] reports it after a reset.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

use super::crystal::{CAPTURES, Crystal, DIVIDER};

/// Time that the crystal may take to start, cycles of the internal 16 MHz: 50 ms. Data sheet: 2 ms,
/// typically.
const PATIENCE: u32 = 16_000_000 / 20;

/// Time that the PLL may take to lock, cycles of the internal 16 MHz: 1 ms. Data sheet: 300 us at
/// most.
const PLL_PATIENCE: u32 = 16_000;

/// Time that a capture of the crystal may take, cycles of the internal 16 MHz: 10 ms. At 8 MHz it
/// takes 31 us.
const CAPTURE_PATIENCE: u32 = 160_000;

/// Whether the part was started on the crystal.
static RAN: AtomicBool = AtomicBool::new(false);

/// Sets up the clocks, and returns what is known of the crystal. The cycle counter must be running.
/// The timer measures the crystal, and is as after a reset afterwards.
pub fn start(rcc: pac::RCC, timer: &pac::TIM11) -> (Rcc, Crystal) {
    let crystal = if oscillates(&rcc) {
        Crystal::of(measure(&rcc, timer)).with_pll(|| pll_locks(&rcc))
    } else {
        Crystal::Absent
    };
    if !crystal.is_used() {
        rcc.cr().modify(|_, w| w.hseon().off());
        return (rcc.freeze(Config::hsi()), crystal);
    }
    let config = Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz());
    let rcc = rcc.freeze(config);
    rcc.cr().modify(|_, w| w.csson().on());
    RAN.store(true, Ordering::Relaxed);
    (rcc, crystal)
}

/// Measures the crystal, and returns the counts of the internal oscillator in [`CAPTURES`]; none if
/// a capture does not come in time, or has been missed.
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
        // What comes first has no capture before it.
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

/// Starts the crystal, and returns whether it says that it is ready.
fn oscillates(rcc: &pac::RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().on());
    within(PATIENCE, || rcc.cr().read().hserdy().is_ready())
}

/// Lets the PLL lock on the crystal once, and returns whether it does. The ready flag of the
/// crystal alone counts pulses, and can be wrong about one that dies again. What the HAL waits for
/// afterwards has then been seen to happen.
fn pll_locks(rcc: &pac::RCC) -> bool {
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

/// Returns whether the part was started on the crystal and has fallen back to the internal
/// oscillator.
pub fn has_lost_crystal() -> bool {
    // SAFETY: reads a status register, which changes nothing.
    let rcc = unsafe { &*pac::RCC::ptr() };
    rcc.cfgr().read().sws().is_hsi() && RAN.load(Ordering::Relaxed)
}
