//! From a document to its runs.

use std::sync::Arc;

use toml::Table;

use super::document::Document;
use crate::error::{Error, suggestion};
use crate::machine::{Machine, Trajectory, Variant};

/// A named set of runs.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// A built-in name or a file's path.
    pub name: String,
    /// Where it comes from.
    pub source: String,
    /// Its runs.
    pub runs: Vec<RunPlan>,
}

/// One run.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// `srnf/step-5.0/test-2`.
    pub label: String,
    /// Where its configuration came from, for messages.
    pub origin: String,
    /// The machine, with the variant's keys set.
    pub machine: Arc<Machine>,
    /// The controller's name; none for a ramp.
    pub controller: Option<String>,
    /// What is asked of it.
    pub motion: Motion,
    /// The variant's slug, or nothing.
    pub variant: String,
}

/// What is asked of a joint in one run.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A jump by so many degrees.
    Step(f64),
    /// A motion through corners.
    Trajectory(Trajectory),
    /// An effort that rises until the joint moves and falls until it rests, V/s.
    Ramp(f64),
}

impl RunPlan {
    /// What sets this run apart from another of the same controller and motion: its variant, a sample of delay.
    pub fn slugs(&self) -> Vec<&str> {
        slugs(&self.variant, &self.machine, self.controller.is_some())
    }
}

fn slugs<'a>(variant: &'a str, machine: &Machine, sampled: bool) -> Vec<&'a str> {
    let delayed = sampled && machine.run.delay_samples == 1;
    [variant, if delayed { "delay-1" } else { "" }].into_iter().filter(|slug| !slug.is_empty()).collect()
}

impl Motion {
    /// `step-5.0`, `trajectory-2.5` (its speed in deg/s), `rate-0.001`.
    pub fn slug(&self) -> String {
        match self {
            Self::Step(step) => format!("step-{}", short(*step)),
            Self::Trajectory(trajectory) => format!("trajectory-{}", short(trajectory.speed())),
            Self::Ramp(rate) => format!("rate-{rate}"),
        }
    }
}

impl Trajectory {
    /// Speed of the first line that is not a rest, deg/s.
    pub fn speed(&self) -> f64 {
        let lines = self.corner_times_s.windows(2).zip(self.corner_positions_deg.windows(2));
        lines.map(|(t, p)| ((p[1] - p[0]) / (t[1] - t[0])).abs()).find(|speed| *speed > 0.0).unwrap_or(0.0)
    }
}

/// At least one digit behind the point, at most three.
fn short(number: f64) -> String {
    let text = format!("{number:.3}");
    let text = text.trim_end_matches('0');
    if text.ends_with('.') { format!("{text}0") } else { text.into() }
}

impl Experiment {
    /// All runs of a document, for the controllers that are `wanted` or else those that the document names.
    ///
    /// `fixed` are keys that the user has set by hand: a variant that sets one of them otherwise is left out.
    ///
    /// # Errors
    /// Names a controller that does not exist, or a document without anything to run.
    pub fn plan(document: &Document, wanted: &[String], fixed: &[String]) -> Result<Self, Error> {
        let machine = document.machine()?;
        let mut runs = Vec::new();
        for variant in variants(document, &machine, fixed)? {
            let (origin, machine) = if variant.set.is_empty() {
                (document.origin.clone(), machine.clone())
            } else {
                let with = document.with(&variant.slug, &variant.set)?;
                (with.origin.clone(), with.machine()?)
            };
            runs.extend(runs_of(machine, &origin, &variant.slug, wanted)?);
        }
        if runs.is_empty() {
            let why = "neither `reference.steps_deg`, `reference.trajectories` nor `identification.ramp_rates_v_per_s`";
            return Err(Error::Input(format!(
                "{}: there is nothing to run, {why} has an entry",
                document.origin
            )));
        }
        if let Some(label) = doubled(&runs) {
            let why = "give each step, trajectory and variant its own size, speed or slug";
            return Err(Error::Input(format!(
                "{}: two runs would be called `{label}`; {why}",
                document.origin
            )));
        }
        Ok(Self { name: document.origin.clone(), source: machine.source, runs })
    }
}

fn variants(document: &Document, machine: &Machine, fixed: &[String]) -> Result<Vec<Variant>, Error> {
    if machine.variant.is_empty() {
        return Ok(vec![Variant { slug: String::new(), set: Table::new() }]);
    }
    let agrees = |variant: &&Variant| {
        variant.set.iter().all(|(key, value)| !fixed.contains(key) || document.get(key) == Some(value))
    };
    let kept: Vec<Variant> = machine.variant.iter().filter(agrees).cloned().collect();
    if kept.is_empty() {
        let keys = fixed.join("`, `");
        let why = "every variant of this experiment sets it otherwise";
        return Err(Error::Input(format!("{}: `{keys}` cannot be set by hand, {why}", document.origin)));
    }
    Ok(kept)
}

fn runs_of(machine: Machine, origin: &str, slug: &str, wanted: &[String]) -> Result<Vec<RunPlan>, Error> {
    let machine = Arc::new(machine);
    let names = if wanted.is_empty() { machine.sampling.controller.list() } else { wanted };
    let steps = machine.reference.steps_deg.iter().copied().map(Motion::Step);
    let trajectories = machine.reference.trajectories.iter().cloned().map(Motion::Trajectory);
    let motions: Vec<Motion> = steps.chain(trajectories).collect();
    let mut runs = Vec::new();
    let mut add = |controller: Option<&String>, motion: Motion| {
        let driven_by = controller.map_or("ramp", String::as_str);
        let motion_slug = motion.slug();
        let mut label = vec![driven_by, &motion_slug];
        label.extend(slugs(slug, &machine, controller.is_some()));
        runs.push(RunPlan {
            label: label.join("/"),
            origin: origin.into(),
            machine: machine.clone(),
            controller: controller.cloned(),
            motion,
            variant: slug.into(),
        });
    };
    for name in names {
        if !machine.controller.contains_key(name) {
            let near = suggestion(name, machine.controller.keys().map(String::as_str));
            return Err(Error::Input(format!("{origin}: there is no controller `{name}`{near}")));
        }
        for motion in &motions {
            add(Some(name), motion.clone());
        }
    }
    for rate in machine.identification.iter().flat_map(|ramps| &ramps.ramp_rates_v_per_s) {
        add(None, Motion::Ramp(*rate));
    }
    Ok(runs)
}

fn doubled(runs: &[RunPlan]) -> Option<&str> {
    let mut labels: Vec<&str> = runs.iter().map(|run| run.label.as_str()).collect();
    labels.sort_unstable();
    labels.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}
