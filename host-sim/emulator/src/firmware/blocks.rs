//! Blocks of code that always run from their start to their end, each with its cycles.
//!
//! A block ends before an instruction that is the target of a jump, and after one that can jump: a
//! branch, a call, a return, a jump by a table. To trace a running image, it is enough to watch the
//! starts of its blocks; the number of instructions between two of them reveals a missing start.

use std::collections::{BTreeMap, BTreeSet};

use super::code::{Code, Function, PlacedInstruction};
use super::cycles::{Timing, UnknownTiming};
use super::thumb::ControlFlow;

/// `tbb` and `tbh`, without their registers.
const TABLE_BRANCH: (u16, u16) = (0xE8D0, 0xF000);
/// In the second halfword: entries of the table are halfwords.
const HALFWORDS: u16 = 0x10;

/// Block of code.
#[derive(Clone, Debug)]
pub struct CodeBlock {
    /// Address after its last instruction.
    pub end: u32,
    /// Number of its instructions.
    pub instructions: u32,
    /// Whether its last instruction returns unconditionally.
    pub returns: bool,
    /// Cycles from its first instruction to the end of its last, with the waits between them, and
    /// without the refill after a jump. If the timing of an instruction is unknown, its encoding.
    pub cycles: Result<u32, UnknownTiming>,
    first: Timing,
    last: Timing,
}

impl CodeBlock {
    /// Cycles that `next` waits for the results of this block, if it follows without a jump.
    pub const fn holds_up(&self, next: &Self) -> u32 {
        self.last.holds_up(&next.first)
    }
}

/// The blocks of a function and of everything that it can call.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    blocks: BTreeMap<u32, CodeBlock>,
}

impl Blocks {
    /// Returns the blocks of a function and of everything that it can call.
    pub fn below(code: &Code, function: &Function) -> Self {
        let functions = code.reachable(function);
        let mut begins: BTreeSet<u32> = functions.iter().map(|function| function.address).collect();
        for function in &functions {
            for placed in code.instructions(function) {
                begins.extend(leads_to(code, &placed));
            }
        }
        let mut blocks = BTreeMap::new();
        for function in functions {
            let mut stretch: Vec<PlacedInstruction> = Vec::new();
            // Number of instructions to which the last `it` still applies.
            let mut conditional = 0;
            for placed in code.instructions(function) {
                // After a gap, such as a table, an instruction does not follow the one before.
                let follows = stretch.last().is_some_and(|last| last.end() == placed.address);
                if !follows || begins.contains(&placed.address) {
                    close(&mut blocks, &mut stretch, 0);
                }
                stretch.push(placed);
                if may_leave(&placed) {
                    close(&mut blocks, &mut stretch, conditional);
                }
                conditional =
                    held_by_it(placed.halfwords.0).unwrap_or(u32::saturating_sub(conditional, 1));
            }
            close(&mut blocks, &mut stretch, 0);
        }
        Self { blocks }
    }

    /// Returns the block that begins at an address.
    pub fn get(&self, address: u32) -> Option<&CodeBlock> {
        self.blocks.get(&address)
    }

    /// Returns the addresses of all blocks.
    pub fn begins(&self) -> impl Iterator<Item = u32> {
        self.blocks.keys().copied()
    }

    /// Returns all blocks with their addresses.
    pub fn all(&self) -> impl Iterator<Item = (u32, &CodeBlock)> {
        self.blocks.iter().map(|(address, block)| (*address, block))
    }
}

/// Ends a block. `conditional` is 0 if no `it` applies to its last instruction.
fn close(
    blocks: &mut BTreeMap<u32, CodeBlock>,
    stretch: &mut Vec<PlacedInstruction>,
    conditional: u32,
) {
    if let (Some(first), Some(last)) = (stretch.first(), stretch.last()) {
        let returns = last.instruction.flow == ControlFlow::Return && conditional == 0;
        let timings: Result<Vec<Timing>, UnknownTiming> = stretch
            .iter()
            .map(|placed| Timing::of(placed.halfwords.0, placed.halfwords.1))
            .collect();
        let ends = timings.as_ref().map_or_else(
            |_| (Timing::default(), Timing::default()),
            |all| {
                (all.first().copied().unwrap_or_default(), all.last().copied().unwrap_or_default())
            },
        );
        let cycles = timings.map(|all| {
            let waits = all.iter().zip(all.iter().skip(1)).map(|(one, next)| one.holds_up(next));
            all.iter().map(|timing| timing.cycles).chain(waits).sum()
        });
        let instructions = stretch.len() as u32;
        let block = CodeBlock {
            end: last.end(),
            instructions,
            returns,
            cycles,
            first: ends.0,
            last: ends.1,
        };
        blocks.insert(first.address, block);
    }
    stretch.clear();
}

fn is_table_branch(placed: &PlacedInstruction) -> bool {
    let (first, second) = placed.halfwords;
    first & 0xFFF0 == TABLE_BRANCH.0 && second & 0xFFE0 == TABLE_BRANCH.1
}

fn may_leave(placed: &PlacedInstruction) -> bool {
    placed.instruction.flow != ControlFlow::On || is_table_branch(placed)
}

/// Returns the addresses to which an instruction can lead; none if it only leads to the next one.
fn leads_to(code: &Code, placed: &PlacedInstruction) -> Vec<u32> {
    match placed.instruction.flow {
        ControlFlow::On if is_table_branch(placed) => table(code, placed),
        ControlFlow::On => Vec::new(),
        ControlFlow::Branch(target) | ControlFlow::Call(target) => vec![target, placed.end()],
        ControlFlow::CallRegister | ControlFlow::JumpRegister | ControlFlow::Return => {
            vec![placed.end()]
        }
    }
}

/// Returns the targets of a jump table. Its entries are distances in halfwords from its own start,
/// which follows the instruction. The last byte can be padding, which leads to the table itself and
/// so to no instruction.
fn table(code: &Code, placed: &PlacedInstruction) -> Vec<u32> {
    let wide = placed.halfwords.1 & HALFWORDS != 0;
    let entries = code.data(placed.end()).flat_map(|halfword| {
        if wide {
            vec![u32::from(halfword)]
        } else {
            halfword.to_le_bytes().map(u32::from).to_vec()
        }
    });
    entries.map(|distance| placed.end() + 2 * distance).collect()
}

/// Returns the number of instructions in the block of Thumb's `it` (if-then); `None` if `first` is
/// another instruction.
const fn held_by_it(first: u16) -> Option<u32> {
    if first & 0xFF00 == 0xBF00 && first & 0xF != 0 {
        Some(4 - (first & 0xF).trailing_zeros())
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::code::tests::code;

    fn blocks(marks: &[(u32, bool)], function: &[u16]) -> Vec<(u32, u32, bool)> {
        let code = code(0x100, marks, &[("f", function)]);
        let blocks = Blocks::below(&code, code.function("f").unwrap());
        blocks.all().map(|(begin, block)| (begin, block.instructions, block.returns)).collect()
    }

    #[test]
    fn a_block_ends_at_a_branch_and_where_a_branch_leads() {
        // adds; cbz to the last; adds; adds; bx lr
        let found = blocks(&[], &[0x3001, 0xB108, 0x3001, 0x3001, 0x4770]);
        assert_eq!(found, [(0x100, 2, false), (0x104, 2, false), (0x108, 1, true)]);
    }

    #[test]
    fn a_return_that_it_holds_may_not_happen() {
        // it eq; bxeq lr; adds; bx lr
        let found = blocks(&[], &[0xBF08, 0x4770, 0x3001, 0x4770]);
        assert_eq!(found, [(0x100, 2, false), (0x104, 2, true)]);
        // ittt eq; movs; movs; movs; bx lr, which is no longer held
        let found = blocks(&[], &[0xBF02, 0x2001, 0x2001, 0x2001, 0x4770]);
        assert_eq!(found, [(0x100, 5, true)]);
    }

    #[test]
    fn a_table_leads_to_each_of_its_entries() {
        // tbb [pc, r0]; entries 2, 3 and 4, and a byte to align; then nop; bx lr; adds; bx lr
        let function = [0xE8DF, 0xF000, 0x0302, 0x0004, 0xBF00, 0x4770, 0x3001, 0x4770];
        let found = blocks(&[(0x100, true), (0x104, false), (0x108, true)], &function);
        assert_eq!(
            found,
            [(0x100, 1, false), (0x108, 1, false), (0x10A, 1, true), (0x10C, 2, true)]
        );
    }

    #[test]
    fn cycles_are_those_of_the_instructions_and_of_what_they_wait_for() {
        // adds r1, r2, r3; ldr r0, [r1, #4]; bx lr
        let code = code(0x100, &[], &[("f", &[0x18D1, 0x6848, 0x4770])]);
        let blocks = Blocks::below(&code, code.function("f").unwrap());
        assert_eq!(blocks.get(0x100).unwrap().cycles, Ok(1 + 1 + 2 + 1));
    }

    #[test]
    fn a_block_with_an_unknown_instruction_has_no_cycles() {
        // adds; svc; bx lr
        let code = code(0x100, &[], &[("f", &[0x3001, 0xDF00, 0x4770])]);
        let blocks = Blocks::below(&code, code.function("f").unwrap());
        assert_eq!(blocks.get(0x100).unwrap().cycles.unwrap_err().first, 0xDF00);
    }
}
