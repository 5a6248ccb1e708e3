//! The table of costs, and the check of the budgets.

use emulator::board::CLOCK_HZ;
use emulator::firmware::budgets::{
    CONTROLLER_STATE_BYTES, FLASH_BYTES, LAW_STATE_BYTES, LAW_STATE_BYTES_OF_TWO, LawBudget,
    PERIOD_INSTRUCTIONS, RAM_BYTES,
};
use emulator::probe::{PassageCost, TickCost};
use emulator::tracer::Cycles;
use files::Error;
use stiction::ControllerState;
use stiction::control::current_loop::CurrentLoopState;
use stiction::control::laws::robust::RobustState;
use stiction::control::laws::robust_dual::RobustDualState;
use stiction::control::laws::{Gains, LawState};
use stiction::positioner::{PdState, PositionerState, RunawayState};

use crate::measure::{CostMeasurement, LOOP_ROW, ON_THE_BUS, SENSOR_ROW};
use crate::nesting::Nesting;

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

/// Returns the size of a law's state in an image for this number of encoders, bytes; 0 for PD.
fn state_of(name: &str, encoders: u8) -> usize {
    if name.starts_with("robust") && encoders > 1 {
        return size_of::<RobustDualState>();
    }
    let name = name.trim_end_matches(SENSOR_ROW).trim_end_matches(LOOP_ROW);
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
        line(format!("{name:12} {core} {interrupt} {:>5}", state_of(name, measured.encoders)));
    }
    if !measured.periods.is_empty() {
        let counts: Vec<u32> = measured.periods.iter().map(|of| of.instructions).collect();
        let counts = three(&counts);
        line(format!(
            "{:12} {:>23} {counts} {:>5}",
            "loop, a period",
            "",
            size_of::<CurrentLoopState>()
        ));
    }
    for (name, counts) in &measured.yardsticks {
        let state = state_of_face(name).map(|bytes| bytes.to_string()).unwrap_or_default();
        line(format!("{name:12} {} {:>23} {state:>5}", three(counts), ""));
    }
    let CostMeasurement { size, painted, bound, stack, .. } = measured;
    let with_bus = format!("robust{ON_THE_BUS}");
    let mut heads = vec![("budget", ""), ("of robust", "robust")];
    if measured.encoders > 1 {
        heads.push(("on a bus", &with_bus));
    } else {
        heads.extend([("with sensor", "-sensor"), ("of robust", "robust-sensor")]);
        heads.extend([("with loop", "-loop"), ("of robust", "robust-loop")]);
    }
    for (head, law) in heads {
        let LawBudget { core, interrupt, state } = LawBudget::of(law, measured.encoders);
        let core = core.map(|core| core.to_string()).unwrap_or_default();
        line(format!(
            "{head:12} {:>7} {:>7} {core:>7} {:>7} {:>7} {interrupt:>7} {state:>5}",
            "", "", "", ""
        ));
    }
    if !measured.periods.is_empty() {
        line(format!("{:12} {PERIOD_INSTRUCTIONS:>47}", "of a period"));
    }
    line(String::new());
    cycles(measured).into_iter().for_each(&mut line);
    line(String::new());
    if let Some(nesting) = Nesting::of(measured) {
        nesting.lines().into_iter().for_each(&mut line);
        line(String::new());
    }
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
    let (controller, law) = (controller_state(measured.encoders), size_of::<LawState>());
    let budget = controller_budget(measured.encoders);
    line(format!(
        "state        {controller:>7} {budget:>7}  of a controller; a law's place in it {law}"
    ));
    text
}

/// What two encoders add to the state of a controller, bytes: the difference of both laws that
/// stand alone, the position of the motor, and whether it is known.
const OF_TWO_ENCODERS: usize =
    size_of::<RobustDualState>() - size_of::<RobustState>() + 2 * size_of::<i32>();

/// Returns the size of a controller's state in an image, bytes. The host has that of two encoders.
const fn controller_state(encoders: u8) -> usize {
    size_of::<ControllerState>() - if encoders > 1 { 0 } else { OF_TWO_ENCODERS }
}

/// Returns the limit of a controller's state, bytes: with two encoders, the larger law has its own.
const fn controller_budget(encoders: u8) -> usize {
    CONTROLLER_STATE_BYTES
        + if encoders > 1 { LAW_STATE_BYTES_OF_TWO - size_of::<RobustState>() + 8 } else { 0 }
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
        let budget = LawBudget::of(name, measured.encoders);
        if let Some(most) = budget.core {
            check(format!("{name}: instructions of the core's tick"), core, most.into());
        }
        let most = budget.interrupt.into();
        check(format!("{name}: instructions of the interrupt"), interrupt, most);
        let state = state_of(name, measured.encoders);
        check(format!("{name}: bytes of state"), state as u64, budget.state as u64);
    }
    let period = measured.periods.iter().map(|of| of.instructions).max().unwrap_or(0);
    check("instructions of a period".into(), period.into(), PERIOD_INSTRUCTIONS.into());
    check(
        "bytes of state of a controller".into(),
        controller_state(measured.encoders) as u64,
        controller_budget(measured.encoders) as u64,
    );
    check("bytes of a law's place".into(), size_of::<LawState>() as u64, LAW_STATE_BYTES as u64);
    check("bytes of flash".into(), measured.size.flash, FLASH_BYTES);
    check("bytes of RAM".into(), ram(measured), RAM_BYTES);
    check("bytes of stack seen".into(), measured.painted.into(), measured.stack.into());
    check("bytes of stack at most".into(), measured.bound.total().into(), measured.stack.into());
    if let Some(nesting) = Nesting::of(measured) {
        over.extend(nesting.over_bars());
    }
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
fn cycles(measured: &CostMeasurement) -> Vec<String> {
    let with_time = |cycles: u32| format!("{cycles:>6} {:>6.2}", microseconds(cycles));
    let most = |ticks: &[TickCost], of: fn(&TickCost) -> u32| {
        with_time(ticks.iter().map(of).max().unwrap_or(0))
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
    for (name, ticks) in &measured.laws {
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
    if !measured.periods.is_empty() {
        let of_periods = |of: fn(&Cycles) -> u32| {
            with_time(measured.periods.iter().map(|period| of(&period.cycles)).max().unwrap_or(0))
        };
        let whole = [of_periods(|cycles| cycles.hits), of_periods(|cycles| cycles.misses)];
        lines.push(format!("{:12} {:27}  {}", "loop, period", "", whole.join(" ")));
    }
    lines
}

/// Returns the time of a number of cycles, us.
fn microseconds(cycles: u32) -> f64 {
    f64::from(cycles) / CLOCK_HZ.get() as f64 * 1e6
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
