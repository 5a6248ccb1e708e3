//! Cycles of one instruction on a Cortex-M4 with its floating-point unit, by the manual.
//!
//! Source: Cortex-M4 Technical Reference Manual (Arm DDI 0439 and 100166), table 3-1 and the
//! section on load/store timings, and the table of the floating-point unit's instructions. The
//! counts hold for memory without wait states. If the manual has a range, its maximum is used: 3
//! cycles to refill the pipeline (P is 1 to 3), 12 for a division (2 to 12), 2 for `cps` (1 or 2).
//! Cases that may save a cycle by the manual are not counted: loads that follow each other, stores
//! that the write buffer takes at once, a folded `it`, and integer instructions beside a long
//! division of floats. An instruction whose condition does not hold counts as one that runs.
//!
//! Encodings: ARMv7-M Architecture Reference Manual (Arm DDI 0403), sections A5.2, A5.3, A6.4 to
//! A6.7 and A7.7. An instruction that is missing here has no timing: it never counts as a single
//! cycle.

mod float;
mod processor;
#[cfg(test)]
mod tests;

use std::fmt;

/// Cycles to refill the pipeline after a jump: the largest P of the manual.
pub const REFILL: u32 = 3;

/// A load from beside the program "might add a cycle because of contention with the fetch unit".
const FETCH_CONTENTION: u32 = 1;
const PC: u32 = 15;

/// Cycles of one instruction, and the registers for which the next one can wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    /// Cycles, without the refill after a jump.
    pub cycles: u32,
    /// Registers that it computes: if the next instruction forms an address from one of them, it
    /// waits a cycle.
    computes: u32,
    /// Registers from which it forms an address.
    addresses: u32,
    /// Floating-point registers that it computes: if the next instruction reads one of them, it
    /// waits a cycle.
    float_computes: u64,
    /// Floating-point registers that it reads.
    float_takes: u64,
}

/// An instruction without a known time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownTiming {
    /// Its first halfword.
    pub first: u16,
    /// The second one, if it has two.
    pub second: Option<u16>,
}

impl fmt::Display for UnknownTiming {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the encoding {:04x}", self.first)?;
        self.second.map_or(Ok(()), |second| write!(f, " {second:04x}"))
    }
}

impl Timing {
    /// Returns the timing of the instruction that begins with `first`. `second` is used only for a
    /// long instruction.
    ///
    /// # Errors
    /// Returns an error if the timing is unknown.
    pub fn of(first: u16, second: u16) -> Result<Self, UnknownTiming> {
        let long = first >= 0xE800;
        let timing = if long {
            processor::long(first.into(), second.into())
        } else {
            processor::short(first.into())
        };
        timing.ok_or(UnknownTiming { first, second: long.then_some(second) })
    }

    /// Returns the cycles that `next`, right after it, waits for its results.
    pub const fn holds_up(&self, next: &Self) -> u32 {
        (self.computes & next.addresses != 0) as u32
            + (self.float_computes & next.float_takes != 0) as u32
    }

    /// Creates the timing of an instruction with a number of cycles, for which no other waits.
    const fn plain(cycles: u32) -> Self {
        Self { cycles, computes: 0, addresses: 0, float_computes: 0, float_takes: 0 }
    }

    /// Creates the timing of one cycle that computes a register; 15 is none, as in `cmp` and `tst`.
    const fn computing(register: u32) -> Self {
        Self { computes: bit(register), ..Self::plain(1) }
    }

    /// Creates the timing of an access to a number of words.
    const fn accesses(words: u32, address: u32) -> Self {
        Self { addresses: address, ..Self::plain(1 + words) }
    }
}

/// Returns the set with a register; it is empty for the program counter, for which nothing waits.
const fn bit(register: u32) -> u32 {
    if register < PC { 1 << register } else { 0 }
}
