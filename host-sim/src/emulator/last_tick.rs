//! The image's own [`Tick`], out of its memory.
//!
//! The firmware leaves every tick in a static of its own, for debuggers and for this (`src/board/published.rs`). Its
//! address and size come from the ELF file's symbols; where each term lies in it is told by the type itself, which is
//! laid out as in C and has no pointers or words of the processor's size: it is the same on both sides.

use std::mem::{offset_of, size_of};

use rigless::emulator::{Error, Host};
use rigless::soc::Width;
use stiction::Tick;
use stiction::drive::Duty;
use stiction::position::Position;
use stiction::reference::Setpoint;

/// The static's name in the ELF file.
pub const SYMBOL: &str = "STICTION_LAST_TICK";
/// Bytes of a tick.
pub const SIZE: usize = size_of::<Tick>();

const WORD: usize = 4;
const _: () = assert!(SIZE.is_multiple_of(WORD));

/// Reads the last tick of the image. Nothing in the image runs meanwhile; the caller sees to it that its control task has
/// left the tick.
///
/// # Errors
/// If the emulator refuses to read its own memory.
pub fn read(host: &mut dyn Host, address: u64) -> Result<Tick, Error> {
    let mut bytes = [0; SIZE];
    for (word, at) in bytes.chunks_exact_mut(WORD).zip((address..).step_by(WORD)) {
        word.copy_from_slice(&(host.read(at, Width::W32)? as u32).to_le_bytes());
    }
    Ok(decode(&bytes))
}

fn decode(bytes: &[u8; SIZE]) -> Tick {
    let word = |at: usize| {
        let four = bytes.get(at..).and_then(|rest| rest.first_chunk());
        u32::from_le_bytes(four.copied().unwrap_or_default())
    };
    let half = |at: usize| {
        let two = bytes.get(at..).and_then(|rest| rest.first_chunk());
        u16::from_le_bytes(two.copied().unwrap_or_default())
    };
    let float = |at: usize| f32::from_bits(word(at));
    let flag = |at: usize| bytes.get(at).is_some_and(|byte| *byte != 0);
    Tick {
        tick: word(offset_of!(Tick, tick)),
        counts: word(offset_of!(Tick, counts)) as i32,
        setpoint: Setpoint {
            position: Position {
                counts: word(offset_of!(Tick, setpoint.position.counts)) as i32,
                fraction: float(offset_of!(Tick, setpoint.position.fraction)),
            },
            velocity: float(offset_of!(Tick, setpoint.velocity)),
            acceleration: float(offset_of!(Tick, setpoint.acceleration)),
        },
        error: float(offset_of!(Tick, error)),
        velocity: float(offset_of!(Tick, velocity)),
        v_pd: float(offset_of!(Tick, v_pd)),
        v_c: float(offset_of!(Tick, v_c)),
        v: float(offset_of!(Tick, v)),
        code: half(offset_of!(Tick, code)) as i16,
        duty: Duty {
            compare: half(offset_of!(Tick, duty.compare)),
            reverse: flag(offset_of!(Tick, duty.reverse)),
        },
        saturated: flag(offset_of!(Tick, saturated)),
        non_finite: flag(offset_of!(Tick, non_finite)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::compare::same_bits;

    #[test]
    fn each_term_has_its_own_bytes() {
        // 4 words, 4 of the set point, 5 more, and 8 bytes of code, duty and flags, of which one is padding.
        assert_eq!(SIZE, 52);
        let zero = decode(&[0; SIZE]);
        assert!(same_bits(&zero, &Tick::default()));
        let padding = offset_of!(Tick, duty.reverse) + 1;
        for at in 0..SIZE {
            let mut bytes = [0; SIZE];
            bytes[at] = 1;
            assert_eq!(same_bits(&decode(&bytes), &zero), at == padding, "byte {at}");
        }
    }

    #[test]
    fn the_terms_are_in_the_order_of_their_names() {
        let mut bytes = [0; SIZE];
        for (value, word) in bytes.chunks_exact_mut(WORD).enumerate() {
            word.copy_from_slice(&(value as u32).to_le_bytes());
        }
        bytes[44..].copy_from_slice(&[0xFF, 0xFF, 0x34, 0x12, 1, 0, 0, 1]);
        let found = decode(&bytes);
        let float = |value: u32| f32::from_bits(value);
        let position = Position { counts: 2, fraction: float(3) };
        let setpoint = Setpoint { position, velocity: float(4), acceleration: float(5) };
        let expected = Tick {
            tick: 0,
            counts: 1,
            setpoint,
            error: float(6),
            velocity: float(7),
            v_pd: float(8),
            v_c: float(9),
            v: float(10),
            code: -1,
            duty: Duty { compare: 0x1234, reverse: true },
            saturated: false,
            non_finite: true,
        };
        assert!(same_bits(&found, &expected), "{found:?}");
    }
}
