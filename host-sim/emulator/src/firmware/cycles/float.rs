//! Timing of the instructions of the floating-point unit, which has single precision only.

use super::{FETCH_CONTENTION, PC, Timing, bit};

/// Cycles of `vdiv` and `vsqrt`.
const FLOAT_DIVIDE: u32 = 14;
/// Cycles of a multiplication of floats with an addition, in any form.
const FLOAT_ACCUMULATE: u32 = 3;
/// Bit of the floating-point flags in a set of the unit's registers, after its 32.
const FLOAT_FLAGS: u64 = 1 << 32;

/// Returns the timing of an instruction of the floating-point unit (A6.4 to A6.7).
pub(super) fn coprocessor(first: u32, second: u32) -> Option<Timing> {
    if second & 0x0E00 != 0x0A00 || first & 0x0300 == 0x0300 {
        return None;
    }
    let double = second & 0x100 != 0;
    if first & 0x0200 == 0 {
        return float_access(first, second, double);
    }
    if second & 0x10 != 0 {
        return float_transfer(first, second, double);
    }
    // The unit computes in single precision only.
    if double { None } else { float_processing(first, second) }
}

/// Returns the set of singles of a register, by its four bits and the one beside them. A double is
/// two singles.
const fn floats(four: u32, one: u32, double: bool) -> u64 {
    let (four, one) = (four & 0xF, one & 1);
    if double { 0b11 << ((one << 4 | four) << 1 & 31) } else { 1 << (four << 1 | one) }
}

/// Returns the timing of an access to memory, or of a transfer of two registers (A6.6 and A6.7).
fn float_access(first: u32, second: u32, double: bool) -> Option<Timing> {
    let loads = first & 0x10 != 0;
    match first & 0x01E0 {
        0x0000 => return None,
        // vmov of two registers, which are neighbours if they are singles
        0x0040 => {
            let lower = floats(second, second >> 5, double);
            let pair = if double { lower } else { lower | lower << 1 };
            let takes = if loads { pair & (FLOAT_FLAGS - 1) } else { 0 };
            return Some(Timing { float_takes: takes, ..Timing::plain(2) });
        }
        _ => {}
    }
    let base = first & 0xF;
    let lowest = floats(second >> 12, first >> 6, double);
    let is_one = first & 0x0120 == 0x0100;
    let words = match (is_one, double) {
        (true, false) => 1,
        (true, true) => 2,
        (false, _) => second & 0xFF,
    };
    let all = (0..words).fold(0, |all, word| all | lowest.checked_shl(word).unwrap_or(0));
    let contention = if base == PC { FETCH_CONTENTION } else { 0 };
    Some(Timing {
        cycles: 1 + words + contention,
        addresses: bit(base),
        float_takes: if loads { 0 } else { all & (FLOAT_FLAGS - 1) },
        ..Timing::default()
    })
}

/// Returns the timing of a transfer between the processor's registers and the unit's (A6.5).
fn float_transfer(first: u32, second: u32, double: bool) -> Option<Timing> {
    let to_core = first & 0x10 != 0;
    match first >> 5 & 7 {
        // vmov of a whole single, or of either half of a double
        half @ (0 | 1) if double || half == 0 => {
            let single = floats(first, second >> 7, double);
            Some(Timing { float_takes: if to_core { single } else { 0 }, ..Timing::plain(1) })
        }
        // vmrs, vmsr
        7 if !double => {
            Some(Timing { float_takes: if to_core { FLOAT_FLAGS } else { 0 }, ..Timing::plain(1) })
        }
        _ => None,
    }
}

/// Returns the timing of a computation (A6.4).
fn float_processing(first: u32, second: u32) -> Option<Timing> {
    let destination = floats(second >> 12, first >> 6, false);
    let (left, right) = (floats(first, second >> 7, false), floats(second, second >> 5, false));
    let takes_both =
        Timing { float_computes: destination, float_takes: left | right, ..Timing::plain(1) };
    let takes_one = Timing { float_takes: right, ..takes_both };
    let accumulates =
        Timing { cycles: FLOAT_ACCUMULATE, float_takes: left | right | destination, ..takes_both };
    Some(match (first >> 4 & 0xB, second & 0x40 != 0) {
        // vmla, vmls; vnmla, vnmls; vfnma, vfnms; vfma, vfms
        (0x0 | 0x1 | 0x9 | 0xA, _) => accumulates,
        // vmul, vnmul; vadd, vsub
        (0x2 | 0x3, _) => takes_both,
        (0x8, false) => Timing { cycles: FLOAT_DIVIDE, ..takes_both },
        // vmov of a constant
        (0xB, false) => Timing { float_takes: 0, ..takes_both },
        (0xB, true) => match (first & 0xF, second & 0x80 != 0) {
            (1, true) => Timing { cycles: FLOAT_DIVIDE, ..takes_one },
            // vmov, vabs, vneg; conversions of all kinds
            (0 | 1 | 2 | 3 | 8, _) | (0xC | 0xD, _) => takes_one,
            // A fixed-point number is converted where it is.
            (0xA | 0xB | 0xE | 0xF, _) => Timing { float_takes: destination, ..takes_one },
            // vcmp of two registers; of one with zero
            (4, _) => Timing {
                float_computes: FLOAT_FLAGS,
                float_takes: destination | right,
                ..takes_one
            },
            (5, _) => Timing { float_computes: FLOAT_FLAGS, float_takes: destination, ..takes_one },
            _ => return None,
        },
        _ => return None,
    })
}
