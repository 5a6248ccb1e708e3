//! The absolute encoder on the load: an AS5047P on SPI3 (PC10 clock, PC11 data in, PC12 data out)
//! with its chip select on PC8.
//!
//! ```text
//!             tick                                     next tick
//! select   ___|~|___________|~|________________________|~|____
//! frame       ^  2: DIAAGC      1: ANGLECOM              ^
//!             the chip samples the angle                the angle of this tick
//! ```
//!
//! A frame takes 16 bits at 42 MHz / 8 = 5.25 MHz, 3.05 us. The frame that requests the angle is
//! sent at the end of a tick, and lies on the wires while the processor sleeps. The chip samples at
//! its end, which is where chip select rises: at the start of the next tick. The frame that brings
//! the angle follows at once, while the tick reads its other inputs; what is left of it is waited
//! for. DMA would gain nothing, since chip select has to rise between the two frames.

use stiction::load_encoder::as5047p::{self, BadReading};
use stiction::servo::EncoderReading;
use stm32f4xx_hal::gpio::{Alternate, Output, PC8, PC10, PC11, PC12, PushPull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// Rounds of the wait for a frame. One takes five instructions at least; a frame takes 512 clocks.
const ROUNDS: u32 = 300;

/// Clocks for which chip select stays high between two frames, and from its fall to the first clock
/// of a frame: 350 ns each, and a bit more.
const SELECT_CLOCKS: u32 = 64;

/// Pins of the bus.
pub type BusPins = (PC10<Alternate<6>>, PC11<Alternate<6>>, PC12<Alternate<6>>);

/// The driver of the chip.
pub struct AbsoluteEncoder {
    spi: pac::SPI3,
    select: PC8<Output<PushPull>>,
    _pins: BusPins,
    /// Whether the frame that requests an angle is on its way.
    is_requested: bool,
    /// Frames of the next tick: to read an angle, or to clear the chip's error.
    frames: [u16; 2],
    /// Answer to the last diagnosis frame, which comes with the request.
    diagnosis: Option<u16>,
    /// Whether the answers of this tick hold no angle, after a start.
    discards: bool,
    /// Angle of the last valid answer, which counts on beyond a turn.
    counter: u32,
}

impl AbsoluteEncoder {
    /// Sets the bus up. The first tick with an angle is the third one.
    pub fn start(
        spi: pac::SPI3,
        mut select: PC8<Output<PushPull>>,
        pins: BusPins,
        rcc: &mut Rcc,
    ) -> Self {
        select.set_high();
        pac::SPI3::enable(rcc);
        pac::SPI3::reset(rcc);
        // Mode 1: the clock rests low, and data is taken at its second edge. Frames of 16 bits, the
        // highest first; chip select is a pin of its own.
        spi.cr1().write(|w| {
            w.mstr().master().cpha().second_edge().cpol().idle_low();
            w.dff().sixteen_bit().ssm().enabled().ssi().slave_not_selected();
            w.br().div8().spe().enabled()
        });
        Self {
            spi,
            select,
            _pins: pins,
            is_requested: false,
            frames: as5047p::FRAMES,
            diagnosis: None,
            discards: true,
            counter: 0,
        }
    }

    /// Ends the frame that has requested the angle, so that the chip samples it, and sends the one
    /// that brings it. Called at the start of a tick.
    #[inline]
    pub fn sample(&mut self) {
        if !self.is_requested {
            return;
        }
        self.select.set_high();
        self.diagnosis = self.received();
        cortex_m::asm::delay(SELECT_CLOCKS);
        self.select.set_low();
        cortex_m::asm::delay(SELECT_CLOCKS);
        self.send(self.frames[1]);
    }

    /// Waits for the frame that brings the angle, and returns the reading.
    #[inline(never)]
    pub fn read(&mut self) -> EncoderReading {
        let mut is_missing = true;
        if self.is_requested {
            let angle = self.awaited();
            self.select.set_high();
            is_missing = self.take(angle);
        }
        EncoderReading { counter: self.counter, lines: 0, is_missing }
    }

    /// Selects the chip for the request. Called long after chip select has risen, and as long
    /// before the request.
    #[inline]
    pub fn select(&mut self) {
        self.select.set_low();
    }

    /// Requests the angle of the next tick. Called at the end of a tick.
    #[inline]
    pub fn request(&mut self) {
        self.send(self.frames[0]);
        self.is_requested = true;
    }

    /// Takes the answers of a tick, and returns whether they hold no angle.
    fn take(&mut self, angle: Option<u16>) -> bool {
        let (Some(diagnosis), Some(angle)) = (self.diagnosis, angle) else { return true };
        let discards = core::mem::replace(&mut self.discards, false);
        let is_clearing = self.frames != as5047p::FRAMES;
        self.frames = as5047p::FRAMES;
        if is_clearing {
            // The next request is answered with the diagnosis of this tick.
            return true;
        }
        if discards {
            return true;
        }
        match as5047p::angle([diagnosis, angle]) {
            Ok(angle) => {
                self.counter = counted_on(self.counter, angle);
                false
            }
            Err(BadReading::Refused) => {
                self.frames = as5047p::CLEAR;
                true
            }
            Err(_) => true,
        }
    }

    /// Sends a frame to the chip, which is selected.
    #[inline]
    fn send(&mut self, frame: u16) {
        self.spi.dr().write(|w| w.dr().set(frame));
    }

    /// Returns the frame that has been received, if it is complete.
    #[inline]
    fn received(&self) -> Option<u16> {
        let is_complete = self.spi.sr().read().rxne().bit();
        is_complete.then(|| self.spi.dr().read().dr().bits())
    }

    /// Waits for a frame; none if the bus does not send it.
    fn awaited(&self) -> Option<u16> {
        (0..ROUNDS).find_map(|_| self.received())
    }
}

/// Returns the counter that has the angle in its low bits and is closest to `before`: the encoder
/// moves by less than half a turn between two readings.
fn counted_on(before: u32, angle: u16) -> u32 {
    const UNUSED: u32 = u32::BITS - as5047p::BITS;
    let travel = (u32::from(angle).wrapping_sub(before) << UNUSED) as i32 >> UNUSED;
    before.wrapping_add_signed(travel)
}
