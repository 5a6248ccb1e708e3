//! The identity of the image, in an ELF note that a host reads before it runs or flashes the image.

/// An ELF note with the name `stiction` and type 1. Its description is the core's version, the
/// commit, the chip and the number of encoders that the image reads, each ended by a zero.
#[repr(C)]
struct Note {
    name_size: u32,
    description_size: u32,
    kind: u32,
    name: [u8; 12],
    description: [u8; SIZE],
}

const TEXTS: &str =
    concat!(env!("CARGO_PKG_VERSION"), "\0", env!("STICTION_COMMIT"), "\0STM32F405\0");

/// The text after them, a digit.
const ENCODERS: u8 = if cfg!(feature = "two-encoders") { b'2' } else { b'1' };

/// Size of the description, bytes: the texts, the digit and its zero. A note consists of whole
/// words.
const SIZE: usize = (TEXTS.len() + 2).next_multiple_of(4);

const fn description() -> [u8; SIZE] {
    let mut bytes = [0; SIZE];
    let mut i = 0;
    while i < TEXTS.len() {
        bytes[i] = TEXTS.as_bytes()[i];
        i += 1;
    }
    bytes[i] = ENCODERS;
    bytes
}

#[used]
#[unsafe(link_section = ".note.stiction")]
static NOTE: Note = Note {
    name_size: 9,
    description_size: SIZE as u32,
    kind: 1,
    name: *b"stiction\0\0\0\0",
    description: description(),
};
