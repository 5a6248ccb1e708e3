//! The wire of the command link: USART1 on PA9 (out) and PA10 (in), 921 600 baud, 8N1.
//!
//! Bytes come and go by interrupt, one at a time; nothing waits for one. The receiver has no buffer
//! but its register: a byte has to be taken before the next one is whole, 10.9 us later. The
//! control task is above this interrupt and may hold it up for as long as it runs. Its budget is
//! 1300 instructions: 7.7 us, if each took one cycle. That alone fits. By the estimate in cycles
//! (docs/cost.md), which nobody has measured, the longest ticks take longer than that, and do not
//! fit. Nor does it fit if the tick has fallen due while the link held the control task's parts (up
//! to 7.4 us, [`super::machine`]) or the log wrote a line, which lock this interrupt out as well. Then a
//! byte may be lost. It costs the frame that it belongs to, and a client says that frame again.
//!
//! 84 MHz / 91 are 923 077 baud, 0.16 % too fast. Without a crystal, 16 MHz / 17 are 2.1 % too
//! fast, and the oscillator's own error (1 %) comes on top. That is enough to ask such a board what
//! is wrong with it, if the other end is exact.

use stm32f4xx_hal::gpio::{Alternate, PA9, PA10};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// Rate of the wire, bits a second.
const BAUD: u32 = 921_600;

/// The port of the wire.
pub struct Port {
    registers: pac::USART1,
    _pins: (PA9<Alternate<7>>, PA10<Alternate<7>>),
}

impl Port {
    /// Starts the port, which listens. Its interrupt waits until the tasks run.
    pub fn start(
        registers: pac::USART1,
        out: PA9<Alternate<7>>,
        into: PA10<Alternate<7>>,
        rcc: &mut Rcc,
    ) -> Self {
        pac::USART1::enable(rcc);
        pac::USART1::reset(rcc);
        let clock = rcc.clocks.pclk2().raw();
        // With 16 samples a bit, the register holds the clocks of a bit.
        let divider = (clock + BAUD / 2) / BAUD;
        // SAFETY: any value is one that the divider takes.
        registers.brr().write(|w| unsafe { w.bits(divider as u16) });
        registers
            .cr1()
            .write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        Self { registers, _pins: (out, into) }
    }

    /// Returns a byte that has come. A byte that came with noise is one, too: the frame's checksum
    /// knows.
    #[inline]
    pub fn receive(&mut self) -> Option<u8> {
        let status = self.registers.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return None;
        }
        // This takes the byte. After the status has been read, it also ends an overrun, which would
        // else interrupt for ever.
        let byte = self.registers.dr().read().dr().bits() as u8;
        status.rxne().bit_is_set().then_some(byte)
    }

    /// Sends the byte that `next` gives, if there is room for one. If there is nothing to send, the
    /// port does not ask again.
    #[inline]
    pub fn send(&mut self, next: impl FnOnce() -> Option<u8>) {
        if self.registers.sr().read().txe().bit_is_clear() {
            return;
        }
        match next() {
            Some(byte) => {
                self.registers.dr().write(|w| w.dr().set(byte.into()));
                self.registers.cr1().modify(|_, w| w.txeie().enabled());
            }
            None => {
                self.registers.cr1().modify(|_, w| w.txeie().disabled());
            }
        }
    }
}
