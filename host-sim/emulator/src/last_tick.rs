//! Reads the last [`Tick`] of the image from its memory.
//!
//! The firmware stores every tick in a static, for debuggers and for this module
//! (`src/board/last_tick.rs`), as the first part of an [`Output`]. Address and size come from the
//! ELF file's symbols. The offset of each signal follows from the types, which are laid out as in C
//! and have no pointers or words of the processor's size: it is the same on both sides.

use std::mem::{offset_of, size_of};

use rigless::emulator::{Error, Host};
use rigless::soc::Width;
use stiction::Tick;
use stiction::control::signal::{LAYOUT, MAX_LAW_SIGNALS, SIGNALS, set};
use stiction::servo::Output;

/// The static's name in the ELF file.
pub const SYMBOL: &str = "STICTION_LAST_TICK";
/// Bytes of the static.
pub const PUBLISHED: usize = size_of::<Output>();
/// Bytes of a tick.
const SIZE: usize = size_of::<Tick>();

const WORD: usize = 4;
const _: () = assert!(offset_of!(Output, tick) == 0);
const _: () = assert!(SIZE.is_multiple_of(WORD));

/// Reads the last tick of the image, which is halted meanwhile. The caller must ensure that its
/// control task has finished the tick.
///
/// # Errors
/// Returns an error if the emulator refuses to read its own memory.
pub fn read(host: &mut dyn Host, address: u64) -> Result<Tick, Error> {
    let mut bytes = [0; SIZE];
    for (word, at) in bytes.chunks_exact_mut(WORD).zip((address..).step_by(WORD)) {
        word.copy_from_slice(&(host.read(at, Width::W32)? as u32).to_le_bytes());
    }
    Ok(decode(&bytes))
}

/// Decodes every signal from its place in the layout.
fn decode(bytes: &[u8; SIZE]) -> Tick {
    let mut tick = Tick::default();
    let at = |offset: usize, size: usize| {
        let mut word = [0; WORD];
        for (to, from) in word.iter_mut().zip(bytes.iter().skip(offset).take(size)) {
            *to = *from;
        }
        u32::from_le_bytes(word)
    };
    for (place, (offset, size)) in LAYOUT.iter().enumerate() {
        if place < SIGNALS.len() {
            set(&mut tick, place, at(*offset, *size));
            continue;
        }
        for (own, offset) in (*offset..).step_by(WORD).take(MAX_LAW_SIGNALS).enumerate() {
            set(&mut tick, place + own, at(offset, WORD));
        }
    }
    tick
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::same_bits;

    /// Three bytes of flags and one of padding stand between the compare value and the status.
    const PADDING: usize = offset_of!(Tick, non_finite) + 1;

    #[test]
    fn each_signal_has_its_own_bytes() {
        let zero = decode(&[0; SIZE]);
        assert!(same_bits(&zero, &Tick::default()));
        for at in 0..SIZE {
            let mut bytes = [0; SIZE];
            bytes[at] = 1;
            assert_eq!(same_bits(&decode(&bytes), &zero), at == PADDING, "byte {at}");
        }
    }

    #[test]
    fn the_signals_are_in_the_order_of_their_names() {
        let mut bytes = [0; SIZE];
        for (value, word) in bytes.chunks_exact_mut(WORD).enumerate() {
            word.copy_from_slice(&(value as u32).to_le_bytes());
        }
        bytes[48..52].copy_from_slice(&[0xFF, 0xFF, 0x34, 0x12]);
        bytes[52..56].copy_from_slice(&[1, 0, 1, 0]);
        let found = decode(&bytes);
        let float = |value: u32| f32::from_bits(value);
        let expected = Tick {
            tick: 0,
            counts: 1,
            reference_counts: 2,
            reference_fraction: float(3),
            reference_velocity: float(4),
            reference_acceleration: float(5),
            error: float(6),
            velocity: float(7),
            v_pd: float(8),
            v_c: float(9),
            v: float(10),
            v_applied: float(11),
            code: -1,
            compare: 0x1234,
            reverse: true,
            saturated: false,
            non_finite: true,
            status: 14,
            current: float(15),
            motor_counts: 16,
            law: [17, 18, 19, 20, 21, 22, 23, 24].map(float),
        };
        assert!(same_bits(&found, &expected), "{found:?}");
    }
}
