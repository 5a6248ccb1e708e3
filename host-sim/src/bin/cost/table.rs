//! The table of costs, and the budgets that it has to keep.

use host_sim::Error;
use host_sim::emulator::probe::TickCost;
use stiction::ControllerState;
use stiction::compensator::{LawState, rate_variable_integral, reset_integral, reset_offset_integral};

use crate::measure::Measured;

/// Instructions of the core's tick.
const CORE: u32 = 450;
/// Instructions of the control interrupt.
const INTERRUPT: u32 = 900;
/// Bytes.
const FLASH: u64 = 64 << 10;
/// Bytes of variables and stack.
const RAM: u64 = 16 << 10;
/// Bytes of one law's state.
const LAW_STATE: usize = 64;
/// Bytes of a whole controller's.
const CONTROLLER_STATE: usize = 256;

/// The state of each law, bytes: the fields are numbers of 32 bits, so the host's sizes are the part's.
fn state_of(law: &str) -> usize {
    match law {
        "ri" => size_of::<reset_integral::State>(),
        "rvi" => size_of::<rate_variable_integral::State>(),
        "roi" => size_of::<reset_offset_integral::State>(),
        _ => 0,
    }
}

/// The table as text.
pub fn table(measured: &Measured, compiler: &str) -> String {
    let mut text = format!("compiler {compiler}\n\n");
    let mut line = |line: String| {
        text.push_str(line.trim_end());
        text.push('\n');
    };
    line(format!("{:12} {:^23} {:^23} {:>5}", "instructions", "core", "whole interrupt", "state"));
    line(format!(
        "{:12} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>5}",
        "per tick", "min", "mean", "max", "min", "mean", "max", "bytes"
    ));
    for (name, ticks) in &measured.laws {
        let [core, interrupt] = columns(ticks).map(|counts| three(&counts));
        line(format!("{name:12} {core} {interrupt} {:>5}", state_of(name)));
    }
    for (name, counts) in &measured.yardsticks {
        line(format!("{name:12} {}", three(counts)));
    }
    let Measured { size, painted, bound, stack, .. } = measured;
    line(format!(
        "{:12} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>5}",
        "budget", "", "", CORE, "", "", INTERRUPT, LAW_STATE
    ));
    line(String::new());
    line("bytes           used  budget".into());
    line(format!("flash        {:>7} {FLASH:>7}", size.flash));
    line(format!("code         {:>7}", size.code));
    line(format!(
        "ram          {:>7} {RAM:>7}  variables {} and room for the stack {stack}",
        ram(measured),
        size.variables
    ));
    line(format!("stack seen   {painted:>7} {stack:>7}"));
    line(format!("stack bound  {:>7} {stack:>7}", bound.total()));
    let (controller, law) = (size_of::<ControllerState>(), size_of::<LawState>());
    line(format!(
        "state        {controller:>7} {CONTROLLER_STATE:>7}  of a controller; a law's place in it {law}"
    ));
    text
}

/// Refuses what is over its budget, all of it at once.
pub fn within_budgets(measured: &Measured) -> Result<(), Error> {
    let mut over = Vec::new();
    let mut check = |what: String, found: u64, budget: u64| {
        if found > budget {
            over.push(format!("{what} {found}, allowed {budget}"));
        }
    };
    for (name, ticks) in &measured.laws {
        let [core, interrupt] = columns(ticks).map(|counts| counts.into_iter().max().unwrap_or(0).into());
        check(format!("{name}: instructions of the core's tick"), core, CORE.into());
        check(format!("{name}: instructions of the interrupt"), interrupt, INTERRUPT.into());
        check(format!("{name}: bytes of state"), state_of(name) as u64, LAW_STATE as u64);
    }
    check(
        "bytes of state of a controller".into(),
        size_of::<ControllerState>() as u64,
        CONTROLLER_STATE as u64,
    );
    check("bytes of a law's place".into(), size_of::<LawState>() as u64, LAW_STATE as u64);
    check("bytes of flash".into(), measured.size.flash, FLASH);
    check("bytes of RAM".into(), ram(measured), RAM);
    check("bytes of stack seen".into(), measured.painted.into(), measured.stack.into());
    check("bytes of stack at most".into(), measured.bound.total().into(), measured.stack.into());
    if over.is_empty() { Ok(()) } else { Err(Error::Emulator(format!("over budget: {}", over.join("; ")))) }
}

fn ram(measured: &Measured) -> u64 {
    measured.size.variables + u64::from(measured.stack)
}

fn columns(ticks: &[TickCost]) -> [Vec<u32>; 2] {
    [ticks.iter().map(|tick| tick.core).collect(), ticks.iter().map(|tick| tick.interrupt).collect()]
}

/// Least, mean and largest.
fn three(counts: &[u32]) -> String {
    let (min, max) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
    let mean = counts.iter().map(|count| f64::from(*count)).sum::<f64>() / counts.len().max(1) as f64;
    format!("{min:>7} {mean:>7.1} {max:>7}")
}
