//! The independent watchdog.
//!
//! Its clock, the LSI oscillator, has 32 kHz typically and 17 to 47 kHz within the data sheet's limits. The slowest
//! control tick is 20 ms, and three of them may be missed before the part is reset:
//!
//! ```text
//! counts  = 60 ms * 47 kHz / 4 = 705          (prescaler 4, fastest oscillator)
//! timeout = 705 * 4 / 47 kHz = 60 ms   to   705 * 4 / 17 kHz = 166 ms;  88 ms typically
//! ```
//!
//! The new timeout is taken over by the first feed. Until then it counts the reset value, 4096 * 4 clocks: 349 to
//! 964 ms for the start, which takes 50 ms at most. It keeps running while a debugger halts the core: a breakpoint
//! must not leave the motor at its last duty.

use stm32f4xx_hal::pac;

use super::seams::Watchdog;

/// See above.
const COUNTS: u16 = 705;

/// The watchdog, running.
pub struct Independent {
    registers: pac::IWDG,
}

impl Independent {
    /// Starts it; nothing but a reset stops it.
    pub fn start(registers: pac::IWDG) -> Self {
        registers.kr().write(|w| w.key().start());
        registers.kr().write(|w| w.key().unlock());
        registers.pr().write(|w| w.pr().divide_by4());
        registers.rlr().write(|w| w.rl().set(COUNTS));
        Self { registers }
    }
}

impl Watchdog for Independent {
    #[inline]
    fn feed(&mut self) {
        self.registers.kr().write(|w| w.key().feed());
    }
}
