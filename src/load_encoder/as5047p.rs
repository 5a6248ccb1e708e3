//! Frames of the AS5047P, a magnetic encoder of 14 bits on SPI.
//!
//! Each frame has 16 bits, the highest first. The answer to a frame comes with the next one. With
//! two frames in each tick there is an angle and a diagnosis in each of them:
//!
//! ```text
//!           frame 1 of a tick             frame 2
//! sent      read ANGLECOM                 read DIAAGC
//! received  DIAAGC of the last tick       ANGLECOM, sampled at the end of frame 1
//!
//! sent       parity (15)   read (14)    address (13..0)
//! received   parity (15)   error (14)   data (13..0)         even parity of all 16 bits
//! ```
//!
//! ANGLECOM is the angle with the chip's compensation of its own delay. DIAAGC has the gain of the
//! chip's amplifier (bits 7 to 0) and four flags: offset found (8), overflow of the angle's
//! computation (9), field too strong (10), field too weak (11).
//!
//! Bus: SPI mode 1, at most 10 MHz, and chip select high for 350 ns between two frames. At 5.25 MHz
//! both frames take 2 (16 / 5.25 MHz + 0.7 us) = 7.5 us, so that the angle is some 4 us old when it
//! has arrived. When the chip samples is from the description of the AS5055A, a chip of the same
//! maker with these frames; it was not measured.
//!
//! Guarantees: a frame with one wrong bit is rejected, and so are the frames of a line that is
//! stuck high or low for a whole tick. Does badly: two wrong bits in a frame pass the parity. A
//! line that breaks between the two frames of a tick, or within the second, can pass one wrong
//! angle; the next tick rejects the line, and a limit of the travel in a tick detects most of these
//! angles. An angle that is wrong by itself, as from a magnet that turns on its shaft, has no flag;
//! the comparison with the motor's encoder detects that.

/// Bits of a turn.
pub const BITS: u32 = 14;

/// Angle of a count, deg.
pub const RESOLUTION: f32 = 360.0 / (1_u32 << BITS) as f32;

/// Angle with compensation of the chip's delay.
pub const ANGLECOM: u16 = 0x3FFF;
/// Diagnosis, and gain of the amplifier.
pub const DIAAGC: u16 = 0x3FFC;
/// Errors of the bus. A read clears them.
pub const ERRFL: u16 = 0x0001;

/// Frames to send in each tick, in this order. The first pair after a reset of the microcontroller
/// gives no angle: its first answer is that to an earlier frame.
pub const FRAMES: [u16; 2] = [read(ANGLECOM), read(DIAAGC)];

/// Frames to send in the tick after [`BadReading::Refused`], which clear the chip's error. Their
/// second answer is no angle: discard both.
pub const CLEAR: [u16; 2] = [read(ERRFL), read(DIAAGC)];

const PARITY: u16 = 1 << 15;
const READ: u16 = 1 << 14;
const ERROR: u16 = 1 << 14;
const DATA: u16 = (1 << BITS) - 1;

const OFFSET_FOUND: u16 = 1 << 8;
const OVERFLOW: u16 = 1 << 9;
const TOO_STRONG: u16 = 1 << 10;
const TOO_WEAK: u16 = 1 << 11;

/// Reason for which a tick has no angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadReading {
    /// A bit is wrong on the way from the chip, or the line is open.
    Parity,
    /// The chip has received a frame that it does not accept, or the line is stuck high. Send
    /// [`CLEAR`] in the next tick.
    Refused,
    /// The chip is not ready yet (10 ms after power-on), or the line is stuck low.
    NotReady,
    /// The computation of the angle has overflowed: there is no angle.
    Overflow,
    /// The field is too strong: the magnet is too near.
    TooStrong,
    /// The field is too weak: the magnet is too far, or is gone.
    TooWeak,
}

/// Returns the frame that reads a register.
///
/// ```
/// use stiction::load_encoder::as5047p::{ANGLECOM, ERRFL, read};
///
/// // 15 ones, so that the parity bit is one; two ones.
/// assert_eq!((read(ANGLECOM), read(ERRFL)), (0xFFFF, 0x4001));
/// ```
pub const fn read(register: u16) -> u16 {
    let frame = READ | (register & DATA);
    if frame.count_ones().is_multiple_of(2) { frame } else { frame | PARITY }
}

/// Returns the angle (counts, below 2^14) from the two frames that were received in a tick, in
/// answer to [`FRAMES`].
///
/// ```
/// use stiction::load_encoder::as5047p::{BadReading, angle};
///
/// // A gain of 128, and the offset is found: two ones. The angle is 5: two ones.
/// assert_eq!(angle([0x0180, 0x0005]), Ok(5));
/// // A line that is stuck low, and one that is stuck high.
/// assert_eq!(angle([0, 0]), Err(BadReading::NotReady));
/// assert_eq!(angle([0xFFFF, 0xFFFF]), Err(BadReading::Refused));
/// ```
///
/// # Errors
/// Returns why there is no angle. Hold the last one, and turn the output off if this lasts.
pub const fn angle(received: [u16; 2]) -> Result<u16, BadReading> {
    let [diagnosis, angle] = received;
    // `?` is not const yet.
    let (diagnosis, angle) = match (data(diagnosis), data(angle)) {
        (Ok(diagnosis), Ok(angle)) => (diagnosis, angle),
        (Err(bad), _) | (_, Err(bad)) => return Err(bad),
    };
    if diagnosis & OFFSET_FOUND == 0 {
        Err(BadReading::NotReady)
    } else if diagnosis & OVERFLOW != 0 {
        Err(BadReading::Overflow)
    } else if diagnosis & TOO_STRONG != 0 {
        Err(BadReading::TooStrong)
    } else if diagnosis & TOO_WEAK != 0 {
        Err(BadReading::TooWeak)
    } else {
        Ok(angle)
    }
}

/// Returns the data of a frame that was received.
const fn data(frame: u16) -> Result<u16, BadReading> {
    if !frame.count_ones().is_multiple_of(2) {
        Err(BadReading::Parity)
    } else if frame & ERROR != 0 {
        Err(BadReading::Refused)
    } else {
        Ok(frame & DATA)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the frame that a chip without a fault sends for 14 bits of data. Its parity is
    /// counted bit by bit, apart from the code under test.
    fn from_chip(data: u16) -> u16 {
        let ones = (0..14).filter(|bit| data >> bit & 1 == 1).count();
        data | if ones % 2 == 1 { 0x8000 } else { 0 }
    }

    /// Gain in the middle, and the offset is found.
    const HEALTHY: u16 = 0x0180;

    /// The frames of the data sheet's registers.
    #[test]
    fn the_frames_have_even_parity_and_the_bit_that_reads() {
        assert_eq!(FRAMES, [0xFFFF, 0xFFFC]);
        assert_eq!(CLEAR, [0x4001, 0xFFFC]);
        assert_eq!(read(0), 0xC000);
    }

    #[test]
    fn every_angle_arrives_and_no_single_wrong_bit_passes() {
        for sent in 0..1 << 14 {
            assert_eq!(angle([from_chip(HEALTHY), from_chip(sent)]), Ok(sent));
            for bit in 0..16 {
                let wrong = from_chip(sent) ^ (1 << bit);
                let read = angle([from_chip(HEALTHY), wrong]);
                assert!(matches!(read, Err(BadReading::Parity)), "{sent}, bit {bit}: {read:?}");
            }
        }
    }

    #[test]
    fn each_flag_of_the_chip_has_its_reason_and_the_gain_has_none() {
        for (diagnosis, expected) in [
            (HEALTHY & !0x0100, Err(BadReading::NotReady)),
            (HEALTHY | 0x0200, Err(BadReading::Overflow)),
            (HEALTHY | 0x0400, Err(BadReading::TooStrong)),
            (HEALTHY | 0x0800, Err(BadReading::TooWeak)),
            (0x0100, Ok(7)),
            (0x01FF, Ok(7)),
        ] {
            assert_eq!(angle([from_chip(diagnosis), from_chip(7)]), expected, "{diagnosis:#x}");
        }
        // The error bit, with a parity that counts it.
        let refused = from_chip(7) ^ 0xC000;
        assert_eq!(angle([from_chip(HEALTHY), refused]), Err(BadReading::Refused));
        assert_eq!(angle([from_chip(HEALTHY) ^ 0xC000, from_chip(7)]), Err(BadReading::Refused));
    }

    /// A wire that breaks in the middle of a tick sticks from some bit on.
    #[test]
    fn a_line_that_sticks_before_the_diagnosis_gives_no_angle() {
        for stuck in [0x0000, 0xFFFF] {
            for angle_frame in [stuck, from_chip(7)] {
                assert!(angle([stuck, angle_frame]).is_err());
            }
        }
        // Of an angle alone, only what sticks high is seen at once, and zero in the next tick.
        assert!(angle([from_chip(HEALTHY), 0xFFFF]).is_err());
        assert_eq!(angle([from_chip(HEALTHY), 0]), Ok(0));
    }
}
