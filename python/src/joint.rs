//! A joint that Python steps, sample by sample.

use pyo3::prelude::*;

use super::error::exception;
use dynamics::joint::RunJoint;
use dynamics::solver::AxisSolver;
use files::data_sheet::SheetAxis;
use files::document::Document;
use files::error::Error;
use simulator::experiment::{Experiment, RunPlan};
use simulator::plant::Plant;
use stiction::control::drive::Drive;
use studies::ensemble::{KeySpread, drawn_keys};
use studies::tuning::spreads;

/// Time (s), counts of the encoder, position of the joint and of the load (deg), velocity of the
/// joint (deg/s), whether it sticks, effort of the last step (V).
type Observation = (f64, i32, f64, f64, f64, bool, f64);

/// The joint of a machine's file, behind its amplifier and its encoder.
#[pyclass(unsendable)]
pub struct Joint {
    document: Document,
    spreads: Vec<KeySpread>,
    drawn: Vec<String>,
    plant: AnyPlant,
    drive: Drive,
    sample_time_s: f64,
    count_deg: f64,
    nm_per_v: Option<f64>,
    samples: u64,
    applied_v: f64,
}

/// The plant of a file, with its solver.
enum AnyPlant {
    /// An axis in closed form, or the joint that replaces it.
    Plain(Box<Plant<RunJoint>>),
    /// A data sheet with effects of drive and encoder.
    Sheet(Box<Plant<SheetAxis>>),
}

impl AnyPlant {
    fn of(plan: &RunPlan) -> Result<Self, Error> {
        plan.refuse_current_loop()?;
        let closed_loop = plan.closed_loop()?;
        Ok(match plan.sheet_axis()? {
            Some(axis) => Self::Sheet(Box::new(closed_loop.plant(axis))),
            None => Self::Plain(Box::new(closed_loop.plant(plan.joint()?))),
        })
    }
}

/// Puts a code out, moves the plant to the next sample, and returns the effort, V.
fn advance<S: AxisSolver>(plant: &mut Plant<S>, code: i16) -> f64 {
    let effort_v = plant.put_out(code);
    plant.hold(effort_v, plant.sample_time_s(), &mut |_| {});
    effort_v
}

fn observed<S: AxisSolver>(plant: &Plant<S>, time_s: f64, applied_v: f64) -> Observation {
    let solver = &plant.solver;
    (
        time_s,
        plant.counts(),
        plant.position_deg(),
        solver.at_load(),
        plant.velocity_deg_per_s(),
        solver.stuck(),
        applied_v,
    )
}

/// Returns the first run of a document without its variants.
fn first_plan(document: &Document) -> Result<RunPlan, Error> {
    let plan = Experiment::without_variants(document, &[])?.into_iter().next();
    plan.ok_or_else(|| Error::Input(format!("{}: there is nothing to run", document.origin)))
}

impl Joint {
    fn open(file: &str) -> Result<Self, Error> {
        let document = Document::open(file)?;
        if document.is_lab() {
            return Err(Error::Input(format!(
                "{file} is a friction experiment, which has no drive"
            )));
        }
        let plan = first_plan(&document)?;
        let keys = spreads(&document)?;
        Ok(Self {
            spreads: keys.iter().map(|key| KeySpread::read(key)).collect::<Result<_, _>>()?,
            drawn: Vec::new(),
            plant: AnyPlant::of(&plan)?,
            drive: *plan.closed_loop()?.controller.drive(),
            sample_time_s: plan.machine.sampling.sample_time_s(),
            count_deg: plan.machine.encoder.resolution_deg(),
            nm_per_v: plan.nm_per_v()?,
            samples: 0,
            applied_v: 0.0,
            document,
        })
    }

    fn start(&mut self, seed: Option<u64>) -> Result<(), Error> {
        let drawn = seed.map_or_else(Vec::new, |seed| drawn_keys(&self.spreads, seed, 0));
        let mut document = self.document.clone();
        document.draw(&drawn)?;
        self.plant = AnyPlant::of(&first_plan(&document)?)?;
        (self.drawn, self.samples, self.applied_v) = (drawn, 0, 0.0);
        Ok(())
    }

    fn observation(&self) -> Observation {
        let time_s = self.samples as f64 * self.sample_time_s;
        match &self.plant {
            AnyPlant::Plain(plant) => observed(plant, time_s, self.applied_v),
            AnyPlant::Sheet(plant) => observed(plant, time_s, self.applied_v),
        }
    }
}

#[pymethods]
impl Joint {
    #[new]
    fn new(file: &str) -> PyResult<Self> {
        Self::open(file).map_err(|error| exception(&error))
    }

    /// Puts the joint at rest at zero: the file's, or one that the seed draws around it.
    fn reset(&mut self, seed: Option<u64>) -> PyResult<Observation> {
        self.start(seed).map_err(|error| exception(&error))?;
        Ok(self.observation())
    }

    /// Holds an effort (V) for a sample, limited and rounded as the drive does.
    fn step(&mut self, effort_v: f32) -> Observation {
        let code = self.drive.code(effort_v);
        self.applied_v = match &mut self.plant {
            AnyPlant::Plain(plant) => advance(plant, code),
            AnyPlant::Sheet(plant) => advance(plant, code),
        };
        self.samples += 1;
        self.observation()
    }

    #[getter]
    fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    #[getter]
    fn count_deg(&self) -> f64 {
        self.count_deg
    }

    #[getter]
    fn largest_effort_v(&self) -> f64 {
        match &self.plant {
            AnyPlant::Plain(plant) => plant.volts(self.drive.max_code()),
            AnyPlant::Sheet(plant) => plant.volts(self.drive.max_code()),
        }
    }

    #[getter]
    fn nm_per_v(&self) -> Option<f64> {
        self.nm_per_v
    }

    #[getter]
    fn drawn(&self) -> Vec<String> {
        self.drawn.clone()
    }
}
