//! Executes the runs of an experiment, on every core.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use stiction::Course;
use stiction::identification::RampFindings;

use crate::both_sides::BothSides;
use crate::closed_loop::{ClosedLoop, LoopSample};
use crate::experiment::{RunPlan, Task, parameters};
use crate::identification::RampFriction;
use crate::metrics::{RunMetrics, is_unstable};
use crate::plant::{Delay, Plant, Winding};
use crate::progress::{Progress, Silent};
use crate::target::{BareLoop, RegulatedLoop, Target, WatchedServo};
use dynamics::solver::{AxisSolver, Event, Rk4Axis};
use files::data_sheet::UnseenSlack;
use files::error::Error;
use files::machine::AxisSolverName;

/// Result of a run.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// Plan of the run.
    pub plan: RunPlan,
    /// Samples of the loop, or of the ramp.
    pub trace: RunTrace,
    /// Breaks, sticks and reversals, in order.
    pub events: Vec<Event>,
    /// Metrics.
    pub metrics: RunMetrics,
    /// Wall-clock time.
    pub wall: Duration,
    /// Number of evaluations of the acceleration; 0 in closed form.
    pub derivative_evaluations: u64,
    /// Whether the loop is unstable.
    pub unstable: bool,
    /// Time at which a state was no longer finite, s.
    pub diverged_at_s: Option<f64>,
    /// Fault that ended the motion of a servo; its joint coasts from then on.
    pub fault: Option<ServoTrip>,
    /// Slack of the gear that the encoder cannot measure; with it, both sides of the gear are
    /// shown.
    pub unseen_slack: Option<UnseenSlack>,
}

/// A fault of a servo.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ServoTrip {
    /// Code.
    pub code: u8,
    /// Description.
    pub name: &'static str,
    /// Time since the start of the motion, s.
    pub time_s: f64,
    /// Value that tripped it, in the fault's unit.
    pub value: f32,
}

/// Driver of the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RunDriver {
    /// The control loop alone.
    #[default]
    ByLoop,
    /// The servo, with soft start and monitors.
    ByServo,
}

/// Samples of a run.
#[derive(Clone, Debug)]
pub enum RunTrace {
    /// Samples of a closed loop.
    Loop(Vec<LoopSample>),
    /// Samples of an effort ramp: the loop is open, so the reference has no meaning.
    Ramp(Vec<LoopSample>),
}

/// Runs all plans with the bare loop, as [`run_all_driven`], and reports no progress.
///
/// # Errors
/// Returns the first invalid configuration; nothing has been run then.
pub fn run_all(plans: &[RunPlan]) -> Result<Vec<RunResult>, Error> {
    run_all_driven(plans, RunDriver::ByLoop, &Silent)
}

/// Runs all plans on all cores; each is a step of `progress`.
///
/// # Errors
/// Returns the first invalid configuration, before anything is run; or the error of `progress`.
pub fn run_all_driven(
    plans: &[RunPlan],
    driven: RunDriver,
    progress: &impl Progress,
) -> Result<Vec<RunResult>, Error> {
    for plan in plans {
        plan.validate()?;
    }
    progress.start(plans.len() as u64, "runs");
    let one = |plan| {
        let result = run_driven(plan, driven)?;
        progress.step().map(|()| result)
    };
    plans.par_iter().map(one).collect()
}

/// Runs one plan with the bare loop.
///
/// # Errors
/// Returns an error that names the invalid value.
pub fn run(plan: &RunPlan) -> Result<RunResult, Error> {
    run_driven(plan, RunDriver::ByLoop)
}

/// Runs one plan.
///
/// # Errors
/// Returns an error that names the invalid value.
pub fn run_driven(plan: &RunPlan, driven: RunDriver) -> Result<RunResult, Error> {
    plan.as_case(|| run_on_its_joint(plan, driven))
}

fn run_on_its_joint(plan: &RunPlan, driven: RunDriver) -> Result<RunResult, Error> {
    if plan.has_current_loop() || plan.has_heat()? || plan.supply.is_some() {
        if plan.machine.run.solver == AxisSolverName::Rk4 && plan.substitute.is_none() {
            return Err(Error::Input(format!(
                "{}: a current loop, another supply and a winding that heats up need run.solver = \
                 \"exact\"",
                plan.origin.of("run.solver")
            )));
        }
        if plan.supply.is_some() && plan.dc_link()?.is_some() {
            return Err(Error::Input(format!(
                "{}: another supply of a run is a voltage, and has no capacitor",
                plan.origin.of("supply.capacitance_f")
            )));
        }
        return run_with(plan, driven, plan.joint()?, plan.winding()?);
    }
    if let Some(axis) = plan.sheet_axis()? {
        return run_with(plan, driven, axis, None);
    }
    let axis = plan.axis()?;
    match plan.machine.run.solver {
        AxisSolverName::Rk4 if plan.substitute.is_none() => {
            let band = plan.machine.joint.friction.band_deg_per_s;
            let solver = Rk4Axis::at_rest(&axis, band, plan.machine.run.step_s);
            run_with(plan, driven, solver, None)
        }
        AxisSolverName::Exact | AxisSolverName::Rk4 => {
            run_with(plan, driven, plan.joint()?, plan.winding()?)
        }
    }
}

fn run_with<S: AxisSolver>(
    plan: &RunPlan,
    driven: RunDriver,
    solver: S,
    winding: Option<Winding>,
) -> Result<RunResult, Error> {
    let mut recording = Recording::new(plan)?;
    let mut plant = recording.closed_loop.plant(solver).with_winding(winding);
    let (counter, counts) = (plant.counter(), plant.counts());
    if driven == RunDriver::ByServo {
        if let Task::Ramp(_) = plan.task {
            let why = "ramps of a servo need a device: `stiction device ... identify`";
            return Err(Error::Input(format!("--target servo: {} is a ramp; {why}", plan.label)));
        }
        let mut target = WatchedServo::new(parameters(plan)?, plant.counters(), counts)?;
        recording.step(&mut target, &mut plant);
        let fault = target.fault.map(|(latched, tick)| ServoTrip {
            code: latched.fault as u8,
            name: latched.fault.describe(),
            time_s: f64::from(tick) * plant.sample_time_s(),
            value: latched.value,
        });
        let mut result = recording.judged(&plant.solver, &RampFindings::default())?;
        result.fault = fault;
        if fault.is_some() {
            result.metrics.sides.fail();
        }
        return Ok(result);
    }
    let ClosedLoop { controller, course, .. } = recording.closed_loop.clone();
    let mut target = BareLoop::new(&controller, &course, counter, counts);
    if let Some(current_loop) = plan.current_loop()? {
        let mut target = RegulatedLoop { bare: target, current_loop };
        recording.step(&mut target, &mut plant);
        return recording.judged(&plant.solver, &target.bare.state.ramp().findings());
    }
    recording.step(&mut target, &mut plant);
    recording.judged(&plant.solver, &target.state.ramp().findings())
}

/// Recording of a run: its loop, and the samples and events so far.
#[derive(Debug)]
pub struct Recording<'a> {
    plan: &'a RunPlan,
    /// Loop of the run. A ramp has no delay, since its readings are of the effort of the same
    /// sample.
    pub closed_loop: ClosedLoop,
    /// Largest number of samples after the first; a ramp can end earlier.
    pub samples: u32,
    /// Samples so far.
    pub trace: RunTrace,
    /// Breaks, sticks and reversals so far.
    pub events: Vec<Event>,
    /// Time at which a state was no longer finite, s.
    pub diverged_at_s: Option<f64>,
    begin: Instant,
}

impl<'a> Recording<'a> {
    /// Creates an empty recording.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn new(plan: &'a RunPlan) -> Result<Self, Error> {
        let begin = Instant::now();
        let mut closed_loop = plan.closed_loop()?;
        let (samples, trace) = if let Course::Ramp(_) = closed_loop.course {
            closed_loop.delay = Delay::None;
            (u32::MAX, RunTrace::Ramp(Vec::new()))
        } else {
            let samples = plan.samples()?;
            (samples, RunTrace::Loop(Vec::with_capacity(samples as usize + 1)))
        };
        Ok(Self {
            plan,
            closed_loop,
            samples,
            trace,
            events: Vec::new(),
            diverged_at_s: None,
            begin,
        })
    }

    /// Runs a target with a plant, to the end.
    pub fn step<S: AxisSolver>(&mut self, target: &mut impl Target, plant: &mut Plant<S>) {
        let Self { closed_loop, samples, trace, events, .. } = self;
        let on_moment = |moment: &LoopSample| trace.push(moment);
        self.diverged_at_s =
            closed_loop.step(target, plant, *samples, on_moment, |event| events.push(event));
    }

    /// Returns the result of the run; `found` are the findings of a ramp.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn judged(
        self,
        solver: &impl AxisSolver,
        found: &RampFindings,
    ) -> Result<RunResult, Error> {
        let Self { plan, closed_loop, trace, events, diverged_at_s, begin, .. } = self;
        let evaluations = solver.derivative_evaluations();
        let levels = match plan.task {
            Task::Ramp(rate) => plan.ramp(rate)?.levels(found, &closed_loop.axis),
            Task::Step(_) | Task::Trajectory(_) | Task::Sine(_) => RampFriction::default(),
        };
        let unseen_slack = plan.unseen_slack()?;
        let result = match trace {
            RunTrace::Ramp(moments) => {
                RunResult::of_ramp(plan, levels, moments, events, begin, evaluations)
            }
            RunTrace::Loop(moments) => {
                RunResult::of_loop(plan, moments, events, diverged_at_s, begin, evaluations)
            }
        };
        Ok(RunResult { unseen_slack, ..result })
    }
}

impl RunTrace {
    /// Adds a sample.
    pub fn push(&mut self, moment: &LoopSample) {
        let (Self::Loop(moments) | Self::Ramp(moments)) = self;
        moments.push(*moment);
    }
}

impl RunResult {
    /// Returns the result of a closed loop that started at `begin`.
    fn of_loop(
        plan: &RunPlan,
        moments: Vec<LoopSample>,
        events: Vec<Event>,
        diverged_at_s: Option<f64>,
        begin: Instant,
        derivative_evaluations: u64,
    ) -> Self {
        let count_deg = plan.machine.count_deg();
        let mut metrics = RunMetrics::of(&moments, &plan.task, count_deg);
        let goal = &plan.machine.goal;
        let sides = BothSides::of(&moments, &plan.task, goal, count_deg);
        metrics.judge(sides, &plan.task, goal);
        let unstable = diverged_at_s.is_some() || is_unstable(&moments, plan.task.span_deg());
        if unstable {
            metrics.sides.fail();
        }
        Self {
            plan: plan.clone(),
            trace: RunTrace::Loop(moments),
            events,
            metrics,
            wall: begin.elapsed(),
            derivative_evaluations,
            unstable,
            diverged_at_s,
            fault: None,
            unseen_slack: None,
        }
    }

    /// Returns the result of a ramp that started at `begin`.
    fn of_ramp(
        plan: &RunPlan,
        levels: RampFriction,
        moments: Vec<LoopSample>,
        events: Vec<Event>,
        begin: Instant,
        derivative_evaluations: u64,
    ) -> Self {
        let RampFriction { stick_v, slip_v, slip_corrected_v } = levels;
        Self {
            plan: plan.clone(),
            trace: RunTrace::Ramp(moments),
            events,
            metrics: RunMetrics { stick_v, slip_v, slip_corrected_v, ..RunMetrics::default() },
            wall: begin.elapsed(),
            derivative_evaluations,
            unstable: false,
            diverged_at_s: None,
            fault: None,
            unseen_slack: None,
        }
    }
}
