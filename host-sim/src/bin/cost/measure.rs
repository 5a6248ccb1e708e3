//! Runs the benchmark of section 3.3.1 on the image, and counts.
//!
//! The joint, gains and motions are those of the experiments `step-response` and `trajectory`: seven controllers, three
//! steps and two trajectories. One key is not: `drive.pwm_hz`. Half of the emulator's time goes into a PWM of
//! 22 kHz, so it is 2 kHz here. No instruction of the control interrupt looks at that counter or depends on
//! its top, and that is checked: each controller's 2.5 deg step is run again with the PWM of the file, and must take the
//! same instructions in every tick. So is, by that, that a second run counts the same.

use std::path::Path;
use std::sync::Arc;

use host_sim::Error;
use host_sim::benchmark::plain_runs;
use host_sim::emulator::Emulation;
use host_sim::emulator::probe::{Points, TickCost};
use host_sim::emulator::yardstick;
use host_sim::experiment::{Document, RunPlan};
use host_sim::firmware::Code;
use host_sim::firmware::size::Size;
use host_sim::firmware::stack::Bound;
use host_sim::run::Trace;

/// The experiments of the benchmark.
const EXPERIMENTS: [&str; 2] = ["step-response", "trajectory"];
const FAST: &str = "drive.pwm_hz=2000";
/// What is run again.
const AGAIN: (&str, &str, &str) = ("step-response", "step-2.5", "run.duration_s=2");
/// Whose set points and positions the yardsticks are given.
const FEEDS: &str = "srnf";

/// Everything that was found.
#[derive(Debug)]
pub struct Measured {
    /// Every tick of each controller's runs, in the benchmark's order.
    pub laws: Vec<(String, Vec<TickCost>)>,
    /// Every call of each yardstick.
    pub yardsticks: Vec<(&'static str, Vec<u32>)>,
    /// Of the image.
    pub size: Size,
    /// Bytes of the stack that any run has written to.
    pub painted: u32,
    /// Bytes that it could use at most.
    pub bound: Bound,
    /// Bytes that are kept free for it.
    pub stack: u32,
}

/// Measures both images.
pub fn measure(image: &Path, yardstick: &Path) -> Result<Measured, Error> {
    let mut emulation = Emulation::new(Some(image))?;
    let code = Code::read(image, &emulation.image().elf)?;
    emulation.points = Some(Arc::new(Points::of(&code)?));
    let size = Size::of(&emulation.image().elf)
        .ok_or_else(|| Error::Emulator(format!("{}: its sections cannot be read", image.display())))?;

    let fast: Vec<RunPlan> =
        EXPERIMENTS.iter().map(|name| plans(name, &[FAST])).collect::<Result<Vec<_>, _>>()?.concat();
    let (experiment, motion, short) = AGAIN;
    let mut again = plans(experiment, &[short])?;
    again.retain(|plan| plan.label.ends_with(motion));

    let mut laws: Vec<(String, Vec<TickCost>)> = Vec::new();
    let mut samples = Vec::new();
    let mut painted = 0;
    let mut by_label = Vec::new();
    for run in emulation.run_all(&fast)? {
        let plan = &run.result.plan;
        let (ticks, stack) = counted(run.probe, &plan.label)?;
        painted = painted.max(stack);
        let name = plan.controller.clone().unwrap_or_default();
        if name == FEEDS
            && let Trace::Loop(moments) = &run.result.trace
        {
            let resolution = plan.machine.encoder.resolution_deg();
            samples.extend(moments.iter().map(|moment| {
                [moment.reference_deg as f32, (f64::from(moment.tick.counts) * resolution) as f32]
            }));
        }
        by_label.push((plan.label.clone(), ticks.clone()));
        match laws.iter_mut().find(|(known, _)| *known == name) {
            Some((_, all)) => all.extend(ticks),
            None => laws.push((name, ticks)),
        }
    }
    for run in emulation.run_all(&again)? {
        let label = &run.result.plan.label;
        let (second, stack) = counted(run.probe, label)?;
        painted = painted.max(stack);
        let first = by_label.iter().find(|(known, _)| known == label).map_or(&[][..], |(_, ticks)| ticks);
        repeats(label, first, &second)?;
    }

    let elf = std::fs::read(yardstick).map_err(|source| Error::File {
        action: "read",
        path: yardstick.into(),
        source,
    })?;
    let counts = yardstick::count(yardstick, &elf, &samples)?;
    let names = yardstick::STEPS.map(|(name, _)| name);
    Ok(Measured {
        laws,
        yardsticks: names.into_iter().zip(counts).collect(),
        size,
        painted,
        bound: Bound::of(&code)?,
        stack: stack_room(&code),
    })
}

/// Bytes between the beginning of the stack and the end of its room.
pub fn stack_room(code: &Code) -> u32 {
    code.stack_start() - code.symbol("_stack_end").unwrap_or(code.stack_start())
}

fn plans(experiment: &str, set: &[&str]) -> Result<Vec<RunPlan>, Error> {
    let mut document = Document::open(experiment)?;
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())?;
    plain_runs(&document)
}

fn counted(
    probe: Option<host_sim::emulator::probe::Probe>,
    label: &str,
) -> Result<(Vec<TickCost>, u32), Error> {
    match probe {
        Some(probe) if probe.disturbed => {
            Err(Error::Emulator(format!("{label}: the control interrupt was itself interrupted")))
        }
        Some(probe) if !probe.ticks.is_empty() => Ok((probe.ticks, probe.stack)),
        _ => Err(Error::Emulator(format!("{label}: no tick was counted"))),
    }
}

/// The last tick of the shorter run may be cut off in its interrupt.
fn repeats(label: &str, first: &[TickCost], second: &[TickCost]) -> Result<(), Error> {
    let same = first.iter().zip(second).take_while(|(a, b)| a == b).count();
    if same + 1 >= second.len() && second.len() <= first.len() && same > 0 {
        return Ok(());
    }
    Err(Error::Emulator(format!(
        "{label}: tick {same} takes {:?} in one run and {:?} in another",
        first.get(same),
        second.get(same)
    )))
}
