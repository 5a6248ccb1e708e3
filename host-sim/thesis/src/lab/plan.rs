//! From a document to its runs: one for each model of friction, and whether model and solver fit.

use std::sync::Arc;

use files::document::{Document, Origin};
use files::error::{Error, rounded, shown};
use files::setup::{FrictionModel, Setup, SolverName, name_of};
use friction_lab::solver::banded::BandCoupling;

/// Steps of a fixed-step solver, and a guess at those of the exact one: minutes.
const MAX_STEPS: f64 = 1e8;

/// Shortest run, s: the times of its samples must differ.
const SHORTEST_S: f64 = 1e-9;

/// One run of the friction lab.
#[derive(Clone, Debug)]
pub struct LabPlan {
    /// The name of the run in all output, such as `karnopp-banded/rk4/neglected`.
    pub label: String,
    /// The model of friction.
    pub model: FrictionModel,
    /// The tables of the file.
    pub setup: Arc<Setup>,
    /// The file and what was set by hand, for messages.
    pub origin: Origin,
    /// The file's tables as this run uses them.
    pub parameters: serde_json::Value,
}

/// Plans all runs of a document.
///
/// # Errors
/// Names the key, what was found and what is allowed.
pub fn plan(document: &Document) -> Result<Vec<LabPlan>, Error> {
    let setup = Arc::new(document.setup()?);
    let origin = document.origin.clone();
    let models = &setup.run.friction;
    if models.is_empty() {
        let at = origin.of("run.friction");
        return Err(Error::Input(format!(
            "{at}: `run.friction` is empty; must be at least one \
            model"
        )));
    }
    let mut plans = Vec::new();
    for (i, model) in models.iter().enumerate() {
        if models[..i].contains(model) {
            let (at, name) = (origin.of("run.friction"), name_of(model));
            return Err(Error::Input(format!("{at}: `run.friction` names `{name}` twice")));
        }
        let plan = LabPlan {
            label: label(*model, &setup),
            model: *model,
            setup: setup.clone(),
            origin: origin.clone(),
            parameters: parameters(document, *model, &setup),
        };
        plan.fits()?;
        plan.affordable()?;
        plan.check_models()?;
        plans.push(plan);
    }
    Ok(plans)
}

fn label(model: FrictionModel, setup: &Setup) -> String {
    let mut label = format!("{}/{}", name_of(&model), name_of(&setup.run.solver));
    if setup.run.coupling != BandCoupling::Simultaneous {
        label += &format!("/{}", name_of(&setup.run.coupling));
    }
    label
}

/// What the file says, without the tables of other models, and with what it leaves to the defaults
/// of `run`.
fn parameters(document: &Document, model: FrictionModel, setup: &Setup) -> serde_json::Value {
    let table = |key: &str| serde_json::to_value(document.get(key)).unwrap_or_default();
    let (mut friction, own) = (table("friction"), name_of(&model));
    if let Some(tables) = friction.as_object_mut() {
        tables.retain(|key, value| !value.is_object() || *key == own);
    }
    let mut run = serde_json::to_value(&setup.run).unwrap_or_default();
    run["friction"] = own.into();
    serde_json::json!({ "mechanism": table("mechanism"), "friction": friction, "run": run })
}

impl LabPlan {
    /// Returns the solver.
    pub fn solver(&self) -> SolverName {
        self.setup.run.solver
    }

    /// Whether model, solver and coupling go together.
    fn fits(&self) -> Result<(), Error> {
        use SolverName::{Exact, Nonsmooth, Rk4, Rk4Adaptive};
        let (model, solver) = (name_of(&self.model), name_of(&self.solver()));
        let refuse = |why: &str| {
            let at = self.origin.of("run.solver");
            Err(Error::Input(format!(
                "{at}: `{model}` does not go with the solver `{solver}`, because {why}"
            )))
        };
        match (self.model, self.solver()) {
            (
                FrictionModel::Classical | FrictionModel::Karnopp | FrictionModel::Stribeck,
                Rk4 | Rk4Adaptive,
            ) => refuse(
                "steps that locate nothing never meet the velocity zero at which it sticks; take \
                 `karnopp-banded`, or the solver `exact` or `nonsmooth`",
            ),
            (FrictionModel::KarnoppBanded, Exact | Nonsmooth) => refuse(
                "a body in its velocity band is neither at rest nor in motion, and there is no \
                 switch to locate; take `karnopp`, or the solver `rk4` or `rk4-adaptive`",
            ),
            (FrictionModel::MaxwellSlip, Exact) => refuse(
                "the rates of its elements jump where they begin to slip, and those instants are \
                 not located; take the solver `nonsmooth`, `rk4` or `rk4-adaptive`",
            ),
            (FrictionModel::ResetIntegrator, Nonsmooth) => refuse(
                "its friction drops at the end of its range, so that its implicit step has no \
                 single \
                 solution; take the solver `exact`, `rk4` or `rk4-adaptive`",
            ),
            _ => Ok(()),
        }?;
        if self.setup.run.coupling == BandCoupling::Simultaneous {
            return Ok(());
        }
        let coupling = name_of(&self.setup.run.coupling);
        let refuse = |why: &str| {
            let at = self.origin.of("run.coupling");
            Err(Error::Input(format!("{at}: the coupling `{coupling}` does not go with {why}")))
        };
        if self.model != FrictionModel::KarnoppBanded {
            return refuse(&format!("`{model}`: it is a way to compute `karnopp-banded` only"));
        }
        if self.bodies() == 1 {
            return refuse("a mechanism of one body, which is coupled to nothing");
        }
        Ok(())
    }

    /// Refuses runs that would take too long.
    fn affordable(&self) -> Result<(), Error> {
        let run = &self.setup.run;
        self.check("run.duration_s", run.duration_s, run.duration_s >= SHORTEST_S, || {
            format!("a number from {SHORTEST_S:e} up")
        })?;
        self.above_zero("run.step_s", run.step_s)?;
        self.check(
            "run.tolerance",
            run.tolerance,
            (1e-14..=1e-2).contains(&run.tolerance),
            || "a number from 1e-14 to 0.01".into(),
        )?;
        self.check("run.eps", run.eps, (1e-14..=1e-1).contains(&run.eps), || {
            "a number from 1e-14 to 0.1".into()
        })?;
        let (step_s, what) = match run.solver {
            // A step ends at every corner of a wave, too.
            SolverName::Rk4 | SolverName::Nonsmooth if run.step_s <= self.wave_quarter_s() => {
                (run.step_s, "steps of `run.step_s`")
            }
            SolverName::Rk4 | SolverName::Nonsmooth => {
                (self.wave_quarter_s(), "of a quarter of the wave's period")
            }
            SolverName::Exact | SolverName::Rk4Adaptive => {
                (self.time_scale_s()?, "of the mechanism's own time scale")
            }
        };
        let longest_s = MAX_STEPS * step_s;
        self.check("run.duration_s", run.duration_s, run.duration_s <= longest_s, || {
            let limit = rounded(0.999 * longest_s);
            format!(
                "a number up to {limit}, which is {MAX_STEPS:e} times {} s {what}",
                rounded(step_s)
            )
        })
    }

    pub(super) fn bodies(&self) -> usize {
        self.setup.mechanism.kind.bodies()
    }

    pub(super) fn above_zero(&self, key: &str, value: f64) -> Result<(), Error> {
        self.check(key, value, value > 0.0, || "a number above 0".into())
    }

    /// Refuses a value that is not finite or not `good`.
    pub(super) fn check(
        &self,
        key: &str,
        value: f64,
        good: bool,
        allowed: impl FnOnce() -> String,
    ) -> Result<(), Error> {
        if value.is_finite() && good {
            return Ok(());
        }
        Err(self.refuse(key, &shown(value), &allowed()))
    }

    pub(super) fn refuse(&self, key: &str, found: &str, allowed: &str) -> Error {
        Error::Input(format!("{}: `{key}` is {found}; must be {allowed}", self.origin.of(key)))
    }

    /// Returns one value for each body if each is finite and `good`. `key` is the key of the linear
    /// mechanism; that of a rotary one is derived from it.
    pub(super) fn each<const N: usize>(
        &self,
        key: &str,
        values: Option<&Vec<f64>>,
        allowed: &str,
        good: impl Fn(usize, f64) -> bool,
    ) -> Result<[f64; N], Error> {
        let key = &self.key(key);
        let Some(values) = values else {
            return Err(Error::Input(format!("{}: `{key}` is missing", self.origin.of(key))));
        };
        let Ok(array) = <[f64; N]>::try_from(values.as_slice()) else {
            let found = format!("a list of {}", values.len());
            return Err(self.refuse(key, &found, &format!("a list of {N}, one for each body")));
        };
        for (i, value) in array.iter().enumerate() {
            self.check(&format!("{key}[{i}]"), *value, good(i, *value), || allowed.into())?;
        }
        Ok(array)
    }

    /// The key as this mechanism's file has it: `_n` and `_m` are `_nm` and `_rad` where it turns.
    pub(super) fn key(&self, key: &str) -> String {
        const TURNED: [(&str, &str); 9] = [
            ("stick_n", "stick_nm"),
            ("slip_n", "slip_nm"),
            ("range_m", "range_rad"),
            ("band_m_per_s", "band_rad_per_s"),
            ("speed_m_per_s", "speed_rad_per_s"),
            ("stiffness_n_per_m", "stiffness_nm_per_rad"),
            ("damping_n_s_per_m", "damping_nm_s_per_rad"),
            ("viscous_n_s_per_m", "viscous_nm_s_per_rad"),
            ("attraction_n_per_s", "attraction_nm_per_s"),
        ];
        let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
        let turned =
            TURNED.iter().find(|(straight, _)| *straight == last).map(|(_, turned)| *turned);
        match turned {
            Some(turned) if tables.starts_with("friction") && self.setup.mechanism.kind.turns() => {
                format!("{tables}.{turned}")
            }
            _ => key.into(),
        }
    }
}
