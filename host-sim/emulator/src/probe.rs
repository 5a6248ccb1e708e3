//! Counts the instructions of a running image, estimates their cycles, and measures the largest use
//! of its stack.
//!
//! A span begins before its first instruction and ends after its last. Instructions of an interrupt
//! within the span would be counted as well. Only the converter, the break input and the faults can
//! interrupt the control interrupt, and a run in which one of them comes meanwhile is rejected.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use rigless::emulator::{Error as HostError, Hit, Host, Watch};
use rigless::soc::Width;

use super::tracer::{Cycles, Passage, Route, Tracer};
use crate::firmware::blocks::Blocks;
use crate::firmware::{Code, Function};
use files::error::Error;

/// Word with which the stack is filled before the first instruction. It resembles no address and no
/// small number.
const PAINT: u64 = 0xA5C3_96E1;

/// The control interrupt.
const HANDLER: &str = "TIM3";
/// The converter's interrupt, which runs the current loop.
const CONVERTED: &str = "ADC";
/// The core's tick.
const CORE: &str = "stiction::servo::control";
/// Handlers that can interrupt the control interrupt.
const ABOVE: [&str; 3] = ["TIM1_BRK_TIM9", "NonMaskableInt", "HardFault"];

/// Span of instructions, by its start and its possible ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    first: u64,
    lasts: Vec<u64>,
    /// Instructions from an arrival at one of `lasts` to the end of the span.
    beyond: u64,
}

impl Span {
    /// Creates the span of an interrupt handler: to its return, which is the last instruction
    /// counted.
    ///
    /// # Errors
    /// Returns an error if the handler has no return.
    pub fn handler(function: &Function) -> Result<Self, Error> {
        let lasts: Vec<u64> = function.returns.iter().map(|address| u64::from(*address)).collect();
        if lasts.is_empty() {
            return Err(Error::Emulator(format!("{} never returns", function.name)));
        }
        Ok(Self { first: function.address.into(), lasts, beyond: 1 })
    }

    /// Creates the span of a function: to the arrival at the instruction after a call of it.
    ///
    /// # Errors
    /// Returns an error if the function is never called.
    pub fn called(code: &Code, function: &Function) -> Result<Self, Error> {
        let calls = code.functions().flat_map(|caller| &caller.returns_to);
        let lasts: Vec<u64> = calls
            .filter(|(_, callee)| *callee == function.address)
            .map(|(after, _)| u64::from(*after))
            .collect();
        if lasts.is_empty() {
            return Err(Error::Emulator(format!("{} is never called", function.name)));
        }
        Ok(Self { first: function.address.into(), lasts, beyond: 0 })
    }

    fn watches(&self) -> impl Iterator<Item = Watch> {
        std::iter::once(self.first).chain(self.lasts.iter().copied()).map(Watch::Instruction)
    }
}

/// Counter of the instructions in a span.
#[derive(Clone, Debug)]
pub struct Counter {
    span: Span,
    begun: Option<u64>,
    ended: Option<u64>,
}

impl Counter {
    /// Creates the counter of a span.
    pub const fn new(span: Span) -> Self {
        Self { span, begun: None, ended: None }
    }

    /// Starts to watch the span.
    ///
    /// # Errors
    /// Returns an error if the emulator cannot watch it.
    pub fn attach(&self, host: &mut dyn Host) -> Result<(), HostError> {
        watch(host, self.span.watches())
    }

    /// Handles a hit. At the start of a span, returns the instructions of the span before.
    pub fn hit(&mut self, hit: &Hit) -> Option<u32> {
        if hit.address == self.span.first {
            let count = self.take();
            self.begun = Some(hit.instruction_count);
            return count;
        }
        // A conditional return may not happen; the last one did.
        if self.span.lasts.contains(&hit.address) && self.begun.is_some() {
            self.ended = Some(hit.instruction_count + self.span.beyond);
        }
        None
    }

    /// Returns the instructions of the span that ended last, once.
    pub fn take(&mut self) -> Option<u32> {
        let (begun, ended) = (self.begun.take(), self.ended.take());
        u32::try_from(ended? - begun?).ok()
    }
}

fn watch(host: &mut dyn Host, watches: impl Iterator<Item = Watch>) -> Result<(), HostError> {
    for watch in watches {
        if !host.watch(watch) {
            return Err(HostError::Unwatched(watch));
        }
    }
    Ok(())
}

/// Cost of one passage through a measured span of code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassageCost {
    /// Counted instructions.
    pub instructions: u32,
    /// Estimated cycles.
    pub cycles: Cycles,
}

/// One tick of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickCost {
    /// Cost of the control interrupt, from its first instruction to its return, both included. The
    /// cycles include entry and exit.
    pub interrupt: PassageCost,
    /// Cost of the core within it: the function `servo::control` with its return, without its call.
    pub core: PassageCost,
}

/// Functions of an image whose instructions are counted.
#[derive(Clone, Debug)]
pub struct Points {
    handler: Span,
    core: Span,
    converted: Span,
    above: Vec<u64>,
    stack: Range<u64>,
    route: Arc<Route>,
    period_route: Arc<Route>,
}

/// Address of no instruction: a route without a part of its own.
const NO_PART: u32 = u32::MAX;

impl Points {
    /// Finds the functions whose instructions are counted: the control interrupt, and the core's
    /// tick in it.
    ///
    /// # Errors
    /// Returns an error if the image lacks a function or `_stack_end`, if the interrupt never
    /// returns, or if the core is never called.
    pub fn of(code: &Code) -> Result<Self, Error> {
        let above = ABOVE
            .iter()
            .map(|name| Ok(code.function(name)?.address.into()))
            .collect::<Result<_, Error>>()?;
        let end = code
            .symbol("_stack_end")
            .ok_or_else(|| Error::Emulator("the image has no _stack_end".into()))?;
        let (handler, core) = (code.function(HANDLER)?, code.function(CORE)?);
        let calls = code.functions().flat_map(|caller| &caller.returns_to);
        let route = Route {
            blocks: Blocks::below(code, handler),
            handler: handler.address..handler.address + handler.size,
            part: core.address,
            part_returns_to: calls
                .filter(|(_, to)| *to == core.address)
                .map(|(after, _)| *after)
                .collect(),
        };
        let converted = code.function(CONVERTED)?;
        let period_route = Route {
            blocks: Blocks::below(code, converted),
            handler: converted.address..converted.address + converted.size,
            part: NO_PART,
            part_returns_to: Vec::new(),
        };
        Ok(Self {
            handler: Span::handler(handler)?,
            core: Span::called(code, core)?,
            converted: Span::handler(converted)?,
            above,
            stack: end.into()..code.stack_start().into(),
            route: Arc::new(route),
            period_route: Arc::new(period_route),
        })
    }
}

/// Counters of one run, and their results.
#[derive(Clone, Debug)]
pub struct Probe {
    handler: Counter,
    core: Counter,
    converted: Counter,
    tracer: Tracer,
    period_tracer: Tracer,
    points: Arc<Points>,
    /// Cost of each period of a current loop: the converter's interrupt, as that of a tick.
    pub periods: Vec<PassageCost>,
    /// Cost of every tick in which the core ran.
    pub ticks: Vec<TickCost>,
    /// Bytes of the stack that have been written to.
    pub stack: u32,
    /// Whether something has interrupted the control interrupt.
    pub disturbed: bool,
    /// Reason why the cycles could not be estimated.
    pub trouble: Option<String>,
}

impl Probe {
    /// Creates the probe of one run.
    pub fn new(points: Arc<Points>) -> Self {
        Self {
            handler: Counter::new(points.handler.clone()),
            core: Counter::new(points.core.clone()),
            converted: Counter::new(points.converted.clone()),
            periods: Vec::new(),
            tracer: Tracer::new(points.route.clone()),
            period_tracer: Tracer::new(points.period_route.clone()),
            points,
            ticks: Vec::new(),
            stack: 0,
            disturbed: false,
            trouble: None,
        }
    }

    /// Fills the stack and starts to watch. Must be called before the first instruction.
    ///
    /// # Errors
    /// Returns an error if the emulator cannot watch or write.
    pub fn attach(&self, host: &mut dyn Host) -> Result<(), HostError> {
        for address in self.points.stack.clone().step_by(4) {
            host.write(address, Width::W32, PAINT)?;
        }
        self.handler.attach(host)?;
        self.core.attach(host)?;
        self.converted.attach(host)?;
        // Both handlers can run a block.
        let routes = [&self.points.route, &self.points.period_route];
        let begins: BTreeSet<u32> = routes.iter().flat_map(|of| of.blocks.begins()).collect();
        watch(host, begins.into_iter().map(|address| Watch::Instruction(address.into())))?;
        watch(host, self.points.above.iter().copied().map(Watch::Instruction))
    }

    /// Handles a hit.
    pub fn hit(&mut self, hit: &Hit) {
        self.disturbed |= self.points.above.contains(&hit.address);
        if let Some(interrupt) = self.handler.hit(hit) {
            self.end_interrupt(interrupt);
        }
        self.core.hit(hit);
        if let Some(instructions) = self.converted.hit(hit) {
            self.end_period(instructions);
        }
        self.tracer.hit(hit);
        self.period_tracer.hit(hit);
    }

    fn end_period(&mut self, counted: u32) {
        match self.period_tracer.take() {
            Some(Passage { whole, instructions, .. }) if instructions == counted => {
                self.periods.push(PassageCost { instructions, cycles: whole });
            }
            _ => {
                let why = self.period_tracer.trouble.take();
                let why = why.unwrap_or_else(|| "a period's path was not traced".into());
                self.trouble.get_or_insert(why);
            }
        }
    }

    fn end_interrupt(&mut self, interrupt: u32) {
        // Without a core's tick the loop is open, and the interrupt has little to do.
        let (Some(core), passage) = (self.core.take(), self.tracer.take()) else { return };
        let Some(Passage { whole, part: Some(part), instructions }) = passage else {
            let why = self.tracer.trouble.take();
            self.trouble =
                self.trouble.take().or(why).or_else(|| Some("its path was not traced".into()));
            return;
        };
        if instructions != interrupt {
            let why = format!(
                "{interrupt} instructions of an interrupt, of which {instructions} were followed"
            );
            self.trouble.get_or_insert(why);
        }
        let cost = |instructions, cycles| PassageCost { instructions, cycles };
        self.ticks.push(TickCost { interrupt: cost(interrupt, whole), core: cost(core, part) });
    }

    /// Ends the last span and measures the stack. Must be called after the last instruction.
    ///
    /// # Errors
    /// Returns an error if the emulator refuses to read its own memory.
    pub fn detach(&mut self, host: &mut dyn Host) -> Result<(), HostError> {
        if let Some(interrupt) = self.handler.take() {
            self.end_interrupt(interrupt);
        }
        let stack = self.points.stack.clone();
        self.stack = (stack.end - stack.start) as u32;
        for address in stack.step_by(4) {
            if host.read(address, Width::W32)? != PAINT {
                break;
            }
            self.stack -= 4;
        }
        Ok(())
    }
}
