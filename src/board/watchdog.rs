//! The independent watchdog.
//!
//! Until it bites, a bridge keeps its last duty, so it waits no longer than it must: for three control ticks, and for
//! 10 ms if they are shorter. Its clock, the LSI oscillator, has 32 kHz typically and 17 to 47 kHz within the data
//! sheet's limits, so that the longest time is 47/17 of the shortest:
//!
//! ```text
//! counts = shortest * 47 kHz / 4              (prescaler 4, fastest oscillator)
//! sample time 20 ms:             705 counts, 60 ms to 166 ms;  88 ms typically
//! sample time 1 ms (to 3.3 ms):  118 counts, 10 ms to  28 ms;  15 ms typically
//! ```
//!
//! The new timeout is taken over by the first feed. Until then it counts the reset value, 4096 * 4 clocks: 349 to
//! 964 ms for the start, which takes some 55 ms at most. It keeps running while a debugger halts the core: a breakpoint
//! must not leave the motor at its last duty.

use stm32f4xx_hal::pac;

use super::seams::Watchdog;

/// Control ticks that may be missed.
const TICKS: f32 = 3.0;

/// The shortest timeout, s: a hundred times what the log may hold up a tick.
const SHORTEST: f32 = 0.010;

/// The fastest oscillator behind the prescaler, Hz.
const FASTEST: f32 = 47e3 / 4.0;

/// The watchdog, running.
pub struct Independent {
    registers: pac::IWDG,
}

impl Independent {
    /// Starts it for a loop of `sample_time` (s, up to 20 ms); nothing but a reset stops it.
    pub fn start(registers: pac::IWDG, sample_time: f32) -> Self {
        // The counter counts one more than the reload value: rounding does not make it too short.
        let counts = libm::roundf((TICKS * sample_time).max(SHORTEST) * FASTEST) as u16;
        registers.kr().write(|w| w.key().start());
        registers.kr().write(|w| w.key().unlock());
        registers.pr().write(|w| w.pr().divide_by4());
        registers.rlr().write(|w| w.rl().set(counts.min(0xFFF)));
        Self { registers }
    }
}

impl Watchdog for Independent {
    #[inline]
    fn feed(&mut self) {
        self.registers.kr().write(|w| w.key().feed());
    }
}
