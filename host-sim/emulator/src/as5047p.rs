//! The chip AS5047P on the emulated board: SPI3, with its chip select on PC8.
//!
//! It answers each frame with the register that the frame before has requested, and samples its
//! angle where chip select rises. Frames with a wrong parity set its error flag, as the data sheet
//! says. It has the registers that the firmware reads: angle, diagnosis and errors. It does not
//! check the times of chip select, and is ready at once.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::device::Level;
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::spi::Select;
use rigless::store;
use stiction::load_encoder::as5047p::{ANGLECOM, DIAAGC, ERRFL};

/// SPI3, by its place in the emulator's table.
const SPI3: usize = 2;

/// Diagnosis of a sound chip: the offset is found, and the gain is in the middle.
const SOUND: u16 = 0x0180;
/// In an answer: the chip has received a frame that it does not accept.
const ERROR: u16 = 1 << 14;
/// In ERRFL: the parity of a frame was wrong.
const PARITY_ERROR: u16 = 1 << 2;
const DATA: u16 = 0x3FFF;

/// The chip.
#[derive(Debug)]
pub struct As5047p {
    /// Angle of the magnet, counts of 2^14 a turn.
    angle: u16,
    /// Angle as of the last rise of chip select.
    sampled: u16,
    /// Content of the diagnosis register.
    diagnosis: u16,
    errors: u16,
    /// Register that the last frame has requested.
    requested: u16,
}

store!(As5047p { values: [angle, sampled, diagnosis, errors, requested], parts: [], built: [] });

impl As5047p {
    /// Attaches a sound chip to the bus.
    pub fn fit(mcu: &mut Stm32f427) {
        let (Some(pin), Some(spi)) = (Pin::new(8), mcu.spi.get_mut(SPI3)) else { return };
        let chip = Self { angle: 0, sampled: 0, diagnosis: SOUND, errors: 0, requested: 0 };
        spi.attach_selected(chip, Select { port: "GPIOC", pin, active: Level::Low });
    }

    /// Turns the magnet of the chip to a count; there may be none.
    pub fn turn(mcu: &mut Stm32f427, counts: i64) {
        if let Some(chip) = Self::of(mcu) {
            chip.angle = counts as u16 & DATA;
        }
    }

    /// Sets the diagnosis register of the chip: a magnet that is too far, for example.
    pub fn diagnose(mcu: &mut Stm32f427, diagnosis: u16) {
        if let Some(chip) = Self::of(mcu) {
            chip.diagnosis = diagnosis;
        }
    }

    /// Sets the chip's error, as a frame with a wrong parity does.
    pub fn refuse(mcu: &mut Stm32f427) {
        if let Some(chip) = Self::of(mcu) {
            chip.errors |= PARITY_ERROR;
        }
    }

    /// Cuts the chip off its bus, or connects it again.
    pub fn silence(mcu: &mut Stm32f427, is_silent: bool) {
        if let Some(spi) = mcu.spi.get_mut(SPI3) {
            let _ = spi.silence(0, is_silent);
        }
    }

    fn of(mcu: &mut Stm32f427) -> Option<&mut Self> {
        mcu.spi.get_mut(SPI3)?.chip_mut(0)
    }

    /// Returns the content of a register; a read of the errors clears them.
    fn content(&mut self, register: u16) -> u16 {
        match register {
            ANGLECOM => self.sampled,
            DIAAGC => self.diagnosis,
            ERRFL => std::mem::take(&mut self.errors),
            _ => 0,
        }
    }
}

impl Peer for As5047p {
    fn transfer(&mut self, mosi: u32, _bits: u8, _context: &mut Timeline<'_, '_>) -> u32 {
        let error = if self.errors == 0 { 0 } else { ERROR };
        let data = self.content(self.requested) & DATA | error;
        let answer = if data.count_ones().is_multiple_of(2) { data } else { data | 1 << 15 };
        let frame = mosi as u16;
        if frame.count_ones().is_multiple_of(2) {
            self.requested = frame & DATA;
        } else {
            self.errors |= PARITY_ERROR;
        }
        answer.into()
    }

    fn deselect(&mut self, _context: &mut Timeline<'_, '_>) {
        self.sampled = self.angle;
    }
}
