//! Runs the benchmark of section 3.3.1 on the image with every feature on, and counts instructions.
//!
//! The joint, gains and motions are those of the experiments `step-response` and `trajectory`:
//! every controller, three steps and two trajectories. Soft start and supply are those of
//! [`counted`]. `drive.pwm_hz` is 2 kHz: at 22 kHz the PWM would take half of the emulator's time.
//! No instruction of the control interrupt reads the PWM's counter or depends on its top. To check
//! that, each controller's 2.5 deg step runs again with the PWM of the file, and must cost the same
//! in every tick. This also checks that runs are repeatable.
//!
//! The image for two encoders runs the [example](draft::both_encoders) of such a joint: its steps,
//! its trajectory and a profiled move, under every controller of its file.

use std::path::Path;
use std::sync::Arc;

use emulator::firmware::Code;
use emulator::firmware::size::Size;
use emulator::firmware::stack::StackBound;
use emulator::probe::{PassageCost, Points, Probe, TickCost};
use emulator::{FirmwareImage, counted, yardstick};
use files::Error;
use simulator::draft;
use simulator::experiment::{
    Document, Experiment, RunPlan, every_controller, find, with_every_law,
};
use simulator::run::{RunTrace, run_all};

/// The experiments of the benchmark.
const EXPERIMENTS: [&str; 2] = ["step-response", "trajectory"];
const FAST: &str = "drive.pwm_hz=2000";
/// The step that is run again with the PWM of the file.
const AGAIN: (&str, &str, &str) = ("step-response", "step-2.5", "run.duration_s=2");
/// The step that is also run as a profiled move, and its time. Within that time the move waits for
/// the soft start of 2 s, accelerates, slows down, lands and rests.
const PROFILED: (&str, &str, &str) = ("step-response", "step-5.0", "run.duration_s=5");
/// The step of a joint with two encoders that is run again, and as a profiled move.
const STEP_OF_TWO: &str = "step-5.0";
/// The chip on the load, on a bus that a tick waits for; and the mark of its rows.
const CHIP: [&str; 2] = ["load_encoder.kind=as5047p", "load_encoder.zero_counts=0"];
pub const ON_THE_BUS: &str = "-bus";
/// The step that is run with a sensor of the motor's current, the sensor, the laws with the longest
/// ticks, and the mark of their rows.
const SENSED: (&str, &str, &str) = ("step-response", "step-5.0", "run.duration_s=4");
const SENSOR: [&str; 3] = [
    "current_sensor.full_scale_a=30",
    "current_sensor.resistance_ohm=0.5",
    "limits.back_emf_v_per_deg_per_s=0.001",
];
const WITH_SENSOR: [&str; 2] = ["observer", "robust"];
pub const SENSOR_ROW: &str = "-sensor";
/// A current loop behind that sensor, and the mark of its rows.
const LOOP: [&str; 3] = [
    "loop.effort=current",
    "current_sensor.inductance_h=0.0005",
    "current_sensor.bandwidth_hz=100",
];
pub const LOOP_ROW: &str = "-loop";
/// Time of each run of two encoders: the soft start, and two seconds of the motion.
const SECONDS_OF_TWO: &str = "run.duration_s=4";
/// Controller whose runs provide the set points and positions for the yardsticks.
const FEEDS: &str = "srnf";

/// Measured costs of the firmware and the yardsticks.
#[derive(Debug)]
pub struct CostMeasurement {
    /// Number of encoders that the image reads.
    pub encoders: u8,
    /// Every tick of each controller's runs, in the benchmark's order.
    pub laws: Vec<(String, Vec<TickCost>)>,
    /// Every period of a current loop; none in the image for two encoders.
    pub periods: Vec<PassageCost>,
    /// Every call of each yardstick; none beside the image for two encoders.
    pub yardsticks: Vec<(&'static str, Vec<u32>)>,
    /// Sizes of the image's sections.
    pub size: Size,
    /// Largest depth of the stack that any run has written to, bytes.
    pub painted: u32,
    /// Upper bound of the stack that the code can use.
    pub bound: StackBound,
    /// Room that the image reserves for the stack, bytes.
    pub stack: u32,
}

/// Measures an image, and the yardsticks if there are any.
pub fn measure(image: &Path, yardstick: Option<&Path>) -> Result<CostMeasurement, Error> {
    let image = Arc::new(FirmwareImage::open(image)?);
    let code = Code::read(&image.path, &image.elf)?;
    let points = Arc::new(Points::of(&code)?);
    let size = Size::of(&image.elf).ok_or_else(|| {
        Error::Emulator(format!("{}: its sections cannot be read", image.path.display()))
    })?;

    let encoders = image.note.encoders;
    let Motions { fast, again, profiled } =
        if encoders > 1 { Motions::of_two_encoders()? } else { Motions::of_one_encoder()? };

    let mut laws: Vec<(String, Vec<TickCost>)> = Vec::new();
    let probes = counted::count_all(&image, &points, &fast)?;
    let repeated = counted::count_all(&image, &points, &again)?;
    let moved = counted::count_all_profiled(&image, &points, &profiled)?;
    let painted =
        probes.iter().chain(&repeated).chain(&moved).map(|probe| probe.stack).max().unwrap_or(0);
    for (plan, Probe { ticks, .. }) in again.iter().zip(&repeated) {
        let is_same = |known: &RunPlan| {
            known.label == plan.label
                && known.absolute_zero() == plan.absolute_zero()
                && known.shunt() == plan.shunt()
                && known.machine.sampling == plan.machine.sampling
        };
        let first = fast.iter().zip(&probes).find(|(known, _)| is_same(known));
        repeats(&plan.label, first.map_or(&[], |(_, probe)| &probe.ticks), ticks)?;
    }
    let mut periods = Vec::new();
    let counted = fast.iter().zip(probes).chain(profiled.iter().zip(moved));
    for (plan, Probe { ticks, periods: of_loop, .. }) in counted {
        let mut name = plan.controller.clone().unwrap_or_default();
        if plan.absolute_zero().is_some() {
            name += ON_THE_BUS;
        }
        if plan.pwm_periods()?.is_some() {
            name += LOOP_ROW;
            periods.extend(of_loop);
        } else if plan.shunt().is_some() {
            name += SENSOR_ROW;
        }
        match laws.iter_mut().find(|(known, _)| *known == name) {
            Some((_, all)) => all.extend(ticks),
            None => laws.push((name, ticks)),
        }
    }

    Ok(CostMeasurement {
        encoders,
        laws,
        periods,
        yardsticks: yardstick.map_or_else(|| Ok(Vec::new()), yardsticks)?,
        size,
        painted,
        bound: StackBound::of(&code)?,
        stack: stack_room(&code),
    })
}

/// Counts every call of each yardstick.
fn yardsticks(path: &Path) -> Result<Vec<(&'static str, Vec<u32>)>, Error> {
    let read = |source| Error::File { action: "read", path: path.into(), source };
    let elf = std::fs::read(path).map_err(read)?;
    let counts = yardstick::count(path, &elf, &feed()?)?;
    Ok(yardstick::STEPS.map(|(name, _)| name).into_iter().zip(counts).collect())
}

/// Motions whose ticks are counted.
struct Motions {
    /// Steps and trajectories.
    fast: Vec<RunPlan>,
    /// Some of them, to be counted a second time.
    again: Vec<RunPlan>,
    /// Steps that become profiled moves.
    profiled: Vec<RunPlan>,
}

impl Motions {
    fn of_one_encoder() -> Result<Self, Error> {
        let mut fast = every_motion(&[&counted::EVERYTHING_ON[..], &[FAST]].concat())?;
        let sensed = one_motion(SENSED, &[&SENSOR[..], &[FAST]].concat())?;
        let regulated = one_motion(SENSED, &[&SENSOR[..], &LOOP[..], &[FAST]].concat())?;
        fast.extend(sensed.into_iter().chain(regulated).filter(|plan| {
            plan.controller.as_deref().is_some_and(|law| WITH_SENSOR.contains(&law))
        }));
        Ok(Self { fast, again: one_motion(AGAIN, &[])?, profiled: one_motion(PROFILED, &[FAST])? })
    }

    fn of_two_encoders() -> Result<Self, Error> {
        let mut document = Document::parse("both-encoders", &draft::both_encoders()?)?;
        let set = [&counted::EVERYTHING_ON[..], &[FAST, SECONDS_OF_TWO]].concat();
        document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())?;
        let mut fast = Experiment::plan(&document, &[], &[])?.runs;
        document.set(&CHIP.map(str::to_owned))?;
        fast.extend(Experiment::plan(&document, &["robust".to_owned()], &[])?.runs);
        let step = |plan: &&RunPlan| plan.label.ends_with(STEP_OF_TWO);
        let steps: Vec<RunPlan> = fast.iter().filter(step).cloned().collect();
        Ok(Self { again: steps.clone(), profiled: steps, fast })
    }
}

/// Returns the room for the stack, bytes: from the start of the stack to the end of its room.
pub fn stack_room(code: &Code) -> u32 {
    code.stack_start() - code.symbol("_stack_end").unwrap_or(code.stack_start())
}

fn plans(experiment: &str, set: &[&str]) -> Result<Vec<RunPlan>, Error> {
    let mut document = Document::parse(experiment, &with_every_law(&find(experiment)?))?;
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())?;
    let mut plans = Experiment::plan(&document, &every_controller(), &[])?.runs;
    plans.retain(RunPlan::is_plain);
    Ok(plans)
}

/// Plans one motion of an experiment under every controller, with keys set.
fn one_motion(
    (experiment, motion, short): (&str, &str, &str),
    set: &[&str],
) -> Result<Vec<RunPlan>, Error> {
    let mut plans = plans(experiment, &[&counted::EVERYTHING_ON[..], &[short], set].concat())?;
    plans.retain(|plan| plan.label.ends_with(motion));
    if plans.is_empty() {
        return Err(Error::Input(format!("{experiment}: no run is called {motion}")));
    }
    Ok(plans)
}

/// Plans all motions of the experiments under every controller, with keys set.
fn every_motion(set: &[&str]) -> Result<Vec<RunPlan>, Error> {
    Ok(EXPERIMENTS.iter().map(|name| plans(name, set)).collect::<Result<Vec<_>, _>>()?.concat())
}

/// Returns set points and positions for the yardsticks, deg: those of the loop on the host.
fn feed() -> Result<Vec<[f32; 2]>, Error> {
    let mut plans = every_motion(&[])?;
    plans.retain(|plan| plan.controller.as_deref() == Some(FEEDS));
    let mut samples = Vec::new();
    for run in run_all(&plans)? {
        let RunTrace::Loop(moments) = &run.trace else { continue };
        let resolution = run.plan.machine.encoder.resolution_deg();
        samples.extend(moments.iter().map(|moment| {
            [moment.reference_deg as f32, (f64::from(moment.tick.counts) * resolution) as f32]
        }));
    }
    Ok(samples)
}

/// Refuses a second run of a motion whose ticks have other costs than those of the first. The
/// second run may be shorter, and its last tick may be incomplete.
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
