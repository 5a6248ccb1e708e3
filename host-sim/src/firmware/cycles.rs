//! Cycles of one instruction on a Cortex-M4 with its floating-point unit, as the manual gives them.
//!
//! Source: Cortex-M4 Technical Reference Manual (Arm DDI 0439 and 100166), table 3-1 and the section on load/store
//! timings, and the table of the floating-point unit's instructions. The counts hold for memory without wait states. Where
//! the manual gives a range, the most is taken: 3 cycles to refill the pipeline (P is 1 to 3), 12 for a division (2 to 12),
//! 2 for `cps` (1 or 2). What it says may save a cycle is left out: loads that follow each other, stores that the write
//! buffer takes at once, a folded `it`, and integer instructions beside a long division of floats. An instruction whose
//! condition does not hold counts as one that runs.
//!
//! Encodings: ARMv7-M Architecture Reference Manual (Arm DDI 0403), sections A5.2, A5.3, A6.4 to A6.7 and A7.7. One that is
//! not in here has no time: it never counts as a single cycle.

use std::fmt;

/// P of the manual, at most: the pipeline after a jump.
pub const REFILL: u32 = 3;

/// `sdiv` and `udiv`: 2 to 12, the more bits the longer.
const DIVIDE: u32 = 12;
/// `vdiv` and `vsqrt`.
const FLOAT_DIVIDE: u32 = 14;
/// Multiplication of floats with an addition, in any form.
const FLOAT_ACCUMULATE: u32 = 3;
/// One access: `ldr`, `str` and their kin.
const ACCESS: u32 = 2;
/// A load from beside the program "might add a cycle because of contention with the fetch unit".
const FETCH_CONTENTION: u32 = 1;
/// `tbb` and `tbh`: two for the load, one for the addition; the refill comes on top.
const TABLE_BRANCH: u32 = 3;
/// `cps` is 1 or 2. The manual gives `mrs` and `msr` no more.
const SPECIAL: u32 = 2;
/// `dsb` and `dmb`: one, and nothing at least for what they wait for. No most is given; see `docs/cost.md`.
const BARRIER: u32 = 1;

/// The place of the floating-point flags in a set of the unit's registers, after its 32.
const FLOAT_FLAGS: u64 = 1 << 32;
const PC: u32 = 15;
const SP: u32 = 13;

/// What one instruction takes, and what makes the next one wait for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    /// Cycles, without the refill after a jump.
    pub cycles: u32,
    /// Registers that it computes: an address made of one of them in the next instruction waits a cycle.
    computes: u32,
    /// Registers that it forms an address of.
    addresses: u32,
    /// Floating-point registers that it computes: an instruction that takes one of them right after waits a cycle.
    float_computes: u64,
    /// Floating-point registers that it takes.
    float_takes: u64,
}

/// An instruction without a known time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Its first halfword.
    pub first: u16,
    /// The second one, if it has two.
    pub second: Option<u16>,
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the encoding {:04x}", self.first)?;
        self.second.map_or(Ok(()), |second| write!(f, " {second:04x}"))
    }
}

impl Timing {
    /// Of the instruction that begins with `first`; `second` is only looked at if it is a long one.
    ///
    /// # Errors
    /// If its time is not known.
    pub fn of(first: u16, second: u16) -> Result<Self, Unknown> {
        let long = first >= 0xE800;
        let timing = if long { long_one(first.into(), second.into()) } else { short_one(first.into()) };
        timing.ok_or(Unknown { first, second: long.then_some(second) })
    }

    /// Cycles that `next`, right after it, waits for its results.
    pub const fn holds_up(&self, next: &Self) -> u32 {
        (self.computes & next.addresses != 0) as u32 + (self.float_computes & next.float_takes != 0) as u32
    }

    /// Nothing but a number of cycles.
    const fn plain(cycles: u32) -> Self {
        Self { cycles, computes: 0, addresses: 0, float_computes: 0, float_takes: 0 }
    }

    /// A single cycle that computes a register; 15 is none, as in `cmp` and `tst`.
    const fn computing(register: u32) -> Self {
        Self { computes: bit(register), ..Self::plain(1) }
    }

    /// An access to so many words.
    const fn accesses(words: u32, address: u32) -> Self {
        Self { addresses: address, ..Self::plain(1 + words) }
    }
}

/// The program counter is no register that anything waits for.
const fn bit(register: u32) -> u32 {
    if register < PC { 1 << register } else { 0 }
}

fn short_one(code: u32) -> Option<Timing> {
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

/// A5.2.5: 16 bits, from 1011.
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

fn long_one(first: u32, second: u32) -> Option<Timing> {
    match first >> 11 & 3 {
        1 => match first >> 9 & 3 {
            0 if first & 0x40 == 0 => multiple(first, second),
            0 => double_or_exclusive(first, second),
            // Data processing with a shifted register.
            1 => Some(Timing::computing(second >> 8 & 0xF)),
            _ => coprocessor(first, second),
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

/// A5.3.5: ldm and stm, push.w and pop.w among them.
fn multiple(first: u32, second: u32) -> Option<Timing> {
    let words = second.count_ones();
    matches!(first >> 7 & 3, 1 | 2).then(|| Timing::accesses(words, bit(first & 0xF)))
}

/// A5.3.6: two words at once, exclusive accesses, jumps by a table.
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

/// A5.3.4.
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

/// A5.3.16 and A5.3.17.
fn multiply_or_divide(first: u32, second: u32) -> Option<Timing> {
    let high = second >> 8 & 0xF;
    if first & 0x80 == 0 {
        return Some(Timing::computing(high));
    }
    match first >> 4 & 7 {
        1 | 3 => (second >> 4 & 0xF == 0xF).then(|| Timing { cycles: DIVIDE, ..Timing::computing(high) }),
        // smull, umull, smlal and their kin compute two registers.
        0 | 2 | 4..=6 => Some(Timing { computes: bit(high) | bit(second >> 12), ..Timing::plain(1) }),
        _ => None,
    }
}

/// A5.3.7 to A5.3.10: one access.
fn single(first: u32, second: u32) -> Option<Timing> {
    let (base, loads, size) = (first & 0xF, first & 0x10 != 0, first >> 5 & 3);
    let signed = first & 0x100 != 0;
    // Only loads of less than a word have a sign; a byte or a halfword into the program counter is a hint.
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

/// A6.4 to A6.7: the floating-point unit.
fn coprocessor(first: u32, second: u32) -> Option<Timing> {
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
    // The unit knows single precision only.
    if double { None } else { float_processing(first, second) }
}

/// A register by the four bits and the one beside them: in singles, of which a double is two.
const fn floats(four: u32, one: u32, double: bool) -> u64 {
    let (four, one) = (four & 0xF, one & 1);
    if double { 0b11 << ((one << 4 | four) << 1 & 31) } else { 1 << (four << 1 | one) }
}

/// A6.6 and A6.7.
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

/// A6.5: between the processor's registers and the unit's.
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

/// A6.4.
fn float_processing(first: u32, second: u32) -> Option<Timing> {
    let destination = floats(second >> 12, first >> 6, false);
    let (left, right) = (floats(first, second >> 7, false), floats(second, second >> 5, false));
    let takes_both = Timing { float_computes: destination, float_takes: left | right, ..Timing::plain(1) };
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
            (4, _) => Timing { float_computes: FLOAT_FLAGS, float_takes: destination | right, ..takes_one },
            (5, _) => Timing { float_computes: FLOAT_FLAGS, float_takes: destination, ..takes_one },
            _ => return None,
        },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(code: u32) -> Result<Timing, Unknown> {
        let (first, second) = if code > 0xFFFF { (code >> 16, code & 0xFFFF) } else { (code, 0) };
        Timing::of(first as u16, second as u16)
    }

    // Encodings: llvm-mc. Cycles: the manual's tables, N being the registers of a list, P left out.
    #[test]
    fn each_kind_of_instruction_takes_what_the_manual_says() {
        let table = [
            (1, 0x2001),       // movs r0, #1
            (1, 0x18D1),       // adds r1, r2, r3
            (1, 0xEB09_08CA),  // add.w r8, r9, r10, lsl #3
            (1, 0xF241_2134),  // movw r1, #4660
            (1, 0xF2C1_2134),  // movt r1, #4660
            (1, 0x2C07),       // cmp r4, #7
            (1, 0xF013_0F03),  // tst.w r3, #3
            (1, 0x4348),       // muls r0, r1, r0
            (1, 0xFB01_3002),  // mla r0, r1, r2, r3
            (1, 0xFBA2_0103),  // umull r0, r1, r2, r3
            (1, 0xFBC2_0103),  // smlal r0, r1, r2, r3
            (1, 0xFB51_F002),  // smmul r0, r1, r2
            (12, 0xFBB1_F0F2), // udiv r0, r1, r2
            (12, 0xFB91_F0F2), // sdiv r0, r1, r2
            (1, 0xFAB1_F081),  // clz r0, r1
            (1, 0xFA91_F0A1),  // rbit r0, r1
            (1, 0xB2C8),       // uxtb r0, r1
            (1, 0xFA0F_F889),  // sxth.w r8, r9
            (1, 0xF3C1_00C4),  // ubfx r0, r1, #3, #5
            (1, 0xF361_00C7),  // bfi r0, r1, #3, #5
            (1, 0xF301_0007),  // ssat r0, #8, r1
            (1, 0xFA82_F081),  // qadd r0, r1, r2
            (1, 0xFA81_F042),  // uadd8 r0, r1, r2
            (1, 0x4088),       // lsls r0, r1
            (1, 0xBA08),       // rev r0, r1
            (1, 0xA002),       // adr r0, #8
            (1, 0xB004),       // add sp, #16
            (1, 0xF2AD_4D00),  // subw sp, sp, #1024
            (2, 0x6848),       // ldr r0, [r1, #4]
            (2, 0xF851_0022),  // ldr.w r0, [r1, r2, lsl #2]
            (2, 0x7908),       // ldrb r0, [r1, #4]
            (2, 0xF931_0C04),  // ldrsh.w r0, [r1, #-4]
            (2, 0x9802),       // ldr r0, [sp, #8]
            (2, 0xF851_0B04),  // ldr r0, [r1], #4
            (3, 0x4802),       // ldr r0, [pc, #8]
            (3, 0xF8DF_8008),  // ldr.w r8, [pc, #8]
            (2, 0x6048),       // str r0, [r1, #4]
            (2, 0xF8A1_0190),  // strh.w r0, [r1, #400]
            (2, 0x5488),       // strb r0, [r1, r2]
            (3, 0xE9D2_0102),  // ldrd r0, r1, [r2, #8]
            (3, 0xE9CD_0102),  // strd r0, r1, [sp, #8]
            (2, 0xE851_0F00),  // ldrex r0, [r1]
            (2, 0xE841_0200),  // strex r2, r0, [r1]
            (2, 0xE8D1_0F4F),  // ldrexb r0, [r1]
            (4, 0xE890_000E),  // ldm r0, {r1, r2, r3}
            (5, 0xE880_010E),  // stm.w r0, {r1, r2, r3, r8}
            (3, 0xE920_0102),  // stmdb r0!, {r1, r8}
            (6, 0xB5F0),       // push {r4, r5, r6, r7, lr}
            (7, 0xE92D_41F0),  // push.w {r4, r5, r6, r7, r8, lr}
            (6, 0xBDF0),       // pop {r4, r5, r6, r7, pc}
            (7, 0xE8BD_81F0),  // pop.w {r4, r5, r6, r7, r8, pc}
            (2, 0xF84D_ED04),  // str lr, [sp, #-4]!
            (2, 0xF85D_FB04),  // ldr pc, [sp], #4
            (1, 0xE010),       // b #32
            (1, 0xD010),       // beq #32
            (1, 0xF000_8640),  // beq.w #3200
            (1, 0xF007_BE80),  // b.w #32000
            (1, 0xF007_FE80),  // bl #32000
            (1, 0x4770),       // bx lr
            (1, 0x4798),       // blx r3
            (1, 0xB120),       // cbz r0, #8
            (1, 0xBB0F),       // cbnz r7, #66
            (3, 0xE8DF_F000),  // tbb [pc, r0]
            (3, 0xE8DF_F010),  // tbh [pc, r0, lsl #1]
            (1, 0x468F),       // mov pc, r1
            (1, 0xBF00),       // nop
            (1, 0xF3AF_8000),  // nop.w
            (1, 0xBF40),       // sev
            (2, 0xB672),       // cpsid i
            (2, 0xB662),       // cpsie i
            (2, 0xF3EF_8010),  // mrs r0, primask
            (2, 0xF380_8811),  // msr basepri, r0
            (1, 0xF3BF_8F5F),  // dmb sy
            (1, 0xF3BF_8F4F),  // dsb sy
            (4, 0xF3BF_8F6F),  // isb sy
            (1, 0xF3BF_8F2F),  // clrex
            (1, 0xEE30_0A81),  // vadd.f32 s0, s1, s2
            (1, 0xEE30_0AC1),  // vsub.f32 s0, s1, s2
            (1, 0xEE20_0A81),  // vmul.f32 s0, s1, s2
            (1, 0xEE20_0AC1),  // vnmul.f32 s0, s1, s2
            (3, 0xEE00_0A81),  // vmla.f32 s0, s1, s2
            (3, 0xEE00_0AC1),  // vmls.f32 s0, s1, s2
            (3, 0xEE10_0AC1),  // vnmla.f32 s0, s1, s2
            (3, 0xEEA0_0A81),  // vfma.f32 s0, s1, s2
            (3, 0xEE90_0A81),  // vfnms.f32 s0, s1, s2
            (14, 0xEE80_0A81), // vdiv.f32 s0, s1, s2
            (14, 0xEEB1_0AE0), // vsqrt.f32 s0, s1
            (1, 0xEEB0_0AE0),  // vabs.f32 s0, s1
            (1, 0xEEB1_0A60),  // vneg.f32 s0, s1
            (1, 0xEEB0_0A60),  // vmov.f32 s0, s1
            (1, 0xEEB7_0A00),  // vmov.f32 s0, #1.0
            (1, 0xEEB4_0A60),  // vcmp.f32 s0, s1
            (1, 0xEEB5_0A40),  // vcmp.f32 s0, #0
            (1, 0xEEB8_0AE0),  // vcvt.f32.s32 s0, s1
            (1, 0xEEBC_0AE0),  // vcvt.u32.f32 s0, s1
            (1, 0xEEBD_0A60),  // vcvtr.s32.f32 s0, s1
            (1, 0xEEBA_0ACE),  // vcvt.f32.s32 s0, s0, #4
            (1, 0xEEB2_0A60),  // vcvtb.f32.f16 s0, s1
            (1, 0xEE10_0A90),  // vmov r0, s1
            (1, 0xEE00_0A90),  // vmov s1, r0
            (2, 0xEC51_0A11),  // vmov r0, r1, s2, s3
            (2, 0xEC41_0A11),  // vmov s2, s3, r0, r1
            (2, 0xEC51_0B11),  // vmov r0, r1, d1
            (1, 0xEE20_0B10),  // vmov.32 d0[1], r0
            (1, 0xEEF1_FA10),  // vmrs apsr_nzcv, fpscr
            (1, 0xEEE1_0A10),  // vmsr fpscr, r0
            (2, 0xED90_0A01),  // vldr s0, [r0, #4]
            (3, 0xED90_0B02),  // vldr d0, [r0, #8]
            (3, 0xED9F_0A02),  // vldr s0, [pc, #8]
            (2, 0xED80_0A01),  // vstr s0, [r0, #4]
            (3, 0xED80_0B02),  // vstr d0, [r0, #8]
            (5, 0xEC90_0A04),  // vldmia r0, {s0, s1, s2, s3}
            (5, 0xECA0_0B04),  // vstmia r0!, {d0, d1}
            (17, 0xED2D_8B10), // vpush {d8, d9, d10, d11, d12, d13, d14, d15}
            (3, 0xECBD_8B02),  // vpop {d8}
            (1, 0xBF0C),       // ite eq
        ];
        for (cycles, code) in table {
            assert_eq!(of(code).map(|timing| timing.cycles), Ok(cycles), "{code:#x}");
        }
    }

    #[test]
    fn what_is_not_known_is_named_and_never_a_cycle() {
        let unknown = [
            0xBF30,      // wfi
            0xBF20,      // wfe
            0xDE00,      // udf #0
            0xF7F0_A000, // udf.w #0
            0xDF00,      // svc #0
            0xBE00,      // bkpt #0
            0xEE31_0B02, // vadd.f64 d0, d1, d2
            0xEEB1_0BC1, // vsqrt.f64 d0, d1
            0xEF22_0844, // vadd.i32 q0, q1, q2
            0xEE01_0E12, // mcr p14, #0, r0, c1, c2, #0
            0xF890_F000, // pld [r0]
        ];
        for code in unknown {
            assert!(of(code).is_err(), "{code:#x}");
        }
        assert_eq!(of(0xDE00).unwrap_err().to_string(), "the encoding de00");
        assert_eq!(of(0xEE31_0B02).unwrap_err().to_string(), "the encoding ee31 0b02");
    }

    #[test]
    fn an_address_that_was_just_computed_costs_a_cycle() {
        let waits = |one: u32, next: u32| of(one).unwrap().holds_up(&of(next).unwrap());
        // adds r1, r2, r3 before ldr r0, [r1, #4]; before ldr.w r0, [r1, r2, lsl #2]; before strd r0, r1, [sp, #8].
        assert_eq!(waits(0x18D1, 0x6848), 1);
        assert_eq!(waits(0x18D1, 0xF851_0022), 1);
        assert_eq!(waits(0x18D1, 0xE9CD_0102), 0);
        // add sp, #16 before ldr r0, [sp, #8]; lsls r0, r1 before strb r0, [r1, r2], whose value is not an address.
        assert_eq!(waits(0xB004, 0x9802), 1);
        assert_eq!(waits(0x4088, 0x5488), 0);
        // What was loaded is not computed: ldr r0, [r1, #4] before ldr.w r8 and r0 of a list.
        assert_eq!(waits(0x6848, 0xE890_000E), 0);
    }

    #[test]
    fn a_float_that_was_just_computed_costs_a_cycle() {
        let waits = |one: u32, next: u32| of(one).unwrap().holds_up(&of(next).unwrap());
        // vadd.f32 s0, s1, s2 before itself; before vabs.f32 s0, s1; before vmla.f32 s0, s1, s2, which adds to s0.
        assert_eq!(waits(0xEE30_0A81, 0xEE30_0A81), 0);
        assert_eq!(waits(0xEE30_0A81, 0xEEB0_0AE0), 0);
        assert_eq!(waits(0xEE30_0A81, 0xEE00_0A81), 1);
        // Before vstr s0, [r0, #4]; vstr d0, [r0, #8]; vmov r0, s1; vcmp.f32 s0, #0.
        assert_eq!(waits(0xEE30_0A81, 0xED80_0A01), 1);
        assert_eq!(waits(0xEE30_0A81, 0xED80_0B02), 1);
        assert_eq!(waits(0xEE30_0A81, 0xEE10_0A90), 0);
        assert_eq!(waits(0xEE30_0A81, 0xEEB5_0A40), 1);
        // vcmp.f32 s0, s1 before vmrs; and before an integer instruction.
        assert_eq!(waits(0xEEB4_0A60, 0xEEF1_FA10), 1);
        assert_eq!(waits(0xEEB4_0A60, 0x18D1), 0);
    }
}
