//! The functions of an image, read from its symbols and its machine code.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use super::thumb::{ControlFlow, Instruction, Stack};
use files::error::Error;

/// `cpsie i`.
const UNMASK: u16 = 0xB662;

/// One function.
#[derive(Clone, Debug, Default)]
pub struct Function {
    /// Mangled name, as in the symbol table.
    pub name: String,
    /// Address of its first instruction.
    pub address: u32,
    /// Bytes of code.
    pub size: u32,
    /// Addresses of the functions that it calls or jumps to.
    pub calls: BTreeSet<u32>,
    /// Return address of each of its calls, and address of the called function.
    pub returns_to: Vec<(u32, u32)>,
    /// Addresses of its instructions that return to a caller.
    pub returns: Vec<u32>,
    /// Addresses of its calls and jumps through a register.
    pub indirect: Vec<u32>,
    /// Addresses of its instructions that enable interrupts (`cpsie i`).
    pub unmasks: Vec<u32>,
    /// Bytes of stack: the sum over all its instructions that reserve stack. `None` if the number
    /// is in a register.
    pub stack: Option<u32>,
}

/// All functions of an image.
#[derive(Clone, Debug)]
pub struct Code {
    functions: BTreeMap<u32, Function>,
    vectors: Vec<u32>,
    symbols: BTreeMap<String, u32>,
    text: Text,
}

/// The section of machine code.
#[derive(Clone, Debug)]
struct Text {
    start: u32,
    bytes: Vec<u8>,
    /// Addresses from which on the section has code (true) or data (false).
    marks: BTreeMap<u32, bool>,
}

impl Text {
    fn halfword(&self, address: u32) -> Option<u16> {
        let offset = address.checked_sub(self.start)? as usize;
        let pair = self.bytes.get(offset..offset + 2)?;
        Some(u16::from_le_bytes(pair.try_into().ok()?))
    }

    fn is_code(&self, address: u32) -> bool {
        self.marks.range(..=address).next_back().is_none_or(|(_, is_code)| *is_code)
    }
}

/// Instruction with its address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacedInstruction {
    /// Address of the instruction.
    pub address: u32,
    /// Its two halfwords; the second one belongs to it only if it is a long one.
    pub halfwords: (u16, u16),
    /// Decoded instruction.
    pub instruction: Instruction,
}

impl PlacedInstruction {
    /// Returns the address after the instruction.
    pub const fn end(&self) -> u32 {
        self.address + self.instruction.size
    }
}

impl Code {
    /// Reads an ELF file; `path` is for messages.
    ///
    /// # Errors
    /// Returns an error if the file is not an ELF file, or if its symbols have been stripped, so
    /// that its functions cannot be found.
    pub fn read(path: &Path, elf: &[u8]) -> Result<Self, Error> {
        let no = |why: &str| Error::Emulator(format!("{}: {why}", path.display()));
        let file = object::File::parse(elf).map_err(|_| no("it is not an ELF file"))?;
        let text = file.section_by_name(".text").ok_or_else(|| no("it has no section .text"))?;
        let (start, bytes) =
            (text.address() as u32, text.data().map_err(|error| no(&error.to_string()))?);
        let vectors = file.section_by_name(".vector_table").and_then(|section| section.data().ok());
        let vectors = vectors.ok_or_else(|| no("it has no section .vector_table"))?;
        let word = |bytes: &[u8]| bytes.try_into().map_or(0, u32::from_le_bytes);
        let vectors: Vec<u32> = vectors.chunks(4).map(word).collect();

        let mut marks = BTreeMap::new();
        let mut sizes: BTreeMap<u32, (u32, String)> = BTreeMap::new();
        let mut symbols = BTreeMap::new();
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let address = symbol.address() as u32;
            // Mapping symbols of the ARM ABI: from here on it is code, or data.
            if name.starts_with("$t") || name.starts_with("$d") {
                marks.insert(address, name.starts_with("$t"));
                continue;
            }
            symbols.insert(name.to_owned(), address);
            if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                let known = sizes.entry(address & !1).or_insert((0, String::new()));
                if symbol.size() as u32 > known.0 {
                    *known = (symbol.size() as u32, name.to_owned());
                }
            }
        }
        let covered: u32 = sizes.values().map(|(size, _)| size).sum();
        // Only alignment between functions is not covered by symbols.
        if marks.is_empty() || u64::from(covered) < text.size() * 9 / 10 {
            return Err(no("its symbols have been stripped, so its functions cannot be analysed"));
        }
        let text = Text { start, bytes: bytes.to_vec(), marks };
        let mut code = Self { functions: BTreeMap::new(), vectors, symbols, text };
        for (address, (size, name)) in sizes {
            let function = Function { name, address, size, stack: Some(0), ..Function::default() };
            let function = code.instructions(&function).fold(function.clone(), Function::with);
            code.functions.insert(address, function);
        }
        Ok(code)
    }

    /// Returns the instructions of a function in the order of their addresses.
    pub fn instructions(&self, function: &Function) -> impl Iterator<Item = PlacedInstruction> {
        let (mut address, end) = (function.address, function.address + function.size);
        std::iter::from_fn(move || {
            while address < end && !self.text.is_code(address) {
                address += 2;
            }
            let first = self.text.halfword(address).filter(|_| address < end)?;
            let second = self.text.halfword(address + 2).unwrap_or(0);
            let instruction = Instruction::decode(address, first, second);
            let placed = PlacedInstruction { address, halfwords: (first, second), instruction };
            address = placed.end();
            Some(placed)
        })
    }

    /// Returns the halfwords of the data at an address, up to the next code.
    pub fn data(&self, address: u32) -> impl Iterator<Item = u16> {
        let data = (address..).step_by(2).take_while(|at| !self.text.is_code(*at));
        data.map_while(|at| self.text.halfword(at))
    }

    /// Returns all functions.
    pub fn functions(&self) -> impl Iterator<Item = &Function> {
        self.functions.values()
    }

    /// Returns the function that contains an address.
    pub fn at(&self, address: u32) -> Option<&Function> {
        let (_, function) = self.functions.range(..=address & !1).next_back()?;
        (address & !1 < function.address + function.size).then_some(function)
    }

    /// Returns the names of all symbols.
    pub fn symbols(&self) -> impl Iterator<Item = &str> {
        self.symbols.keys().map(String::as_str)
    }

    /// Returns the address of a symbol by its plain name.
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).map(|address| *address & !1)
    }

    /// Returns the address of a variable by its path.
    ///
    /// # Errors
    /// Returns an error if there is no such variable.
    pub fn variable(&self, path: &str) -> Result<u32, Error> {
        let mangled = mangled(path);
        let found = self.symbols.iter().find(|(name, _)| name.contains(&mangled));
        let no = || Error::Emulator(format!("the image has no variable {path}"));
        found.map(|(_, address)| *address).ok_or_else(no)
    }

    /// Returns the function of a path such as `stiction::servo::control`, or of a plain name.
    ///
    /// # Errors
    /// Returns an error if there is no such function, or more than one.
    pub fn function(&self, path: &str) -> Result<&Function, Error> {
        if let Some(function) = self.symbol(path).and_then(|address| self.at(address)) {
            return Ok(function);
        }
        let mangled = mangled(path);
        let mut found = self.functions().filter(|function| function.name.contains(&mangled));
        match (found.next(), found.next()) {
            (Some(function), None) => Ok(function),
            (None, _) => Err(Error::Emulator(format!("the image has no function {path}"))),
            (Some(_), Some(_)) => {
                Err(Error::Emulator(format!("the image has two functions {path}")))
            }
        }
    }

    /// Returns the handlers in the vector table, that of the reset first.
    pub fn entries(&self) -> Vec<&Function> {
        let mut seen = BTreeSet::new();
        // The first word is the start of the stack.
        let vectors = self.vectors.iter().skip(1).filter(|vector| **vector != 0);
        vectors.filter_map(|vector| self.at(*vector)).filter(|f| seen.insert(f.address)).collect()
    }

    /// Returns the start of the stack.
    pub fn stack_start(&self) -> u32 {
        self.vectors.first().copied().unwrap_or(0)
    }

    /// Returns a function and all functions that it can call, directly or not. Calls through
    /// registers are not followed: [`indirect`](Self::indirect) lists them.
    pub fn reachable<'a>(&'a self, from: &'a Function) -> Vec<&'a Function> {
        let mut seen = BTreeSet::from([from.address]);
        let mut waiting = VecDeque::from([from]);
        let mut found = Vec::new();
        while let Some(function) = waiting.pop_front() {
            found.push(function);
            for callee in function.calls.iter().filter_map(|address| self.at(*address)) {
                if seen.insert(callee.address) {
                    waiting.push_back(callee);
                }
            }
        }
        found
    }

    /// Returns the functions with calls or jumps through a register, and whether each can be
    /// reached from a handler by direct calls.
    pub fn indirect(&self) -> Vec<(&Function, bool)> {
        let reached: BTreeSet<u32> = self
            .entries()
            .into_iter()
            .flat_map(|entry| self.reachable(entry))
            .map(|f| f.address)
            .collect();
        let with = self.functions().filter(|function| !function.indirect.is_empty());
        with.map(|function| (function, reached.contains(&function.address))).collect()
    }
}

/// Returns a path as it is in a symbol: both of Rust's manglings write the length and the name of
/// each part.
fn mangled(path: &str) -> String {
    path.split("::").map(|part| format!("{}{part}", part.len())).collect()
}

impl Function {
    /// Adds the effect of one of its instructions.
    fn with(mut self, placed: PlacedInstruction) -> Self {
        let PlacedInstruction { address, halfwords: (first, _), instruction } = placed;
        match instruction.flow {
            ControlFlow::Call(target) => {
                self.calls.insert(target);
                self.returns_to.push((placed.end(), target));
            }
            // To another function: a call that returns to this one's caller.
            ControlFlow::Branch(target)
                if !(self.address..self.address + self.size).contains(&target) =>
            {
                self.calls.insert(target);
            }
            ControlFlow::Return => self.returns.push(address),
            ControlFlow::CallRegister | ControlFlow::JumpRegister => self.indirect.push(address),
            ControlFlow::Branch(_) | ControlFlow::On => {}
        }
        if first == UNMASK {
            self.unmasks.push(address);
        }
        self.stack = match instruction.stack {
            Stack::Kept => self.stack,
            Stack::Takes(bytes) => self.stack.map(|sum| sum + bytes),
            Stack::Unknown => None,
        };
        self
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Creates functions that follow each other from an address on; `marks` are the starts of code
    /// and data.
    pub fn code(start: u32, marks: &[(u32, bool)], functions: &[(&str, &[u16])]) -> Code {
        let bytes: Vec<u8> = functions
            .iter()
            .flat_map(|(_, code)| code.iter().flat_map(|half| half.to_le_bytes()))
            .collect();
        let text = Text { start, bytes, marks: marks.iter().copied().collect() };
        let (vectors, symbols) = (Vec::new(), BTreeMap::new());
        let mut all = Code { functions: BTreeMap::new(), vectors, symbols, text };
        let mut address = start;
        for (name, code) in functions {
            let size = 2 * code.len() as u32;
            let function = Function {
                name: (*name).to_owned(),
                address,
                size,
                stack: Some(0),
                ..Function::default()
            };
            let function = all.instructions(&function).fold(function.clone(), Function::with);
            all.symbols.insert(function.name.clone(), address);
            all.functions.insert(address, function);
            address += size;
        }
        all
    }
}
