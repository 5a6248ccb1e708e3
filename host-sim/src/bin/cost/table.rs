//! The table of costs, and the check of the budgets.

use emulator::board::CLOCK_HZ;
use emulator::firmware::budgets::{
    CONTROLLER_STATE_BYTES, CORE_INSTRUCTIONS, FLASH_BYTES, INTERRUPT_INSTRUCTIONS,
    LAW_STATE_BYTES, RAM_BYTES, of_law,
};
use emulator::probe::{PassageCost, TickCost};
use files::Error;
use stiction::ControllerState;
use stiction::control::laws::robust::RobustState;
use stiction::control::laws::robust_dual::RobustDualState;
use stiction::control::laws::{Gains, LawState};
use stiction::positioner::{PdState, PositionerState, RunawayState};

use crate::measure::CostMeasurement;

/// Returns the size of the state of a yardstick on the `positioner` interface, bytes; `None` for
/// another yardstick.
fn state_of_face(name: &str) -> Option<usize> {
    match name {
        "face-robust" => Some(size_of::<PositionerState>()),
        "face-monitor" => Some(size_of::<RunawayState>()),
        "face-pd-srnf" => Some(size_of::<PdState<()>>()),
        _ => None,
    }
}

/// Returns the size of a law's state, bytes; 0 for PD.
fn state_of(name: &str) -> usize {
    Gains::EXAMPLES.iter().find(|law| law.name() == name).map_or(0, Gains::state_bytes)
}

/// Returns the table as text.
pub fn table(measured: &CostMeasurement, compiler: &str) -> String {
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
        let state = state_of_face(name).map(|bytes| bytes.to_string()).unwrap_or_default();
        line(format!("{name:12} {} {:>23} {state:>5}", three(counts), ""));
    }
    let CostMeasurement { size, painted, bound, stack, .. } = measured;
    line(format!(
        "{:12} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>5}",
        "budget", "", "", CORE_INSTRUCTIONS, "", "", INTERRUPT_INSTRUCTIONS, LAW_STATE_BYTES
    ));
    let (core, interrupt, state) = of_law("robust");
    line(format!(
        "{:12} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>5}",
        "of robust", "", "", core, "", "", interrupt, state
    ));
    line(String::new());
    cycles(&measured.laws).into_iter().for_each(&mut line);
    line(String::new());
    line("bytes           used  budget".into());
    line(format!("flash        {:>7} {FLASH_BYTES:>7}", size.flash));
    line(format!("code         {:>7}", size.code));
    line(format!(
        "ram          {:>7} {RAM_BYTES:>7}  variables {} and room for the stack {stack}",
        ram(measured),
        size.variables
    ));
    line(format!("stack seen   {painted:>7} {stack:>7}"));
    line(format!("stack bound  {:>7} {stack:>7}", bound.total()));
    let (controller, law) = (controller_state(), size_of::<LawState>());
    line(format!(
        "state        {controller:>7} {CONTROLLER_STATE_BYTES:>7}  of a controller; a law's place \
         in it {law}"
    ));
    text
}

/// Returns the size of a controller's state in an image, bytes: that of the host without the law
/// for two encoders, and without the position of the motor.
const fn controller_state() -> usize {
    let of_two_encoders =
        size_of::<RobustDualState>() - size_of::<RobustState>() + 2 * size_of::<i32>();
    size_of::<ControllerState>() - of_two_encoders
}

/// Returns an error that names each cost over its budget.
pub fn within_budgets(measured: &CostMeasurement) -> Result<(), Error> {
    let mut over = Vec::new();
    let mut check = |what: String, found: u64, budget: u64| {
        if found > budget {
            over.push(format!("{what} {found}, allowed {budget}"));
        }
    };
    for (name, ticks) in &measured.laws {
        let [core, interrupt] =
            columns(ticks).map(|counts| counts.into_iter().max().unwrap_or(0).into());
        let (core_most, interrupt_most, state_most) = of_law(name);
        check(format!("{name}: instructions of the core's tick"), core, core_most.into());
        check(format!("{name}: instructions of the interrupt"), interrupt, interrupt_most.into());
        check(format!("{name}: bytes of state"), state_of(name) as u64, state_most as u64);
    }
    check(
        "bytes of state of a controller".into(),
        controller_state() as u64,
        CONTROLLER_STATE_BYTES as u64,
    );
    check("bytes of a law's place".into(), size_of::<LawState>() as u64, LAW_STATE_BYTES as u64);
    check("bytes of flash".into(), measured.size.flash, FLASH_BYTES);
    check("bytes of RAM".into(), ram(measured), RAM_BYTES);
    check("bytes of stack seen".into(), measured.painted.into(), measured.stack.into());
    check("bytes of stack at most".into(), measured.bound.total().into(), measured.stack.into());
    if over.is_empty() {
        Ok(())
    } else {
        Err(Error::Emulator(format!("over budget: {}", over.join("; "))))
    }
}

fn ram(measured: &CostMeasurement) -> u64 {
    measured.size.variables + u64::from(measured.stack)
}

/// Formats the estimated cycles and the time of each law's worst tick: if all instructions are
/// cached, and if no target of a jump is.
fn cycles(laws: &[(String, Vec<TickCost>)]) -> Vec<String> {
    let most = |ticks: &[TickCost], of: fn(&TickCost) -> u32| {
        let cycles = ticks.iter().map(of).max().unwrap_or(0);
        format!("{cycles:>6} {:>6.2}", f64::from(cycles) / CLOCK_HZ.get() as f64 * 1e6)
    };
    let heads = |texts: [&str; 3], width: usize| {
        let [first, second, third] = texts;
        format!("{first:12} {second:^width$}  {third:^width$}")
    };
    let kinds = format!("{:^13} {:^13}", "hits", "misses");
    let units = format!("{:>6} {:>6} {:>6} {:>6}", "cycles", "us", "cycles", "us");
    let mut lines = vec![
        heads(["estimate,", "core", "whole interrupt"], 27),
        heads(["worst tick", &kinds, &kinds], 27),
        heads(["", &units, &units], 27),
    ];
    for (name, ticks) in laws {
        let core = [
            most(ticks, |tick| tick.core.cycles.hits),
            most(ticks, |tick| tick.core.cycles.misses),
        ];
        let whole = [
            most(ticks, |tick| tick.interrupt.cycles.hits),
            most(ticks, |tick| tick.interrupt.cycles.misses),
        ];
        lines.push(format!("{name:12} {}  {}", core.join(" "), whole.join(" ")));
    }
    lines
}

fn columns(ticks: &[TickCost]) -> [Vec<u32>; 2] {
    let of = |cost: fn(&TickCost) -> PassageCost| {
        ticks.iter().map(|tick| cost(tick).instructions).collect()
    };
    [of(|tick| tick.core), of(|tick| tick.interrupt)]
}

/// Formats the least, the mean and the largest count.
fn three(counts: &[u32]) -> String {
    let (min, max) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
    let mean =
        counts.iter().map(|count| f64::from(*count)).sum::<f64>() / counts.len().max(1) as f64;
    format!("{min:>7} {mean:>7.1} {max:>7}")
}
