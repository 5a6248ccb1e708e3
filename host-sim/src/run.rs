//! Running the runs of an experiment, on every core.

use std::time::{Duration, Instant};

use indicatif::{ParallelProgressIterator, ProgressBar, ProgressStyle};
use rayon::prelude::*;

use crate::closed_loop::{ClosedLoop, Moment};
use crate::error::Error;
use crate::experiment::{RunPlan, Task, parameters};
use crate::identification::{Levels, RampMoment};
use crate::machine::Solver;
use crate::metrics::{Metrics, is_unstable};
use crate::solver::{AxisSolver, Event, ExactAxis, Rk4Axis};
use crate::target::WatchedServo;

/// Everything that came out of a run.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// What was run.
    pub plan: RunPlan,
    /// The loop at every sample, or the ramp.
    pub trace: Trace,
    /// Breaks, sticks and reversals, in order.
    pub events: Vec<Event>,
    /// What it is judged by.
    pub metrics: Metrics,
    /// Wall time.
    pub wall: Duration,
    /// How often the solver evaluated the acceleration; none in closed form.
    pub derivative_evaluations: u64,
    /// The loop is unstable.
    pub unstable: bool,
    /// When a state was no longer finite.
    pub diverged_at_s: Option<f64>,
    /// What ended the motion of a servo; its joint coasts from then on.
    pub fault: Option<Tripped>,
}

/// A fault of a servo.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Tripped {
    /// Its code.
    pub code: u8,
    /// In a few words.
    pub name: &'static str,
    /// Time since the motion began, s.
    pub time_s: f64,
    /// What tripped it, in the fault's unit.
    pub value: f32,
}

/// What drives the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driven {
    /// The control loop alone.
    #[default]
    ByLoop,
    /// The servo, with soft start and monitors.
    ByServo,
}

/// The samples of a run.
#[derive(Clone, Debug)]
pub enum Trace {
    /// Of a closed loop.
    Loop(Vec<Moment>),
    /// Of an effort ramp.
    Ramp(Vec<RampMoment>),
}

/// Runs all plans by the bare loop, as [`run_all_driven`].
///
/// # Errors
/// The first configuration that is not allowed; nothing has been run then.
pub fn run_all(plans: &[RunPlan]) -> Result<Vec<RunResult>, Error> {
    run_all_driven(plans, Driven::ByLoop)
}

/// Runs all plans in parallel, with a progress bar on a terminal if it takes more than a moment.
///
/// # Errors
/// The first configuration that is not allowed; nothing has been run then.
pub fn run_all_driven(plans: &[RunPlan], driven: Driven) -> Result<Vec<RunResult>, Error> {
    for plan in plans {
        plan.validate()?;
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left");
    let bar = ProgressBar::new(plans.len() as u64);
    let bar = style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style));
    let results = plans.par_iter().progress_with(bar.clone()).map(|plan| run_driven(plan, driven)).collect();
    bar.finish_and_clear();
    results
}

/// Runs one plan by the bare loop.
///
/// # Errors
/// Names a value that is not allowed.
pub fn run(plan: &RunPlan) -> Result<RunResult, Error> {
    run_driven(plan, Driven::ByLoop)
}

/// Runs one plan.
///
/// # Errors
/// Names a value that is not allowed.
pub fn run_driven(plan: &RunPlan, driven: Driven) -> Result<RunResult, Error> {
    let axis = plan.axis()?;
    let sample_time_s = plan.machine.sampling.sample_time_s();
    match plan.machine.run.solver {
        Solver::Exact => run_with(plan, driven, ExactAxis::at_rest(&axis, sample_time_s)),
        Solver::Rk4 => {
            let band = plan.machine.joint.friction.band_deg_per_s;
            run_with(plan, driven, Rk4Axis::at_rest(&axis, band, plan.machine.run.step_s))
        }
    }
}

fn run_with<S: AxisSolver>(plan: &RunPlan, driven: Driven, mut solver: S) -> Result<RunResult, Error> {
    let begin = Instant::now();
    let mut events = Vec::new();
    let closed_loop = plan.closed_loop()?;
    if driven == Driven::ByServo {
        return run_servo(plan, &closed_loop, solver, begin);
    }
    if let Task::Ramp(rate) = plan.task {
        let ramp = plan.ramp(rate)?;
        let mut moments = Vec::new();
        let on_moment = |moment: &RampMoment| moments.push(*moment);
        let levels = ramp.run(&mut solver, &closed_loop, on_moment, |event| events.push(event));
        let evaluations = solver.derivative_evaluations();
        return Ok(RunResult::of_ramp(plan, levels, moments, events, begin, evaluations));
    }
    let samples = plan.samples()?;
    let mut moments = Vec::with_capacity(samples as usize + 1);
    let diverged_at_s =
        closed_loop.run(&mut solver, samples, |moment| moments.push(*moment), |event| events.push(event));
    let evaluations = solver.derivative_evaluations();
    Ok(RunResult::of_loop(plan, moments, events, diverged_at_s, begin, evaluations))
}

/// The same motion by the servo, as a device with these parameters runs it.
fn run_servo<S: AxisSolver>(
    plan: &RunPlan,
    closed_loop: &ClosedLoop,
    mut solver: S,
    begin: Instant,
) -> Result<RunResult, Error> {
    if let Task::Ramp(_) = plan.task {
        let why = "the servo runs ramps on a device: `stiction device ... identify`";
        return Err(Error::Input(format!("--target servo: {} is a ramp; {why}", plan.label)));
    }
    let (counter, counts) = closed_loop.at_rest(&solver);
    let mut target = WatchedServo::new(parameters(plan)?, counter, counts)?;
    let (mut moments, mut events) = (Vec::new(), Vec::new());
    let diverged_at_s = closed_loop.step(
        &mut target,
        &mut solver,
        plan.samples()?,
        |moment| moments.push(*moment),
        |event| events.push(event),
    );
    let evaluations = solver.derivative_evaluations();
    let fault = target.fault.map(|(latched, tick)| Tripped {
        code: latched.fault as u8,
        name: latched.fault.describe(),
        time_s: f64::from(tick) * closed_loop.sample_time_s,
        value: latched.value,
    });
    let result = RunResult::of_loop(plan, moments, events, diverged_at_s, begin, evaluations);
    Ok(RunResult { fault, ..result })
}

impl RunResult {
    /// Judges what a closed loop did that was started at `begin`.
    pub(crate) fn of_loop(
        plan: &RunPlan,
        moments: Vec<Moment>,
        events: Vec<Event>,
        diverged_at_s: Option<f64>,
        begin: Instant,
        derivative_evaluations: u64,
    ) -> Self {
        let metrics = Metrics::of(&moments, &plan.task, plan.machine.encoder.resolution_deg());
        let unstable = diverged_at_s.is_some() || is_unstable(&moments, plan.task.span_deg());
        Self {
            plan: plan.clone(),
            trace: Trace::Loop(moments),
            events,
            metrics,
            wall: begin.elapsed(),
            derivative_evaluations,
            unstable,
            diverged_at_s,
            fault: None,
        }
    }

    /// Tells what a ramp found that was started at `begin`.
    pub(crate) fn of_ramp(
        plan: &RunPlan,
        levels: Levels,
        moments: Vec<RampMoment>,
        events: Vec<Event>,
        begin: Instant,
        derivative_evaluations: u64,
    ) -> Self {
        let Levels { stick_v, slip_v, slip_corrected_v } = levels;
        Self {
            plan: plan.clone(),
            trace: Trace::Ramp(moments),
            events,
            metrics: Metrics { stick_v, slip_v, slip_corrected_v, ..Metrics::default() },
            wall: begin.elapsed(),
            derivative_evaluations,
            unstable: false,
            diverged_at_s: None,
            fault: None,
        }
    }
}
