//! The deepest that the stack can get, by the calls that the code can make.
//!
//! There is one stack. The program outside of interrupts takes what its longest chain of calls takes; every interrupt
//! and fault that has a handler of its own may come on top of it, each once, since none interrupts itself. That all of
//! them come at once, each at the deepest point of the one before, is more than can happen.
//!
//! The bytes of a function are the sum of all its instructions that take any, wherever they are: never less than the
//! compiler's own figure, and more where a function has several ways in.

use std::collections::BTreeMap;

use super::code::{Code, Function};
use crate::error::Error;

/// What an exception pushes by itself: 26 words with the floating-point registers (ARMv7-M, B1.5.7), and one to align.
const FRAME: u32 = 27 * 4;

/// A bound.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Each entry of the hardware with its own chain's bytes, its frame among them: the reset first.
    pub entries: Vec<(String, u32)>,
}

impl Bound {
    /// Of an image.
    ///
    /// # Errors
    /// If there is no bound: recursion, a stack pointer that a register moves, or a call through a register.
    pub fn of(code: &Code) -> Result<Self, Error> {
        let reached = code.indirect().into_iter().filter(|(_, reached)| *reached);
        let reached: Vec<&str> = reached.map(|(function, _)| function.name.as_str()).collect();
        if !reached.is_empty() {
            let names = reached.join(", ");
            return Err(Error::Emulator(format!(
                "the stack has no bound: calls through a register in {names}"
            )));
        }
        let mut chains = Chains { code, known: BTreeMap::new() };
        let mut entries = Vec::new();
        for (index, entry) in code.entries().into_iter().enumerate() {
            let frame = if index == 0 { 0 } else { FRAME };
            entries.push((entry.name.clone(), chains.below(entry)? + frame));
        }
        Ok(Self { entries })
    }

    /// Bytes.
    pub fn total(&self) -> u32 {
        self.entries.iter().map(|(_, bytes)| bytes).sum()
    }
}

struct Chains<'a> {
    code: &'a Code,
    /// Of a function: bytes of it and everything below it; nothing while that is being found out.
    known: BTreeMap<u32, Option<u32>>,
}

impl Chains<'_> {
    fn below(&mut self, function: &Function) -> Result<u32, Error> {
        let no = |why: &str| Error::Emulator(format!("the stack has no bound: {} {why}", function.name));
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
