//! Running the runs of a friction experiment, on every core.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::build::AnyMechanism;
use super::plan::LabPlan;
use super::recorder::{EVEN_SAMPLES, LabMetrics, LabSample, Recorder};
use dynamics::friction::SetValued;
use dynamics::mechanism::Mechanism;
use files::error::Error;
use files::setup::{FrictionModel, SolverName};
use friction_lab::friction::{Implicit, SingleValued};
use friction_lab::solver::banded::Banded;
use friction_lab::solver::dynamics::{Dynamics, SingleValuedDynamics};
use friction_lab::solver::state::{BodyEvent, Finish, Observer};
use friction_lab::solver::step_doubling::Accuracy;
use friction_lab::solver::{
    SolverFailure, event_driven, fixed_step, nonsmooth, piecewise_smooth, step_doubling,
};

/// Evaluations of `rk4-adaptive` before it is given up: minutes.
const MAX_EVALUATIONS: u64 = 1_000_000_000;

/// Everything that came out of a run.
#[derive(Clone, Debug)]
pub struct LabResult {
    /// The plan that was run.
    pub plan: LabPlan,
    /// Samples in order of time; at events one on either side.
    pub rows: Vec<LabSample>,
    /// Breaks, sticks and reversals, in order.
    pub events: Vec<BodyEvent>,
    /// The metrics of the run.
    pub metrics: LabMetrics,
    /// Wall time of the solver with its events: of a second run without samples, which would take
    /// most of the time.
    pub wall: Duration,
    /// How often the solver computed the accelerations.
    pub evaluations: u64,
    /// When a state was no longer finite.
    pub diverged_at_s: Option<f64>,
}

/// Runs all plans in parallel, with a progress bar on a terminal if it takes more than a moment:
/// each by itself, so that one that a solver gives up takes no other with it.
pub fn run_all(plans: &[LabPlan]) -> Vec<Result<LabResult, Error>> {
    let style = ProgressStyle::with_template("{bar:40} {percent} %, {eta} left");
    // Of each run the samples, and the same again for the run that is timed.
    let bar = ProgressBar::new(plans.len() as u64 * 2 * EVEN_SAMPLES);
    let bar = style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style));
    let results = plans.par_iter().map(|plan| watched(plan, &bar)).collect();
    bar.finish_and_clear();
    results
}

/// Runs one plan.
///
/// # Errors
/// If the solver gave up, with time and state.
pub fn run(plan: &LabPlan) -> Result<LabResult, Error> {
    watched(plan, &ProgressBar::hidden())
}

fn watched(plan: &LabPlan, bar: &ProgressBar) -> Result<LabResult, Error> {
    match plan.mechanism()? {
        AnyMechanism::One(mechanism) => run_with(plan, &*mechanism, bar),
        AnyMechanism::Two(mechanism) => run_with(plan, &*mechanism, bar),
    }
}

fn run_with<const N: usize>(
    plan: &LabPlan,
    mechanism: &dyn Mechanism<N>,
    bar: &ProgressBar,
) -> Result<LabResult, Error> {
    let mut recorder = Recorder::new(mechanism, plan.setup.run.duration_s, bar);
    let finish = solved(plan, mechanism, &mut recorder)?;
    let begin = Instant::now();
    solved(plan, mechanism, &mut Vec::with_capacity(recorder.events.len()))?;
    let wall = begin.elapsed();
    bar.inc(EVEN_SAMPLES);
    Ok(LabResult {
        plan: plan.clone(),
        metrics: recorder.metrics(&finish),
        rows: recorder.rows,
        events: recorder.events,
        wall,
        evaluations: finish.evaluations,
        diverged_at_s: finish.diverged_at_s,
    })
}

fn solved<const N: usize, O: Observer<N>>(
    plan: &LabPlan,
    mechanism: &dyn Mechanism<N>,
    observer: &mut O,
) -> Result<Finish<N>, Error> {
    let case = Case { plan, mechanism, observer };
    let solved = match plan.model {
        FrictionModel::Classical | FrictionModel::Karnopp => case.set_valued(&plan.levels::<N>()?),
        FrictionModel::KarnoppBanded => {
            let (levels, bands) = (plan.levels::<N>()?, plan.bands::<N>()?);
            let mut dynamics = Banded::new(mechanism, levels, bands, plan.setup.run.coupling);
            case.explicit(&mut dynamics)
        }
        FrictionModel::Stribeck => case.set_valued(&plan.stribecks::<N>()?),
        FrictionModel::ResetIntegrator => case.single_valued(plan.reset_integrators::<N>()?),
        FrictionModel::Tanh => case.implicit(plan.tanhs::<N>()?),
        FrictionModel::Dahl => case.implicit(plan.dahls::<N>()?),
        FrictionModel::LuGre => case.implicit(plan.lugres::<N>()?),
        FrictionModel::ElasticCoulomb => case.implicit(plan.elastic_coulombs::<N>()?),
        FrictionModel::MaxwellSlip => case.implicit(plan.maxwell_slips::<N>()?),
    };
    solved.map_err(|trouble| Error::Run(format!("{}: {}: {trouble}", plan.origin, plan.label)))
}

/// A mechanism and who listens, before friction and solver are known by type.
struct Case<'a, const N: usize, O> {
    plan: &'a LabPlan,
    mechanism: &'a dyn Mechanism<N>,
    observer: &'a mut O,
}

impl<const N: usize, O: Observer<N>> Case<'_, N, O> {
    fn set_valued<F: SetValued>(self, friction: &[F; N]) -> Result<Finish<N>, SolverFailure> {
        let run = &self.plan.setup.run;
        match run.solver {
            SolverName::Nonsmooth => {
                nonsmooth::run(self.mechanism, friction, run.step_s, run.duration_s, self.observer)
            }
            // The others have been refused.
            _ => event_driven::run(
                self.mechanism,
                friction,
                run.tolerance,
                run.duration_s,
                self.observer,
            ),
        }
    }

    fn implicit<const Z: usize, F: Implicit<Z>>(
        self,
        friction: [F; N],
    ) -> Result<Finish<N>, SolverFailure> {
        let run = &self.plan.setup.run;
        match run.solver {
            SolverName::Nonsmooth => nonsmooth::run_implicit(
                self.mechanism,
                &friction,
                run.step_s,
                run.duration_s,
                self.observer,
            ),
            _ => self.single_valued(friction),
        }
    }

    fn single_valued<const Z: usize, F: SingleValued<Z>>(
        self,
        friction: [F; N],
    ) -> Result<Finish<N>, SolverFailure> {
        let run = &self.plan.setup.run;
        match run.solver {
            SolverName::Exact => piecewise_smooth::run(
                self.mechanism,
                &friction,
                run.tolerance,
                run.duration_s,
                self.observer,
            ),
            _ => {
                let mut dynamics = SingleValuedDynamics { mechanism: self.mechanism, friction };
                self.explicit(&mut dynamics)
            }
        }
    }

    fn explicit<const Z: usize, D: Dynamics<N, Z>>(
        self,
        dynamics: &mut D,
    ) -> Result<Finish<N>, SolverFailure> {
        let run = &self.plan.setup.run;
        match run.solver {
            SolverName::Rk4Adaptive => {
                let accuracy = Accuracy { eps: run.eps, max_evaluations: MAX_EVALUATIONS };
                step_doubling::run(dynamics, accuracy, run.duration_s, self.observer)
            }
            _ => fixed_step::run(dynamics, run.step_s, run.duration_s, self.observer),
        }
    }
}
