//! The wire of the command link: USART1 on PA9 (out) and PA10 (in), 921 600 baud, 8N1.
//!
//! Bytes come by DMA (RM0090: USART1_RX is channel 4 of stream 2 of DMA2) into a
//! [ring](super::receive_ring). So no byte waits for the processor: neither a control tick, nor a
//! line of the log, nor a whole pause of 5 ms loses one. Bytes are sent by interrupt, one at a
//! time.
//!
//! The link is woken when the line has been idle for the time of a byte, and at each half of the
//! ring. A read of the status and then one of the data clear the idle flag. If the program read the
//! data itself, it could remove a byte that comes between the two reads before the DMA reads it. So
//! the program never reads the data: the DMA does, with the next byte. Until then the interrupt of
//! the idle flag is off. That of a received byte is on, and enables the idle interrupt again. If a
//! microcontroller does not clear the flag that way, or drops the interrupt of a byte that the DMA
//! reads at once, a frame waits for the next tick: no byte is lost.
//!
//! 84 MHz / 91 are 923 077 baud, 0.16 % too fast. Without a crystal the internal oscillator's error
//! comes on top: docs/reference/faults.md states it with faults 3 and 4.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use stiction::link::WireErrors;
use stm32f4xx_hal::gpio::{Alternate, PA9, PA10};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::receive_ring::{LENGTH, Reader, Writer};

/// Rate of the wire, bits a second.
const BAUD: u32 = 921_600;

/// Stream of DMA2, and its channel, that carry what USART1 receives.
const STREAM: usize = 2;
const CHANNEL: u8 = 4;

/// Ring into which the DMA writes the bytes. It is in RAM that the DMA can access (memory.x has no
/// other).
static RING: [AtomicU8; LENGTH] = [const { AtomicU8::new(0) }; LENGTH];

/// Number of bytes received since the start. It wraps.
static WRITTEN: AtomicU32 = AtomicU32::new(0);

/// Number of looks at the status that have found new noise or a new framing error.
static NOISE: AtomicU32 = AtomicU32::new(0);
/// Number of looks at the status that have found a new overrun.
static OVERRUNS: AtomicU32 = AtomicU32::new(0);

/// The port of the wire, for the interrupts.
pub struct Port {
    registers: pac::USART1,
    dma: pac::DMA2,
    writer: Writer,
    /// Errors that the last look at the status has found.
    seen: Errors,
    _pins: (PA9<Alternate<7>>, PA10<Alternate<7>>),
}

/// Bytes received over the wire, for the link.
pub struct ReceiveQueue {
    reader: Reader,
}

/// Errors in the status register.
#[derive(Clone, Copy, Default)]
struct Errors {
    noise: bool,
    overrun: bool,
}

impl Port {
    /// Starts the port, ready to receive. Its interrupts wait until the tasks run.
    pub fn start(
        registers: pac::USART1,
        dma: pac::DMA2,
        out: PA9<Alternate<7>>,
        into: PA10<Alternate<7>>,
        rcc: &mut Rcc,
    ) -> (Self, ReceiveQueue) {
        pac::USART1::enable(rcc);
        pac::USART1::reset(rcc);
        pac::DMA2::enable(rcc);
        pac::DMA2::reset(rcc);
        let stream = dma.st(STREAM);
        // SAFETY: the data register of the port, and a static ring with no other writer.
        stream.par().write(|w| unsafe { w.bits(registers.dr().as_ptr() as u32) });
        stream.m0ar().write(|w| unsafe { w.bits(RING.as_ptr() as u32) });
        stream.ndtr().write(|w| w.ndt().set(LENGTH as u16));
        // What is not set here is zero: bytes at both ends, from the peripheral to the memory,
        // without the FIFO.
        stream.cr().write(|w| {
            w.chsel().set(CHANNEL).minc().incremented().circ().enabled();
            w.htie().enabled().tcie().enabled()
        });
        stream.cr().modify(|_, w| w.en().enabled());
        let clock = rcc.clocks.pclk2().raw();
        // With 16 samples a bit, the register holds the clocks of a bit.
        let divider = (clock + BAUD / 2) / BAUD;
        // SAFETY: any value is one that the divider takes.
        registers.brr().write(|w| unsafe { w.bits(divider as u16) });
        registers.cr3().write(|w| w.dmar().enabled());
        registers
            .cr1()
            .write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        let (writer, seen) = (Writer::default(), Errors::default());
        let port = Self { registers, dma, writer, seen, _pins: (out, into) };
        (port, ReceiveQueue { reader: Reader::default() })
    }

    /// Handles an interrupt: updates the number of received bytes, and sends the byte that `next`
    /// returns, if there is room for one. If there is nothing to send, turns the interrupt for
    /// sending off. Returns whether the line has fallen idle.
    #[inline]
    pub fn serve(&mut self, next: impl FnOnce() -> Option<u8>) -> bool {
        let status = self.registers.sr().read();
        let before = self.writer;
        let written = self.writer.look(self.dma.st(STREAM).ndtr().read().ndt().bits());
        // Release: a reader that sees the number sees the bytes, too.
        WRITTEN.store(written, Ordering::Release);
        let errors = Errors {
            noise: status.nf().bit_is_set() || status.fe().bit_is_set(),
            overrun: status.ore().bit_is_set(),
        };
        errors.count(self.seen);
        self.seen = errors;
        let control = self.registers.cr1().read();
        let is_idle = control.idleie().bit_is_set() && status.idle().bit_is_set();
        let has_come = self.writer != before || status.rxne().bit_is_set() || errors.overrun;
        let has_room = status.txe().bit_is_set();
        let byte = if has_room { next() } else { None };
        if let Some(byte) = byte {
            self.registers.dr().write(|w| w.dr().set(byte.into()));
        }
        self.registers.cr1().modify(|_, w| {
            if is_idle {
                w.idleie().disabled().rxneie().enabled();
            } else if has_come {
                w.idleie().enabled().rxneie().disabled();
            }
            if has_room {
                w.txeie().bit(byte.is_some());
            }
            w
        });
        is_idle
    }
}

/// Ends the interrupt of a half of the ring.
pub fn acknowledge_half() {
    // SAFETY: ones clear the two flags of this stream; zeros do nothing.
    unsafe { (*pac::DMA2::ptr()).lifcr() }.write(|w| w.chtif2().clear().ctcif2().clear());
}

impl ReceiveQueue {
    /// Returns the next byte.
    #[inline]
    pub fn next(&mut self) -> Option<u8> {
        let place = self.reader.next(WRITTEN.load(Ordering::Acquire))?;
        RING.get(place).map(|byte| byte.load(Ordering::Relaxed))
    }

    /// Returns whether a byte waits to be read.
    pub fn is_waiting(&self) -> bool {
        self.reader.is_behind(WRITTEN.load(Ordering::Acquire))
    }

    /// Returns the numbers of errors on the wire.
    pub fn errors(&self) -> WireErrors {
        let overruns = OVERRUNS.load(Ordering::Relaxed);
        WireErrors {
            noise: NOISE.load(Ordering::Relaxed),
            lost: overruns.saturating_add(self.reader.lost()),
        }
    }
}

impl Errors {
    /// Counts the errors that the look before has not found. The flags stay until the DMA reads a
    /// byte after such a look, so several errors in one frame count once.
    fn count(self, before: Self) {
        for (now, then, number) in
            [(self.noise, before.noise, &NOISE), (self.overrun, before.overrun, &OVERRUNS)]
        {
            if now && !then {
                // Only this interrupt writes it.
                number.store(number.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
            }
        }
    }
}
