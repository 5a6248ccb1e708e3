//! The deepest that the stack can get, by the calls that the code can make.
//!
//! There is one stack. The start runs with interrupts masked: RTIC masks them before it initialises
//! anything, and the very last thing that its initialisation does is to unmask them, once and for
//! good. So the deepest is one of two:
//!
//! - the longest chain of calls of the start, and on top of it the exceptions that no mask holds
//!   (NMI and hard fault);
//! - what is left of the start when the interrupts are let in (its own frames, without those of
//!   what it has called), and on top of it every interrupt and fault that has a handler of its own,
//!   each once, since none interrupts itself. That all of them come at once, each at the deepest
//!   point of the one before, is more than can happen.
//!
//! That there is one instruction that unmasks, and that its function calls nothing after it, is
//! read from the machine code; an image of which that is not true has no bound. That nothing
//! unmasks by `msr` what it has not masked itself is how critical sections are written, and is not
//! looked for.
//!
//! The bytes of a function are the sum of all its instructions that take any, wherever they are:
//! never less than the compiler's own figure, and more where a function has several ways in.

use std::collections::BTreeMap;

use super::code::{Code, Function};
use files::error::Error;

/// What an exception pushes by itself: 26 words with the floating-point registers (ARMv7-M,
/// B1.5.7), and one to align.
const FRAME: u32 = 27 * 4;

/// Exceptions that come through any mask.
const UNMASKABLE: [&str; 2] = ["NonMaskableInt", "HardFault"];

/// Upper limit of the stack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StackBound {
    /// Largest stack of the start with masked interrupts, plus the exceptions that cannot be
    /// masked, bytes.
    pub start: u32,
    /// Each entry of the hardware with its own chain's bytes, its frame among them: what is left of
    /// the start first.
    pub entries: Vec<(String, u32)>,
}

impl StackBound {
    /// Of an image.
    ///
    /// # Errors
    /// If there is no bound: recursion, a stack pointer that a register moves, a call through a
    /// register, or a start that does not end with the one instruction that lets interrupts in.
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

    /// Bytes.
    pub fn total(&self) -> u32 {
        self.start.max(self.entries.iter().map(|(_, bytes)| bytes).sum())
    }
}

/// The function that lets the interrupts in, and calls nothing after that.
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
    /// Of a function: bytes of it and everything below it; nothing while that is being found out.
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
