//! Upper limit of the stack, by the calls that the code can make.
//!
//! There is one stack. The start runs with interrupts masked: RTIC masks them before it initialises
//! anything, and unmasks them once, at the very end of its initialisation. So the largest stack is
//! one of two:
//!
//! - the longest chain of calls of the start, plus the exceptions that cannot be masked (NMI and
//!   hard fault);
//! - what is left of the start when the interrupts are unmasked (its own frames, without those of
//!   the functions that it has called), plus every interrupt and fault that has its own handler,
//!   each once, since none interrupts itself. This is more than can happen: all of them at once,
//!   each at the deepest point of the one before.
//!
//! The machine code is checked for exactly one instruction that unmasks, and for no call after it
//! in its function; otherwise the image has no bound. Not checked: critical sections are written so
//! that each unmasks by `msr` only what it has masked itself.
//!
//! The bytes of a function are the sum over all its instructions that reserve stack, wherever they
//! are: never less than the compiler's own figure, and more if a function has several entry paths.

use std::collections::BTreeMap;

use super::code::{Code, Function};
use files::error::Error;

/// Bytes that the hardware pushes at an exception: 26 words with the floating-point registers
/// (ARMv7-M, B1.5.7), and one to align.
const FRAME: u32 = 27 * 4;

/// Exceptions that cannot be masked.
const UNMASKABLE: [&str; 2] = ["NonMaskableInt", "HardFault"];

/// Upper limit of the stack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StackBound {
    /// Largest stack of the start with masked interrupts, plus the exceptions that cannot be
    /// masked, bytes.
    pub start: u32,
    /// Name of each handler, and bytes of its chain of calls with its frame. The first entry is
    /// what is left of the start.
    pub entries: Vec<(String, u32)>,
}

impl StackBound {
    /// Returns the upper limit of an image.
    ///
    /// # Errors
    /// Returns an error if there is no bound: recursion, a stack pointer that a register moves, a
    /// call through a register, or a start that does not end with the one instruction that unmasks
    /// interrupts.
    pub fn of(code: &Code) -> Result<Self, Error> {
        let reached = code.indirect().into_iter().filter(|(_, reached)| *reached);
        let reached: Vec<&str> = reached.map(|(function, _)| function.name.as_str()).collect();
        if !reached.is_empty() {
            let names = reached.join(", ");
            return Err(Error::Emulator(format!(
                "the stack has no bound: calls through a register in {names}"
            )));
        }
        let initialises = last_unmasks(code)?;
        let mut chains = Chains { code, known: BTreeMap::new() };
        let mut all = Vec::new();
        for (index, entry) in code.entries().into_iter().enumerate() {
            let frame = if index == 0 { 0 } else { FRAME };
            all.push((entry.name.clone(), chains.below(entry)? + frame));
        }
        let through: u32 = UNMASKABLE
            .iter()
            .filter_map(|name| all.iter().find(|(entry, _)| entry.contains(name)))
            .map(|(_, bytes)| bytes)
            .sum();
        let start = all.first().map_or(0, |(_, bytes)| *bytes) + through;
        // Once more without what the initialisation has called: all of it has returned.
        let own = initialises.stack.unwrap_or(0);
        let mut chains = Chains { code, known: BTreeMap::from([(initialises.address, Some(own))]) };
        if let (Some(first), Some(reset)) = (all.first_mut(), code.entries().first()) {
            first.1 = chains.below(reset)?;
        }
        Ok(Self { start, entries: all })
    }

    /// Returns the largest stack, bytes.
    pub fn total(&self) -> u32 {
        self.start.max(self.entries.iter().map(|(_, bytes)| bytes).sum())
    }
}

/// Returns the function that unmasks the interrupts, and calls nothing after that.
fn last_unmasks(code: &Code) -> Result<&Function, Error> {
    let no = |why: String| Err(Error::Emulator(format!("the stack has no bound: {why}")));
    let all: Vec<(&Function, u32)> = code
        .functions()
        .flat_map(|function| function.unmasks.iter().map(move |address| (function, *address)))
        .collect();
    let [(function, at)] = all[..] else {
        return no(format!("{} instructions let interrupts in, instead of one", all.len()));
    };
    // What follows the instruction, up to the return, is at higher addresses: a loop back would
    // unmask twice.
    let end = function.returns.iter().find(|address| **address > at);
    match end {
        Some(end) if !function.returns_to.iter().any(|(after, _)| (at..*end).contains(after)) => {
            Ok(function)
        }
        Some(_) => no(format!("{} calls something after it has let interrupts in", function.name)),
        None => no(format!("{} lets interrupts in and does not return", function.name)),
    }
}

struct Chains<'a> {
    code: &'a Code,
    /// Bytes of each function and of everything below it; `None` while they are being determined.
    known: BTreeMap<u32, Option<u32>>,
}

impl Chains<'_> {
    fn below(&mut self, function: &Function) -> Result<u32, Error> {
        let no =
            |why: &str| Error::Emulator(format!("the stack has no bound: {} {why}", function.name));
        match self.known.get(&function.address) {
            Some(Some(bytes)) => return Ok(*bytes),
            Some(None) => return Err(no("calls itself")),
            None => {}
        }
        self.known.insert(function.address, None);
        let own = function.stack.ok_or_else(|| no("moves the stack pointer by a register"))?;
        let mut deepest = 0;
        for address in &function.calls {
            let callee = self
                .code
                .at(*address)
                .ok_or_else(|| no(&format!("calls {address:#x}, which is no function")))?;
            deepest = deepest.max(self.below(callee)?);
        }
        self.known.insert(function.address, Some(own + deepest));
        Ok(own + deepest)
    }
}
