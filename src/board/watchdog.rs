//! The independent watchdog.
//!
//! Until the watchdog resets the microcontroller, a bridge keeps its last duty, so the timeout is
//! as short as possible: three control ticks, or 10 ms if they are shorter. Its clock, the LSI
//! oscillator, has 32 kHz typically and 17 to 47 kHz within the data sheet's limits, so that the
//! longest time is 47/17 of the shortest:
//!
//! ```text
//! counts = shortest * 47 kHz / 4              (prescaler 4, fastest oscillator)
//! sample time 20 ms:             705 counts, 60 ms to 166 ms;  88 ms typically
//! sample time 1 ms (to 3.3 ms):  118 counts, 10 ms to  28 ms;  15 ms typically
//! ```
//!
//! The watchdog is fed only when every task that is watched has run since it was fed last: the
//! control task, without which the feeder is not woken, and the link and the log below it
//! ([`super::liveness`]). Each is woken once a tick, so all have run within a tick or two of any
//! instant.
//!
//! A new timeout takes effect at the first feed after it has crossed into the oscillator's domain.
//! The crossing takes up to [`CROSSING`]; the start does not wait for it. Until the first timeout
//! is in effect, the watchdog counts the reset value, 4096 * 4 clocks: 349 to 964 ms for the start,
//! which takes some 55 ms at most. The watchdog keeps running while a debugger halts the core: each
//! feed sets the bits for that ([`super::debugger`]).
//!
//! An erase of the flash holds up the processor for up to 4 s (data sheet). [`Timeout::ERASE`] is
//! for that:
//!
//! ```text
//! counts  = 4 s * 47 kHz / 64 = 2938        (prescaler 64, fastest oscillator, slowest erase)
//! timeout = 2938 * 64 / 47 kHz = 4.0 s   to   2938 * 64 / 17 kHz = 11.1 s
//! ```

use stm32f4xx_hal::pac;

use super::debugger::FreezeBits;
use super::traits::Watchdog;

/// Number of control ticks that may be missed.
const TICKS: f32 = 3.0;

/// The shortest timeout, s: a hundred times the longest delay of a tick by the log.
const SHORTEST: f32 = 0.010;

/// The time to wait for a timeout to be set, s.
///
/// A register takes up to five clocks of the oscillator to cross (RM0090, the status register), 0.3
/// ms. ST's own driver allows for clocks behind the prescaler instead, and so does this: six of 64
/// / 17 kHz are 23 ms. A timeout that is written while another is crossing waits for both. No real
/// part has been seen to do either.
pub const CROSSING: f32 = 0.050;

/// Frequency of the fastest oscillator, Hz.
const FASTEST: f32 = 47e3;

/// A timeout of the watchdog: the shortest time that it waits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Timeout {
    /// Number of bits by which 4 is shifted left to make the prescaler.
    shift: u8,
    counts: u16,
}

impl Timeout {
    /// The timeout for the slowest erase of a sector.
    pub const ERASE: Self = Self::of(4.0, 4);

    /// Returns the timeout of a loop of `sample_time` (s, up to 20 ms).
    pub fn of_loop(sample_time: f32) -> Self {
        Self::of((TICKS * sample_time).max(SHORTEST), 0)
    }

    const fn of(shortest: f32, shift: u8) -> Self {
        // The counter counts one more than the reload value: rounding down does not make it too
        // short.
        let counts = shortest * FASTEST / (4 << shift) as f32;
        Self { shift, counts: if counts < 4095.0 { counts as u16 } else { 4095 } }
    }
}

/// The independent watchdog, running.
pub struct Independent {
    registers: pac::IWDG,
    freeze_bits: FreezeBits,
    timeout: Timeout,
    /// The timeout that is set but not yet written.
    next: Option<Timeout>,
}

impl Independent {
    /// Starts the watchdog. Nothing but a reset stops it.
    pub fn start(registers: pac::IWDG, freeze_bits: FreezeBits, timeout: Timeout) -> Self {
        registers.kr().write(|w| w.key().start());
        freeze_bits.set();
        let mut this = Self { registers, freeze_bits, timeout, next: None };
        this.write(timeout);
        this
    }

    /// Returns the timeout that was set last, whether or not it is in effect yet.
    pub fn timeout(&self) -> Timeout {
        self.next.unwrap_or(self.timeout)
    }

    /// Sets another timeout, which takes effect at one of the next feeds.
    pub fn set(&mut self, timeout: Timeout) {
        self.next = (timeout != self.timeout).then_some(timeout);
    }

    /// Returns whether the timeout that was set last is in effect from the next feed on.
    pub fn is_set(&self) -> bool {
        self.next.is_none() && self.has_crossed()
    }

    /// Returns whether the last write has arrived at the counter. Until then, nothing else may be
    /// written.
    fn has_crossed(&self) -> bool {
        self.registers.sr().read().bits() == 0
    }

    fn write(&mut self, timeout: Timeout) {
        self.timeout = timeout;
        self.registers.kr().write(|w| w.key().unlock());
        self.registers.pr().write(|w| w.pr().set(timeout.shift));
        self.registers.rlr().write(|w| w.rl().set(timeout.counts));
    }
}

impl Watchdog for Independent {
    #[inline]
    fn feed(&mut self) {
        if self.next.is_some()
            && self.has_crossed()
            && let Some(timeout) = self.next.take()
        {
            self.write(timeout);
        }
        self.freeze_bits.set();
        self.registers.kr().write(|w| w.key().feed());
    }
}
