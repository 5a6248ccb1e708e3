//! Timing of the processor's instructions. Those of the floating-point unit are in `float`.

use super::{FETCH_CONTENTION, PC, REFILL, Timing, bit, float};

/// Cycles of `sdiv` and `udiv`: 2 to 12, more for more bits.
const DIVIDE: u32 = 12;
/// Cycles of one access: `ldr`, `str` and similar ones.
const ACCESS: u32 = 2;
/// Cycles of `tbb` and `tbh`: two for the load, one for the addition, without the refill.
const TABLE_BRANCH: u32 = 3;
/// Cycles of `cps` (1 or 2), `mrs` and `msr` (no more by the manual).
const SPECIAL: u32 = 2;
/// Least cycles of `dsb` and `dmb`: one, and none for what they wait for. The manual has no upper
/// limit; see `tests/evidence/cost.md`.
const BARRIER: u32 = 1;
const SP: u32 = 13;

/// Returns the timing of an instruction of 16 bits (A5.2).
pub(super) fn short(code: u32) -> Option<Timing> {
    Some(match code >> 11 {
        // Shifts, add and sub of three registers or a small constant.
        0..=3 => Timing::computing(code & 7),
        // cmp with a constant; mov, add and sub with one.
        5 => Timing::plain(1),
        4 | 6 | 7 => Timing::computing(code >> 8 & 7),
        8 if code & 0x0400 == 0 => match code >> 6 & 0xF {
            // tst, cmp, cmn
            8 | 10 | 11 => Timing::plain(1),
            _ => Timing::computing(code & 7),
        },
        // add, cmp and mov of any register; bx and blx.
        8 => match code >> 8 & 3 {
            1 | 3 => Timing::plain(1),
            _ => Timing::computing(code & 7 | code >> 4 & 8),
        },
        9 => Timing::plain(ACCESS + FETCH_CONTENTION),
        // By two registers.
        10 | 11 => Timing::accesses(1, bit(code >> 3 & 7) | bit(code >> 6 & 7)),
        12..=17 => Timing::accesses(1, bit(code >> 3 & 7)),
        18 | 19 => Timing::accesses(1, bit(SP)),
        // adr, add to the stack pointer
        20 | 21 => Timing::computing(code >> 8 & 7),
        22 | 23 => return various(code),
        // stm, ldm
        24 | 25 => Timing::accesses((code & 0xFF).count_ones(), bit(code >> 8 & 7)),
        // b<c>; 14 is udf, 15 svc.
        26 | 27 if code >> 8 & 0xF < 14 => Timing::plain(1),
        28 => Timing::plain(1),
        _ => return None,
    })
}

/// Returns the timing of an instruction of 16 bits that begins with 1011 (A5.2.5).
fn various(code: u32) -> Option<Timing> {
    Some(match code >> 8 & 0xF {
        // add and sub of the stack pointer
        0x0 => Timing::computing(SP),
        // cbz, cbnz
        0x1 | 0x3 | 0x9 | 0xB => Timing::plain(1),
        // sxth, sxtb, uxth, uxtb
        0x2 => Timing::computing(code & 7),
        // push; pop
        0x4 | 0x5 | 0xC | 0xD => Timing::accesses((code & 0x1FF).count_ones(), bit(SP)),
        // cps
        0x6 if code & 0xE8 == 0x60 => Timing::plain(SPECIAL),
        // rev, rev16, revsh
        0xA if code >> 6 & 3 != 2 => Timing::computing(code & 7),
        // it; nop, yield and sev. wfe and wfi take as long as nothing happens.
        0xF if code & 0xF != 0 || matches!(code & 0xF0, 0x00 | 0x10 | 0x40) => Timing::plain(1),
        _ => return None,
    })
}

/// Returns the timing of an instruction of 32 bits (A5.3).
pub(super) fn long(first: u32, second: u32) -> Option<Timing> {
    match first >> 11 & 3 {
        1 => match first >> 9 & 3 {
            0 if first & 0x40 == 0 => multiple(first, second),
            0 => double_or_exclusive(first, second),
            // Data processing with a shifted register.
            1 => Some(Timing::computing(second >> 8 & 0xF)),
            _ => float::coprocessor(first, second),
        },
        2 if second & 0x8000 == 0 => Some(Timing::computing(second >> 8 & 0xF)),
        2 => branch_or_control(first, second),
        _ if first & 0x0400 != 0 => None,
        _ => match first >> 8 & 3 {
            2 if second & 0xF000 == 0xF000 => Some(Timing::computing(second >> 8 & 0xF)),
            2 => None,
            3 => multiply_or_divide(first, second),
            _ => single(first, second),
        },
    }
}

/// Returns the timing of ldm and stm, with push.w and pop.w (A5.3.5).
fn multiple(first: u32, second: u32) -> Option<Timing> {
    let words = second.count_ones();
    matches!(first >> 7 & 3, 1 | 2).then(|| Timing::accesses(words, bit(first & 0xF)))
}

/// Returns the timing of an access to two words, an exclusive access or a jump by a table (A5.3.6).
fn double_or_exclusive(first: u32, second: u32) -> Option<Timing> {
    let base = bit(first & 0xF);
    Some(match (first >> 4 & 0x1F, second >> 4 & 0xF) {
        // strex, ldrex; of a byte, of a halfword
        (0x04 | 0x05, _) | (0x0C | 0x0D, 4 | 5) => Timing::accesses(1, base),
        // tbb, tbh
        (0x0D, 0 | 1) => {
            let addresses = base | bit(second & 0xF);
            Timing { addresses, ..Timing::plain(TABLE_BRANCH) }
        }
        (0x0C | 0x0D, _) => return None,
        // ldrd, strd
        _ => Timing::accesses(2, base),
    })
}

/// Returns the timing of a branch or of a control instruction (A5.3.4).
fn branch_or_control(first: u32, second: u32) -> Option<Timing> {
    if second & 0x5000 != 0 {
        // b.w, bl. The form of blx that leaves Thumb is not in this architecture.
        return (second & 0x1000 != 0).then(|| Timing::plain(1));
    }
    if first >> 6 & 0xF < 14 {
        return Some(Timing::plain(1));
    }
    match first >> 4 & 0x7F {
        // msr, mrs
        0x38 | 0x39 => Some(Timing::plain(SPECIAL)),
        0x3E | 0x3F => Some(Timing { computes: bit(second >> 8 & 0xF), ..Timing::plain(SPECIAL) }),
        // nop.w
        0x3A if second & 0xFF == 0 => Some(Timing::plain(1)),
        0x3B => match second >> 4 & 0xF {
            // clrex
            2 => Some(Timing::plain(1)),
            // dsb, dmb
            4 | 5 => Some(Timing::plain(BARRIER)),
            // isb: as a jump to the next instruction
            6 => Some(Timing::plain(1 + REFILL)),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the timing of a multiplication or division (A5.3.16 and A5.3.17).
fn multiply_or_divide(first: u32, second: u32) -> Option<Timing> {
    let high = second >> 8 & 0xF;
    if first & 0x80 == 0 {
        return Some(Timing::computing(high));
    }
    match first >> 4 & 7 {
        1 | 3 => {
            (second >> 4 & 0xF == 0xF).then(|| Timing { cycles: DIVIDE, ..Timing::computing(high) })
        }
        // smull, umull, smlal and their kin compute two registers.
        0 | 2 | 4..=6 => {
            Some(Timing { computes: bit(high) | bit(second >> 12), ..Timing::plain(1) })
        }
        _ => None,
    }
}

/// Returns the timing of an access to one word or less (A5.3.7 to A5.3.10).
fn single(first: u32, second: u32) -> Option<Timing> {
    let (base, loads, size) = (first & 0xF, first & 0x10 != 0, first >> 5 & 3);
    let signed = first & 0x100 != 0;
    // Only loads of less than a word have a sign; a byte or a halfword into the program counter is
    // a hint.
    let is_hint = loads && size != 2 && second >> 12 == PC;
    if size == 3 || is_hint || (signed && !(loads && size < 2)) {
        return None;
    }
    if base == PC {
        return loads.then(|| Timing::plain(ACCESS + FETCH_CONTENTION));
    }
    let by_register = first & 0x80 == 0 && second & 0x0FC0 == 0;
    let index = if by_register { bit(second & 0xF) } else { 0 };
    Some(Timing::accesses(1, bit(base) | index))
}
