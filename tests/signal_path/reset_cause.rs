//! What a reset's flags and the option bytes say of the supply, held against RM0090: the file is
//! the firmware's own.

#[path = "../../src/board/reset_cause.rs"]
mod of_the_board;

use of_the_board::{BrownOut, ResetCause};
use stiction::Fault;

/// FLASH_OPTCR as the factory leaves it (RM0090: 0x0FFF_AAED), with another BOR_LEV (bits 3, 2).
fn options(level_bits: u32) -> u32 {
    0x0FFF_AAED & !0b1100 | level_bits << 2
}

/// RCC_CSR after a reset: RM0090, and the pin's flag that all of them set.
const POWER_ON: u32 = 0x0E00_0000;
const BROWN_OUT: u32 = 0x0600_0000;
const PIN: u32 = 0x0400_0000;
const SOFTWARE: u32 = 0x1400_0000;
const WATCHDOG: u32 = 0x2400_0000;

#[test]
fn a_factory_part_has_no_brown_out_reset_and_the_levels_are_the_manuals() {
    assert_eq!(BrownOut::of(0x0FFF_AAED), BrownOut::of(options(0b11)));
    let causes = [0b11, 0b10, 0b01, 0b00].map(|bits| {
        let level = BrownOut::of(options(bits));
        (level.is_on(), level.describe())
    });
    assert_eq!(
        causes,
        [
            (false, "off (1.8 V)"),
            (true, "level 1 (2.1 V)"),
            (true, "level 2 (2.4 V)"),
            (true, "level 3 (2.7 V)"),
        ]
    );
}

#[test]
fn each_cause_has_its_flags_and_nobody_asked_for_a_brown_out_or_a_watchdog() {
    for (flags, cause, fault) in [
        (POWER_ON, ResetCause::PowerOn, None),
        (BROWN_OUT, ResetCause::BrownOut, Some(Fault::BrownOut)),
        (PIN, ResetCause::Pin, None),
        (SOFTWARE, ResetCause::Software, None),
        (WATCHDOG, ResetCause::Watchdog, Some(Fault::Watchdog)),
        (0, ResetCause::Other, None),
    ] {
        assert_eq!((ResetCause::of(flags), cause.fault(false)), (cause, fault), "{flags:#x}");
        // The RAM says that the motor was driven: whatever it was, it was not commanded.
        assert_eq!(cause.fault(true), Some(fault.unwrap_or(Fault::ResetWhileArmed)));
    }
    let words = [POWER_ON, BROWN_OUT, PIN, SOFTWARE, WATCHDOG, 0]
        .map(|flags| ResetCause::of(flags).describe());
    let mut different = words.to_vec();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), words.len());
}

#[test]
fn only_a_part_with_a_brown_out_reset_can_report_power_on_from_a_dip() {
    for (flags, without, with) in [
        (POWER_ON, true, false),
        (0, true, false),
        // These have a flag of their own in either case.
        (BROWN_OUT, false, false),
        (PIN, false, false),
        (SOFTWARE, false, false),
        (WATCHDOG, false, false),
    ] {
        let may_be = |bits| ResetCause::of(flags).may_be_dip(BrownOut::of(options(bits)));
        assert_eq!((may_be(0b11), may_be(0b10), may_be(0b00)), (without, with, with), "{flags:#x}");
    }
}
