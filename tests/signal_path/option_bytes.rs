//! The option bytes with another brown-out level, over every word that a part may have: the file
//! is the firmware's own.

#[path = "../../src/board/option_bytes.rs"]
mod of_the_board;

use of_the_board::{Untouchable, is_done, with_highest_level};

/// FLASH_OPTCR as the factory leaves it (RM0090): locked, level off, not protected.
const FACTORY: u32 = 0x0FFF_AAED;
const FOR_EVER: u32 = 0xCC;

/// FLASH_OPTCR of these option bytes, with lock and start as they may be read.
fn word(protection: u32, sectors: u32, user: u32, level: u32, control: u32) -> u32 {
    sectors << 16 | protection << 8 | user << 5 | level << 2 | control
}

#[test]
fn the_factorys_word_gets_level_3_and_nothing_else() {
    assert_eq!(with_highest_level(FACTORY), Ok(Some(0x0FFF_AAE0)));
    assert!(is_done(FACTORY, 0x0FFF_AAE1));
    // A part that has it is not programmed again.
    assert_eq!(with_highest_level(0x0FFF_AAE1), Ok(None));
}

#[test]
fn no_word_loses_or_gains_a_bit_of_protection_or_of_the_user_bytes() {
    for protection in 0..=0xFF {
        // Each sector alone, all, none, and patterns.
        let sectors = (0..12).map(|bit| 1 << bit).chain([0, 0xFFF, 0xAAA, 0x555, 0xFFE, 0x7FF]);
        for sectors in sectors {
            for rest in 0..1 << 7 {
                let (user, level, control) = (rest & 7, rest >> 3 & 3, rest >> 5);
                let before = word(protection, sectors, user, level, control);
                let found = with_highest_level(before);
                if protection == FOR_EVER {
                    assert_eq!(found, Err(Untouchable::Protected), "{before:#x}");
                    continue;
                }
                let expected = (level != 0).then_some(word(protection, sectors, user, 0, 0));
                assert_eq!(found, Ok(expected), "{before:#x}");
            }
        }
    }
}

#[test]
fn a_word_that_this_part_cannot_have_is_left_alone() {
    for bit in [4, 28, 29, 30, 31] {
        assert_eq!(with_highest_level(FACTORY | 1 << bit), Err(Untouchable::Unknown), "{bit}");
    }
    // A bus that reads ones.
    assert_eq!(with_highest_level(u32::MAX), Err(Untouchable::Unknown));
}

#[test]
fn a_word_read_back_is_right_only_if_the_level_alone_has_changed() {
    let after = 0x0FFF_AAE1;
    for bit in 0..32 {
        let is_control = bit < 2;
        assert_eq!(is_done(FACTORY, after ^ 1 << bit), is_control, "bit {bit}");
    }
    assert!(!is_done(FACTORY, FACTORY));
}
