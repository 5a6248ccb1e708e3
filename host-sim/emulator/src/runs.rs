//! Runs of an experiment, each on its own board.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::image::{DEFAULT_IMAGE, FirmwareImage};
use super::log::{Listener, LogLine};
use super::parameters;
use super::plant_interface::PowerStage;
use super::setup::BoardSetup;
use super::side_by_side::{Ran, in_free_running, in_lockstep};
use dynamics::solver::{AxisSolver, Rk4Axis};
use files::error::Error;
use files::machine::AxisSolverName;
use simulator::experiment::{RunPlan, Task};
use simulator::run::{Recording, RunResult};

/// Settings for experiments on the emulated microcontroller.
#[derive(Clone)]
pub struct Emulation {
    image: Arc<FirmwareImage>,
    /// Image for two encoders, once a plan has needed it; only if no image was named.
    second: Option<OnceLock<Arc<FirmwareImage>>>,
    /// Whether the edges and the PWM have their own times (free-running), instead of lockstep.
    pub free_running: bool,
    /// Callback for each line of each run's log, as soon as it is read.
    pub listener: Option<Listener>,
    /// Flag that ends all runs.
    pub interrupt: Arc<AtomicBool>,
}

/// Latency of the output: time from the read of the counter to the effect of the duty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// Mean, us.
    pub mean_us: f64,
    /// Maximum, us.
    pub max_us: f64,
}

impl Latency {
    fn of(latencies_ns: &[u64]) -> Option<Self> {
        let max = latencies_ns.iter().max()?;
        let mean = latencies_ns.iter().sum::<u64>() as f64 / latencies_ns.len() as f64;
        Some(Self { mean_us: mean * 1e-3, max_us: *max as f64 * 1e-3 })
    }
}

/// One run on the emulated microcontroller.
#[derive(Clone, Debug)]
pub struct EmulatedRun {
    /// Result, of the same kind as that of a run on the host.
    pub result: RunResult,
    /// Log of the firmware.
    pub log: Vec<LogLine>,
    /// Latency of the output in a free-running run.
    pub latency: Option<Latency>,
    /// Instructions that the microcontroller ran from power-on to the end.
    pub instructions: u64,
}

impl Emulation {
    /// Creates the settings for the image at `path`, or else for those that
    /// `cargo xtask firmware` builds; in lockstep.
    ///
    /// # Errors
    /// Returns why the file is not a valid image, and how to build one.
    pub fn new(path: Option<&Path>) -> Result<Self, Error> {
        let image = Arc::new(FirmwareImage::open(path.unwrap_or(Path::new(DEFAULT_IMAGE)))?);
        let second = path.is_none().then(OnceLock::new);
        Ok(Self { image, second, free_running: false, listener: None, interrupt: Arc::default() })
    }

    /// Returns the image that runs a plan: the named one, or the built one for the encoders of the
    /// plan.
    ///
    /// # Errors
    /// Returns why there is no such image, or that the named one does not read all encoders.
    fn image(&self, plan: &RunPlan) -> Result<Arc<FirmwareImage>, Error> {
        match &self.second {
            Some(second) if plan.has_two_encoders() => {
                if let Some(image) = second.get() {
                    return Ok(image.clone());
                }
                let image = Arc::new(FirmwareImage::for_plan(None, plan)?);
                Ok(second.get_or_init(|| image).clone())
            }
            _ => self.image.fits(plan).map(|()| self.image.clone()),
        }
    }

    /// Runs all plans, as many at once as there are cores, with a progress bar on a terminal.
    ///
    /// # Errors
    /// Returns an error about a plan that cannot be run, or about a run in which image and core
    /// differ.
    pub fn run_all(&self, plans: &[RunPlan]) -> Result<Vec<EmulatedRun>, Error> {
        let mut total = 0;
        for plan in plans {
            plan.validate()?;
            plan.refuse_current_loop()?;
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
            let results =
                plans.par_iter().zip(&ticks).map(|(plan, ticks)| self.run(plan, ticks)).collect();
            over.store(true, Ordering::Relaxed);
            results
        });
        bar.finish_and_clear();
        results
    }

    /// Runs one plan, and counts its ticks in `ticks`.
    ///
    /// # Errors
    /// As [`run_all`](Self::run_all).
    pub fn run(&self, plan: &RunPlan, ticks: &AtomicU32) -> Result<EmulatedRun, Error> {
        self.run_with_record(parameters::blob(plan)?, plan, ticks)
    }

    /// Runs one plan with another record in the image's flash.
    ///
    /// # Errors
    /// As [`run_all`](Self::run_all).
    pub fn run_with_record(
        &self,
        record: Vec<u8>,
        plan: &RunPlan,
        ticks: &AtomicU32,
    ) -> Result<EmulatedRun, Error> {
        if let Some(axis) = plan.sheet_axis()? {
            return self.run_with(record, plan, axis, ticks);
        }
        let (axis, machine) = (plan.axis()?, &plan.machine);
        match machine.run.solver {
            AxisSolverName::Rk4 if plan.substitute.is_none() => {
                let band = machine.joint.friction.band_deg_per_s;
                let solver = Rk4Axis::at_rest(&axis, band, machine.run.step_s);
                self.run_with(record, plan, solver, ticks)
            }
            AxisSolverName::Exact | AxisSolverName::Rk4 => {
                self.run_with(record, plan, plan.joint()?, ticks)
            }
        }
    }

    fn run_with<S>(
        &self,
        record: Vec<u8>,
        plan: &RunPlan,
        solver: S,
        ticks: &AtomicU32,
    ) -> Result<EmulatedRun, Error>
    where
        S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
    {
        let mut recording = Recording::new(plan)?;
        let mut setup = BoardSetup::new(&plan.label, &self.image(plan)?, record);
        (setup.listener, setup.interrupt) = (self.listener.clone(), self.interrupt.clone());
        let ran = if self.free_running {
            let stage = PowerStage::of(plan)?;
            in_free_running(setup, &mut recording, (solver, stage), ticks)?
        } else {
            in_lockstep(setup, &mut recording, solver, ticks)?
        };
        let Ran { solver, found, log, latencies_ns, instructions } = ran;
        let (result, latency) = (recording.judged(&solver, &found)?, Latency::of(&latencies_ns));
        Ok(EmulatedRun { result, log, latency, instructions })
    }
}

/// Returns the expected number of ticks, for the progress bar. A ramp lasts up to the joint's
/// static friction and back.
fn expected_ticks(plan: &RunPlan) -> Result<u64, Error> {
    let Task::Ramp(rate) = plan.task else { return plan.samples().map(u64::from) };
    let ramp = plan.ramp(rate)?;
    let seconds = 2.0 * plan.machine.joint.friction.stick_v / rate + ramp.hold_s;
    Ok((seconds / ramp.sample_time_s) as u64)
}
