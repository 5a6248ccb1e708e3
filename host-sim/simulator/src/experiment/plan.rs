//! Plans the runs of a document.

use std::collections::BTreeSet;
use std::sync::Arc;

use stiction::control::drive::{DriveConfig, PwmMode};
use stiction::units::value::Table as _;
use toml::{Table, Value};

use super::task::Task;
use crate::supply::SupplyCourse;
use dynamics::joint::Substitute;
use files::data_sheet::tables::DrivenBy;
use files::data_sheet::{OF_A_SHEET, UnseenSlack};
use files::document::{Document, Origin, within};
use files::error::{Error, rounded, shown, suggestion};
use files::machine::{AxisSolverName, MachineFile, Variant};
use files::typed_number::of_value as number;

/// Largest number of samples of all runs together: a gigabyte of memory.
pub(super) const MAX_SAMPLES: f64 = 1e7;

/// Largest number of samples of all ramps together. More are allowed than of closed loops, since
/// ramps end much earlier than their longest time.
pub(super) const MAX_RAMP_SAMPLES: f64 = 1e8;

/// Largest number of steps of `rk4` in all runs together: some minutes.
const MAX_STEPS: f64 = 1e10;

/// The runs of a machine's file.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Name of a built-in experiment, or path of a file.
    pub name: String,
    /// Table or section of the thesis.
    pub source: String,
    /// Runs, in the order of the file.
    pub runs: Vec<RunPlan>,
    /// Sentences about parts of the file that were left out.
    pub left_out: Vec<String>,
    /// Slack of the gear that the encoder cannot measure; `None` without a data sheet.
    pub unseen_slack: Option<UnseenSlack>,
}

/// One run: a machine, one of its controllers, and a task.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// Name of the run in all output, such as `srnf/step-5.0/test-2`.
    pub label: String,
    /// File and assignments, for messages.
    pub origin: Origin,
    /// Key of the task, for messages: `reference.steps_deg[0]`.
    pub asked_by: String,
    /// Machine, with the keys of the variant.
    pub machine: Arc<MachineFile>,
    /// Name of the controller; `None` for a ramp.
    pub controller: Option<String>,
    /// Task of the joint.
    pub task: Task,
    /// Slug of the variant; empty for a run without variant.
    pub variant: String,
    /// Joint that replaces that of the file.
    pub substitute: Option<Substitute>,
    /// Run of another file, whose plant replaces this one's in a simulated device
    /// ([`with_truth`](Self::with_truth)).
    pub truth: Option<Box<Self>>,
    /// Supply of the bridge; `None`: the nominal one. A run has it, and a device has not.
    pub supply: Option<SupplyCourse>,
    /// Edge of a homing switch that replaces that of the data sheet, deg.
    pub home_switch_deg: Option<f64>,
}

impl RunPlan {
    /// Returns this run with another supply of its bridge.
    ///
    /// # Errors
    /// Returns an error if the run has an amplifier, whose effort does not follow its supply.
    pub fn with_supply(self, supply: SupplyCourse) -> Result<Self, Error> {
        let is_analog = self.machine.drive.core(DriveConfig::EXAMPLE).mode == PwmMode::Analog;
        let motor = self.machine.motor.as_ref();
        let key = if is_analog {
            "drive.mode"
        } else if motor.is_some_and(|motor| motor.driven_by == DrivenBy::Current) {
            "motor.driven_by"
        } else {
            return Ok(Self { supply: Some(supply), ..self });
        };
        Err(Error::Input(format!(
            "{}: another supply needs a bridge, whose effort follows it; `{key}` is an amplifier",
            self.origin.of(key)
        )))
    }

    /// Returns the slugs that distinguish this run from others of the same controller and task: its
    /// variant, and a sample of delay.
    pub fn slugs(&self) -> Vec<&str> {
        slugs(&self.variant, &self.machine, self.controller.is_some())
    }

    /// Returns whether this run has a controller, but neither variant nor delay.
    pub fn is_plain(&self) -> bool {
        self.slugs().is_empty() && self.controller.is_some()
    }
}

fn slugs<'a>(variant: &'a str, machine: &MachineFile, sampled: bool) -> Vec<&'a str> {
    let delayed = sampled && machine.run.delay_samples == 1;
    [variant, if delayed { "delay-1" } else { "" }]
        .into_iter()
        .filter(|slug| !slug.is_empty())
        .collect()
}

impl Experiment {
    /// Plans all runs of a document, for the `wanted` controllers, or else those of the document.
    ///
    /// `fixed` are keys that the user has set: a variant that sets one of them to another value is
    /// left out.
    ///
    /// # Errors
    /// Returns an error about an unknown controller, an invalid value in any of the runs, or a
    /// document without runs.
    pub fn plan(document: &Document, wanted: &[String], fixed: &[String]) -> Result<Self, Error> {
        let machine = document.machine()?;
        let wanted: Vec<&str> = wanted.iter().map(|name| name.trim()).collect();
        let mut runs = Vec::new();
        let (machine, left_out) = without_stale_variants(document, machine)?;
        for (name, variant) in variants(document, &machine, fixed)? {
            let (origin, machine) = if variant.set.is_empty() {
                (document.origin.clone(), machine.clone())
            } else {
                let with = document.with(&name, &variant.set)?;
                (with.origin.clone(), with.machine()?)
            };
            runs.extend(runs_of(machine, &origin, &variant.slug, &wanted)?);
        }
        if runs.is_empty() {
            let all = "`reference.steps_deg`, `reference.trajectories`, \
                `reference.sines` or `identification.ramp_rates_v_per_s`";
            let origin = document.origin.of("reference");
            return Err(Error::Input(format!(
                "{origin}: there is nothing to run: add an entry to {all}"
            )));
        }
        for run in &runs {
            run.validate()?;
        }
        if let Some(label) = doubled(&runs) {
            let why =
                "steps, trajectories, sines and variants need different sizes, speeds and slugs";
            return Err(Error::Input(format!(
                "{}: two runs have the name `{label}`; {why}",
                document.origin.of("reference")
            )));
        }
        affordable(&document.origin, &runs)?;
        let (name, unseen_slack) = (document.origin.name.clone(), document.unseen_slack()?);
        Ok(Self { name, source: machine.source, runs, left_out, unseen_slack })
    }

    /// Plans the runs of a document without its variants. A variant can have another joint, and
    /// override drawn or assigned values.
    ///
    /// # Errors
    /// As [`plan`](Self::plan); also if the document has variants only.
    pub fn without_variants(document: &Document, wanted: &[String]) -> Result<Vec<RunPlan>, Error> {
        let all = Self::plan(document, wanted, &[])?.runs;
        let (runs, others): (Vec<RunPlan>, Vec<RunPlan>) =
            all.into_iter().partition(|run| run.variant.is_empty() && run.controller.is_some());
        if !runs.is_empty() {
            return Ok(runs);
        }
        let mut slugs: Vec<&str> = others.iter().map(|run| run.variant.as_str()).collect();
        slugs.retain(|slug| !slug.is_empty());
        slugs.dedup();
        let origin = &document.origin;
        Err(Error::Input(if slugs.is_empty() {
            format!(
                "{origin}: there is no motion: `reference.steps_deg`, `reference.trajectories` and \
                 `reference.sines` are empty"
            )
        } else {
            format!(
                "{origin}: the file has variants only (`{}`), but this command needs a run without \
                 variant; add a `[[variant]]` with `slug = \"\"`, or remove the variants",
                slugs.join("`, `")
            )
        }))
    }

    /// Returns the run that configures a device: the first without variant, or else the first.
    /// `None` without runs, which [`plan`](Self::plan) refuses.
    pub fn into_first(mut self) -> Option<RunPlan> {
        let plain = self.runs.iter().position(|run| run.variant.is_empty()).unwrap_or(0);
        (plain < self.runs.len()).then(|| self.runs.swap_remove(plain))
    }
}

/// Removes variants that no longer fit the document, for example after copying a file: those of a
/// missing controller, and those of a key that is derived from a data sheet. Any other unknown key
/// is an error.
fn without_stale_variants(
    document: &Document,
    mut machine: MachineFile,
) -> Result<(MachineFile, Vec<String>), Error> {
    let of_a_sheet = document.data_sheet()?.is_some();
    let mut left_out = Vec::new();
    let mut number = 0;
    machine.variant.retain(|variant| {
        number += 1;
        let stale =
            variant.set.keys().find_map(|key| match key.split('.').collect::<Vec<_>>()[..] {
                ["controller", name, ..]
                    if document.get(&format!("controller.{name}")).is_none() =>
                {
                    Some(format!("`{key}`, but there is no `[controller.{name}]`"))
                }
                _ if of_a_sheet && OF_A_SHEET.contains(&key.as_str()) => {
                    Some(format!("`{key}`, which is derived from the data sheet"))
                }
                _ => None,
            });
        let Some(why) = stale else { return true };
        let name = if variant.slug.is_empty() { number.to_string() } else { variant.slug.clone() };
        left_out.push(format!("{}: variant {name} is left out: it sets {why}", document.origin));
        false
    });
    Ok((machine, left_out))
}

/// Returns the variants that do not contradict the assignments, and their names for messages.
fn variants(
    document: &Document,
    machine: &MachineFile,
    fixed: &[String],
) -> Result<Vec<(String, Variant)>, Error> {
    if machine.variant.is_empty() {
        return Ok(vec![(String::new(), Variant { slug: String::new(), set: Table::new() })]);
    }
    let contradicted = |variant: &Variant| {
        variant.set.iter().find_map(|(key, value)| {
            let by_hand = fixed.iter().find(|fixed| within(key, fixed))?;
            (!same(document.get(key)?, value)).then_some(by_hand)
        })
    };
    let named = |(i, variant): (usize, &Variant)| {
        let name = if variant.slug.is_empty() {
            (i + 1).to_string()
        } else {
            format!("`{}`", variant.slug)
        };
        (name, variant.clone())
    };
    let all = machine.variant.iter().enumerate();
    let kept: Vec<_> =
        all.filter(|(_, variant)| contradicted(variant).is_none()).map(named).collect();
    match machine.variant.iter().find_map(contradicted) {
        Some(key) if kept.is_empty() => {
            let origin = document.origin.of(key);
            let why = "every variant of this experiment sets it to another value";
            Err(Error::Input(format!("{origin}: `{key}` cannot be set, since {why}")))
        }
        _ => Ok(kept),
    }
}

/// Returns whether two values are equal in a machine's file, where 5 equals 5.0.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        _ => a == b || number(a).is_some_and(|a| number(b) == Some(a)),
    }
}

fn runs_of(
    machine: MachineFile,
    origin: &Origin,
    slug: &str,
    wanted: &[&str],
) -> Result<Vec<RunPlan>, Error> {
    let machine = Arc::new(machine);
    let steps = machine.reference.steps_deg.iter().copied().map(Task::Step);
    let trajectories = machine.reference.trajectories.iter().cloned().map(Task::Trajectory);
    let sines = machine.reference.sines.iter().cloned().map(Task::Sine);
    let asked = |key: &'static str| move |(i, task): (usize, Task)| (format!("{key}[{i}]"), task);
    let tasks: Vec<(String, Task)> = steps
        .enumerate()
        .map(asked("reference.steps_deg"))
        .chain(trajectories.enumerate().map(asked("reference.trajectories")))
        .chain(sines.enumerate().map(asked("reference.sines")))
        .collect();
    let mut runs = Vec::new();
    let mut add = |controller: Option<&str>, asked_by: String, task: Task| {
        let driven_by = controller.unwrap_or("ramp");
        let task_slug = task.slug();
        let mut label = vec![driven_by, &task_slug];
        label.extend(slugs(slug, &machine, controller.is_some()));
        runs.push(RunPlan {
            label: label.join("/"),
            origin: origin.clone(),
            asked_by,
            machine: machine.clone(),
            controller: controller.map(str::to_owned),
            task,
            variant: slug.into(),
            substitute: None,
            truth: None,
            supply: None,
            home_switch_deg: None,
        });
    };
    let names = controllers(&machine, origin, wanted)?;
    if names.is_empty() && !tasks.is_empty() {
        let origin = origin.of("loop.controller");
        return Err(Error::Input(format!(
            "{origin}: `loop.controller` is empty; must be at least one name"
        )));
    }
    for name in names {
        for (asked_by, task) in &tasks {
            add(Some(name), asked_by.clone(), task.clone());
        }
    }
    let rates = machine.identification.iter().flat_map(|ramps| &ramps.ramp_rates_v_per_s).copied();
    for (asked_by, task) in
        rates.map(Task::Ramp).enumerate().map(asked("identification.ramp_rates_v_per_s"))
    {
        add(None, asked_by, task);
    }
    Ok(runs)
}

/// Returns the names of the controllers to run, and checks that each has a table.
fn controllers<'a>(
    machine: &'a MachineFile,
    origin: &Origin,
    wanted: &[&'a str],
) -> Result<Vec<&'a str>, Error> {
    let by_file = machine.sampling.extras.list().iter().map(String::as_str);
    let names: Vec<&str> = if wanted.is_empty() { by_file.collect() } else { wanted.to_vec() };
    for (i, name) in names.iter().enumerate() {
        let known = machine.controller.contains_key(*name);
        if known && !names[..i].contains(name) {
            continue;
        }
        let near = suggestion(name, machine.controller.keys().map(String::as_str));
        return Err(Error::Input(match (wanted.is_empty(), known) {
            (true, true) => {
                format!("{}: `loop.controller` names `{name}` twice", origin.of("loop.controller"))
            }
            (true, false) => {
                let origin = origin.of("loop.controller");
                format!(
                    "{origin}: `loop.controller` names `{name}`, which has no table \
                     `[controller.{name}]`{near}"
                )
            }
            (false, true) => format!("--controller {}: `{name}` is listed twice", wanted.join(",")),
            (false, false) => {
                format!(
                    "--controller {}: there is no controller `{name}` in {origin}{near}",
                    wanted.join(",")
                )
            }
        }));
    }
    Ok(names)
}

fn doubled(runs: &[RunPlan]) -> Option<&str> {
    let mut labels = BTreeSet::new();
    runs.iter().map(|run| run.label.as_str()).find(|label| !labels.insert(*label))
}

/// Refuses runs that would need too much memory or time.
fn affordable(origin: &Origin, runs: &[RunPlan]) -> Result<(), Error> {
    // The limits in messages are rounded to lie within the true ones.
    const WITHIN: f64 = 0.999;
    let samples = |run: &RunPlan| run.longest_s() / run.machine.sampling.sample_time_s();
    let (ramps, loops): (Vec<&RunPlan>, Vec<&RunPlan>) =
        runs.iter().partition(|run| matches!(run.task, Task::Ramp(_)));
    let total: f64 = loops.iter().map(|run| samples(run)).sum();
    if total > MAX_SAMPLES {
        let longest_s = loops.iter().map(|run| run.longest_s()).fold(0.0, f64::max);
        let key = "run.duration_s";
        return Err(Error::Input(format!(
            "{}: `{key}` is {} s; must be a number up to {} s: the {} runs may have at most \
             {MAX_SAMPLES:e} samples in all",
            origin.of(key),
            shown(longest_s),
            rounded(longest_s * MAX_SAMPLES / total * WITHIN),
            loops.len(),
        )));
    }
    let total: f64 = ramps.iter().map(|run| samples(run)).sum();
    if total > MAX_RAMP_SAMPLES {
        let key = "identification.ramp_rates_v_per_s";
        return Err(Error::Input(format!(
            "{}: the ramps of `{key}` may take {} samples; the limit is {MAX_RAMP_SAMPLES:e}: \
             raise the rates",
            origin.of(key),
            rounded(total),
        )));
    }
    let by_steps = || runs.iter().filter(|run| run.machine.run.solver == AxisSolverName::Rk4);
    let steps = |run: &RunPlan| {
        let sampling = run.machine.sampling.sample_time_s();
        samples(run) * (sampling / run.machine.run.step_s).ceil().max(1.0)
    };
    let total: f64 = by_steps().map(steps).sum();
    if total > MAX_STEPS {
        let total_s: f64 = by_steps().map(RunPlan::longest_s).sum();
        let finest = by_steps().map(|run| run.machine.run.step_s).fold(f64::INFINITY, f64::min);
        let key = "run.step_s";
        return Err(Error::Input(format!(
            "{}: `{key}` is {} s; must be a number from {} s: the {} s of all runs may take at \
             most {MAX_STEPS:e} steps",
            origin.of(key),
            shown(finest),
            rounded(total_s / MAX_STEPS / WITHIN),
            rounded(total_s),
        )));
    }
    Ok(())
}
