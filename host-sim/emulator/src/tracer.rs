//! Adds up the cycles of a running image, block by block.
//!
//! The emulator reports each arrival at a block, and the number of instructions until then. If this
//! number differs from that of the block before, the path between the two is unknown, and the
//! estimate is rejected.

use std::ops::{Add, AddAssign, Range, Sub};
use std::sync::Arc;

use rigless::emulator::Hit;

use crate::firmware::blocks::Blocks;
use crate::firmware::cycles::REFILL;

/// Wait states of the flash at 168 MHz and 3.3 V (RM0090, section 3.5.1): cycles that a fetch waits
/// if the accelerator does not serve it.
pub const WAIT_STATES: u32 = 5;

/// Cycles from the request to the handler's first instruction: 12, and 17 for the floating-point
/// registers, whether they are saved at once or at the handler's first instruction that needs them
/// (Cortex-M4 manual, on interrupt latency).
const ENTRY: u32 = 12 + 17;
/// Cycles from the handler's return to the interrupted instruction: 10, and 17 again. They include
/// the refill after the return.
const EXIT: u32 = 10 + 17;

/// Estimated processor cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cycles {
    /// Cycles if the flash accelerator holds every instruction.
    pub hits: u32,
    /// Cycles if it holds no target of a jump, and all instructions in sequence.
    pub misses: u32,
}

impl Cycles {
    /// Returns the cycles of a stretch with a number of jumps.
    const fn with_jumps(cycles: u32, jumps: u32) -> Self {
        Self { hits: cycles, misses: cycles + jumps * WAIT_STATES }
    }
}

impl Add for Cycles {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { hits: self.hits + other.hits, misses: self.misses + other.misses }
    }
}

impl AddAssign for Cycles {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Cycles {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { hits: self.hits - other.hits, misses: self.misses - other.misses }
    }
}

/// Interrupt handler, and a function below it whose cycles are also counted separately.
#[derive(Clone, Debug)]
pub struct Route {
    /// Blocks that both can run.
    pub blocks: Blocks,
    /// Addresses of the handler's own code.
    pub handler: Range<u32>,
    /// Address of the function's first instruction.
    pub part: u32,
    /// Addresses to which the function returns.
    pub part_returns_to: Vec<u32>,
}

/// Cost of one passage of a handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// Cycles from the request until the interrupted instruction continues.
    pub whole: Cycles,
    /// Cycles of the function among them, from its first instruction to its return, inclusive;
    /// `None` if it did not run.
    pub part: Option<Cycles>,
    /// Instructions from the handler's first one to its return, both included.
    pub instructions: u32,
}

/// Tracer of a running image.
#[derive(Clone, Debug)]
pub struct Tracer {
    route: Arc<Route>,
    /// Running block: its address, and the number of instructions before it.
    open: Option<(u32, u64)>,
    so_far: Passage,
    part_begun: Option<Cycles>,
    done: Option<Passage>,
    /// Reason why there is no estimate.
    pub trouble: Option<String>,
}

impl Tracer {
    /// Creates the tracer of a route.
    pub const fn new(route: Arc<Route>) -> Self {
        let so_far = Passage { whole: Cycles { hits: 0, misses: 0 }, part: None, instructions: 0 };
        Self { route, open: None, so_far, part_begun: None, done: None, trouble: None }
    }

    /// Handles an arrival at a block.
    pub fn hit(&mut self, hit: &Hit) {
        if self.trouble.is_none()
            && let Err(why) = self.arrive(hit.address as u32, hit.instruction_count)
        {
            self.trouble = Some(why);
        }
    }

    /// Returns the passage that ended last, once.
    pub const fn take(&mut self) -> Option<Passage> {
        self.done.take()
    }

    fn arrive(&mut self, address: u32, count: u64) -> Result<(), String> {
        let route = self.route.clone();
        let Some(block) = route.blocks.get(address) else { return Ok(()) };
        if address == route.handler.start {
            // The vector is fetched, and then the handler.
            let whole = Cycles::with_jumps(ENTRY, 2);
            self.so_far = Passage { whole, part: None, instructions: 0 };
            self.part_begun = None;
        } else if let Some((from, then)) = self.open.take()
            && let Some(last) = route.blocks.get(from)
        {
            let (ran, has) = (count - then, last.instructions);
            if ran != u64::from(has) {
                return Err(format!(
                    "{ran} instructions from {from:#x} to {address:#x}, where a block has {has}"
                ));
            }
            self.so_far.whole += if address == last.end {
                Cycles::with_jumps(last.holds_up(block), 0)
            } else {
                Cycles::with_jumps(REFILL, 1)
            };
        } else {
            // Code of lower priority runs a block that the handler can run as well.
            return Ok(());
        }
        if address == route.part {
            self.part_begun = Some(self.so_far.whole);
        } else if route.part_returns_to.contains(&address)
            && let Some(begun) = self.part_begun.take()
        {
            self.so_far.part = Some(self.so_far.whole - begun);
        }
        let cycles = block.cycles.map_err(|unknown| {
            format!("the time of {unknown} is not known, in what runs from {address:#x} on")
        })?;
        self.so_far.whole += Cycles::with_jumps(cycles, 0);
        self.so_far.instructions += block.instructions;
        if block.returns && route.handler.contains(&address) {
            self.so_far.whole += Cycles::with_jumps(EXIT, 1);
            self.done = Some(self.so_far);
        } else {
            self.open = Some((address, count));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rigless::emulator::HitKind;
    use rigless::time::VirtualNanos;

    use super::*;
    use crate::firmware::code::tests::code;

    /// A handler at 0x100 that calls a function at 0x110, with the cycles of each instruction.
    const HANDLER: [u16; 8] = [
        0xB510, // push {r4, lr}          1 + 2
        0x2001, // movs r0, #1            1
        0xF000, 0xF804, // bl 0x110       1 + 3
        0xB100, // cbz r0, 0x10c          1, and 3 if it is taken
        0x3001, // adds r0, #1            1
        0xBD10, // pop {r4, pc}           1 + 2
        0xBF00, // nop
    ];
    const PART: [u16; 5] = [
        0xEE30, 0x0A00, // vadd.f32 s0, s0, s0   1
        0xEE20, 0x0A00, // vmul.f32 s0, s0, s0   1, and 1 for the sum
        0x4770, // bx lr                         1 + 3
    ];

    fn passage(arrivals: &[(u32, u64)]) -> Result<Passage, String> {
        let code = code(0x100, &[], &[("TIM3", &HANDLER), ("part", &PART)]);
        let handler = code.function("TIM3").map_err(|error| error.to_string())?;
        let route = Route {
            blocks: Blocks::below(&code, handler),
            handler: 0x100..0x110,
            part: 0x110,
            part_returns_to: vec![0x108],
        };
        let mut tracer = Tracer::new(Arc::new(route));
        for (address, instruction_count) in arrivals {
            tracer.hit(&Hit {
                kind: HitKind::Instruction,
                address: u64::from(*address),
                at: VirtualNanos(0),
                instruction_count: *instruction_count,
            });
        }
        tracer.take().ok_or_else(|| tracer.trouble.unwrap_or_default())
    }

    #[test]
    fn a_passage_takes_what_adding_up_by_hand_gives() {
        // The call, the function, its return, the branch that is not taken, and the end.
        let found =
            passage(&[(0x100, 1000), (0x110, 1003), (0x108, 1006), (0x10A, 1007), (0x10C, 1008)]);
        let (entry, exit) = (29, 27);
        let part = 1 + 1 + 1 + (1 + 3);
        let whole = entry + 3 + 1 + (1 + 3) + part + 1 + 1 + 3 + exit;
        assert_eq!(
            found,
            Ok(Passage {
                // Jumps: the vector, the handler, the call, the return, the handler's end.
                whole: Cycles { hits: whole, misses: whole + 5 * 5 },
                part: Some(Cycles { hits: part, misses: part + 5 }),
                instructions: 9,
            })
        );
    }

    #[test]
    fn a_branch_that_is_taken_takes_longer() {
        let taken = passage(&[(0x100, 0), (0x110, 3), (0x108, 6), (0x10C, 7)]).unwrap();
        let passed =
            passage(&[(0x100, 0), (0x110, 3), (0x108, 6), (0x10A, 7), (0x10C, 8)]).unwrap();
        // Three for the refill, and the addition is left out.
        assert_eq!(taken.whole.hits, passed.whole.hits + 3 - 1);
        assert_eq!(taken.whole.misses, passed.whole.misses + 3 + 5 - 1);
    }

    #[test]
    fn a_way_that_is_not_known_gives_no_estimate() {
        let error = passage(&[(0x100, 0), (0x110, 4), (0x108, 7), (0x10C, 8)]).unwrap_err();
        assert!(
            error.contains("4 instructions from 0x100 to 0x110, where a block has 3"),
            "{error}"
        );
    }
}
