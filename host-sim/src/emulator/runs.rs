//! The runs of an experiment, each on a board of its own.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use stiction::identification::RampState;

use super::board::Fitted;
use super::image::FirmwareImage;
use super::in_the_loop::{Ran, Setup, run};
use super::joint::Joint;
use super::log::{Listener, LogLine};
use super::parameters;
use super::probe::{Points, Probe};
use crate::error::Error;
use crate::experiment::{RunPlan, Task};
use crate::identification::Levels;
use crate::machine::Solver;
use crate::run::{RunResult, Trace};
use crate::solver::{AxisSolver, ExactAxis, Rk4Axis};

/// Where `cargo xtask firmware` leaves the image.
pub(crate) const DEFAULT_IMAGE: &str = "target/firmware/stiction-firmware.elf";

/// How to run experiments on the emulated part.
#[derive(Clone)]
pub struct Emulation {
    image: Arc<FirmwareImage>,
    /// Edges and PWM at their own times.
    pub free_running: bool,
    /// Gets each line of each run's log at once.
    pub listener: Option<Listener>,
    /// What to count.
    pub points: Option<Arc<Points>>,
    /// Ends all runs when it is set.
    pub interrupt: Arc<AtomicBool>,
}

/// From the read of the counter to the instant at which the duty takes effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// us.
    pub mean_us: f64,
    /// us.
    pub max_us: f64,
}

impl Latency {
    fn of(latencies_ns: &[u64]) -> Option<Self> {
        let max = latencies_ns.iter().max()?;
        let mean = latencies_ns.iter().sum::<u64>() as f64 / latencies_ns.len() as f64;
        Some(Self { mean_us: mean * 1e-3, max_us: *max as f64 * 1e-3 })
    }
}

/// One run on the emulated part.
#[derive(Clone, Debug)]
pub struct EmulatedRun {
    /// The same as of a run on the host.
    pub result: RunResult,
    /// What the firmware said.
    pub log: Vec<LogLine>,
    /// Of a free-running run.
    pub latency: Option<Latency>,
    /// What was counted, if that was asked for.
    pub probe: Option<Probe>,
    /// Instructions from power-on to the end.
    pub instructions: u64,
}

impl Emulation {
    /// With the image at `path`, or else the one that `cargo xtask firmware` builds; in lockstep.
    ///
    /// # Errors
    /// Says what the image is not, and how to build one that is.
    pub fn new(path: Option<&Path>) -> Result<Self, Error> {
        let path = path.map_or_else(|| PathBuf::from(DEFAULT_IMAGE), Path::to_path_buf);
        let image = Arc::new(FirmwareImage::open(&path)?);
        Ok(Self { image, free_running: false, listener: None, points: None, interrupt: Arc::default() })
    }

    /// The image that runs.
    pub fn image(&self) -> &FirmwareImage {
        &self.image
    }

    /// Runs all plans, as many at once as there are cores, with a progress bar on a terminal.
    ///
    /// # Errors
    /// The first plan that cannot be run, or the first image that did not do what the core does.
    pub fn run_all(&self, plans: &[RunPlan]) -> Result<Vec<EmulatedRun>, Error> {
        let mut total = 0;
        for plan in plans {
            plan.validate()?;
            parameters::blob(plan)?;
            total += expected_ticks(plan)?;
        }
        let style = ProgressStyle::with_template("{bar:40} {percent} % of {msg}, {eta} left");
        let bar = ProgressBar::new(total);
        let bar = style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style));
        bar.set_message(format!("{} runs on the emulated part", plans.len()));
        let ticks: Vec<Arc<AtomicU32>> = plans.iter().map(|_| Arc::default()).collect();
        let over = AtomicBool::new(false);
        let results = std::thread::scope(|scope| {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    bar.set_position(
                        ticks.iter().map(|ticks| u64::from(ticks.load(Ordering::Relaxed))).sum(),
                    );
                    std::thread::park_timeout(Duration::from_millis(100));
                }
            });
            let results = plans.par_iter().zip(&ticks).map(|(plan, ticks)| self.run(plan, ticks)).collect();
            over.store(true, Ordering::Relaxed);
            results
        });
        bar.finish_and_clear();
        results
    }

    /// Runs one plan; `ticks` counts along.
    ///
    /// # Errors
    /// As [`run_all`](Self::run_all).
    pub fn run(&self, plan: &RunPlan, ticks: &Arc<AtomicU32>) -> Result<EmulatedRun, Error> {
        let axis = plan.axis()?;
        match plan.machine.run.solver {
            Solver::Exact => {
                let solver = ExactAxis::at_rest(&axis, plan.machine.sampling.sample_time_s());
                self.run_with(plan, solver, ticks)
            }
            Solver::Rk4 => {
                let band = plan.machine.joint.friction.band_deg_per_s;
                self.run_with(plan, Rk4Axis::at_rest(&axis, band, plan.machine.run.step_s), ticks)
            }
        }
    }

    fn run_with<S>(&self, plan: &RunPlan, solver: S, ticks: &Arc<AtomicU32>) -> Result<EmulatedRun, Error>
    where
        S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
    {
        let begin = Instant::now();
        // What a tick costs is counted with every monitor at work.
        let blob = if self.points.is_some() { parameters::watched_blob } else { parameters::blob };
        let setup = Setup {
            label: plan.label.clone(),
            image: self.image.clone(),
            parameters: blob(plan)?,
            fitted: Fitted::default(),
            free_running: self.free_running,
            listener: self.listener.clone(),
            points: self.points.clone(),
            ticks: ticks.clone(),
            interrupt: self.interrupt.clone(),
        };
        let joint = Joint::new(plan.closed_loop()?, plan.course()?, solver, plan.samples()?);
        let Ran { wired, log, probe, instructions, .. } = run(&setup, joint)?;
        let latency = self.free_running.then(|| Latency::of(&wired.latencies_ns)).flatten();
        let result = judged(plan, wired.joint, begin)?;
        Ok(EmulatedRun { result, log: log.lines, latency, probe, instructions })
    }
}

/// What the joint's run comes to, as on the host.
fn judged<S: AxisSolver>(plan: &RunPlan, joint: Joint<S>, begin: Instant) -> Result<RunResult, Error> {
    let evaluations = joint.solver.derivative_evaluations();
    let found = joint.ramp().map(RampState::findings).unwrap_or_default();
    let Joint { trace, events, diverged_at_s, closed_loop, .. } = joint;
    let levels = match plan.task {
        Task::Ramp(rate) => plan.ramp(rate)?.levels(&found, &closed_loop.axis),
        Task::Step(_) | Task::Trajectory(_) => Levels::default(),
    };
    Ok(match trace {
        Trace::Ramp(moments) => RunResult::of_ramp(plan, levels, moments, events, begin, evaluations),
        Trace::Loop(moments) => RunResult::of_loop(plan, moments, events, diverged_at_s, begin, evaluations),
    })
}

/// For the progress bar: of a ramp, as many as it takes to the joint's own friction and back.
fn expected_ticks(plan: &RunPlan) -> Result<u64, Error> {
    let Task::Ramp(rate) = plan.task else { return plan.samples().map(u64::from) };
    let ramp = plan.ramp(rate)?;
    let seconds = 2.0 * plan.machine.joint.friction.stick_v / rate + ramp.hold_s;
    Ok((seconds / ramp.sample_time_s) as u64)
}
