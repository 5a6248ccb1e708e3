//! File of a friction experiment. The name of every key has its unit. For a rotating mechanism,
//! `_nm` replaces `_n`, and `_rad` replaces `_m`.

use serde::{Deserialize, Serialize};

use friction_lab::mechanism::Shape;
use friction_lab::solver::banded::BandCoupling;

/// File of a friction experiment.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// One line for `stiction list`.
    #[serde(default)]
    pub title: String,
    /// Source of the experiment: a table of the thesis.
    #[serde(default)]
    pub source: String,
    /// Figures of the thesis that show the experiment.
    #[serde(default)]
    pub figures: Vec<LabFigureSource>,
    /// Mechanism on which the friction acts.
    pub mechanism: MechanismTable,
    /// Friction levels, and the parameters of each model.
    pub friction: FrictionTable,
    /// Models to run, and settings of the solver.
    pub run: RunTable,
}

/// Figure of the thesis that shows the result of a model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabFigureSource {
    /// Friction model.
    pub of: FrictionModel,
    /// Number of the figure, such as "Fig. 9a".
    pub thesis: String,
}

/// Kind of the mechanism on which the friction acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MechanismKind {
    /// One block, pushed by a periodic force.
    Block,
    /// One block, pulled by a spring whose far end moves.
    SpringMass,
    /// Two blocks: friction 1 acts between them, friction 2 between block 2 and the floor.
    CoupledBlocks,
    /// Two blocks: both frictions act between a block and the floor.
    IndependentBlocks,
    /// Arm with one link.
    Pendulum,
    /// Arm with two links.
    TwoLinkArm,
}

impl MechanismKind {
    /// Returns the number of bodies.
    pub const fn bodies(self) -> usize {
        match self {
            Self::Block | Self::SpringMass | Self::Pendulum => 1,
            Self::CoupledBlocks | Self::IndependentBlocks | Self::TwoLinkArm => 2,
        }
    }

    /// Returns whether the coordinates are angles.
    pub const fn turns(self) -> bool {
        matches!(self, Self::Pendulum | Self::TwoLinkArm)
    }
}

/// `[mechanism]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismTable {
    /// Kind of the mechanism.
    pub kind: MechanismKind,
    /// Mass m of each body, kg.
    pub mass_kg: Vec<f64>,
    /// Stiffness K of each spring, N/m.
    pub stiffness_n_per_m: Option<Vec<f64>>,
    /// Motion of the far end of the first spring.
    pub pull: Option<PullTable>,
    /// Periodic force on a block.
    pub push: Option<PushTable>,
    /// Length l of each link, m.
    pub length_m: Option<Vec<f64>>,
    /// Torque T on each link, N m.
    pub torque_nm: Option<Vec<f64>>,
    /// Angles of the links at the start, rad; left out: hanging down.
    pub start_rad: Option<Vec<f64>>,
}

/// `[mechanism.pull]`: velocity V_o of the far end of the first spring.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PullTable {
    /// Constant speed or, with a frequency, largest speed, m/s.
    pub speed_m_per_s: f64,
    /// Time at which the motion stops, s; left out: never.
    pub until_s: Option<f64>,
    /// Frequency of `V_o = speed cos(frequency t)`, rad/s; left out: constant speed.
    pub frequency_rad_per_s: Option<f64>,
}

/// `[mechanism.push]`: periodic force F_i on a block.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushTable {
    /// Shape of the wave.
    pub shape: ShapeName,
    /// Largest force, N.
    pub amplitude_n: f64,
    /// Period, s.
    pub period_s: f64,
}

/// Shape of a wave.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShapeName {
    /// +1, 0, -1, 0, each for a quarter of the period.
    Square,
    /// Straight lines from 0 to +1, to -1, and back to 0.
    Triangle,
}

impl From<ShapeName> for Shape {
    fn from(name: ShapeName) -> Self {
        match name {
            ShapeName::Square => Self::Square,
            ShapeName::Triangle => Self::Triangle,
        }
    }
}

/// `[friction]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTable {
    /// Static friction F_s or T_s of each body, N or N m.
    #[serde(alias = "stick_nm")]
    pub stick_n: Option<Vec<f64>>,
    /// Dynamic friction F_d or T_d of each body, N or N m.
    #[serde(alias = "slip_nm")]
    pub slip_n: Option<Vec<f64>>,
    /// Deflection p_o of a bristle before it slides, m or rad. A model's default parameters follow
    /// from it.
    #[serde(alias = "range_rad")]
    pub range_m: Option<Vec<f64>>,
    /// `[friction.karnopp-banded]`.
    #[serde(rename = "karnopp-banded")]
    pub karnopp_banded: Option<ModelTable>,
    /// `[friction.reset-integrator]`.
    #[serde(rename = "reset-integrator")]
    pub reset_integrator: Option<ModelTable>,
    /// `[friction.tanh]`.
    pub tanh: Option<ModelTable>,
    /// `[friction.stribeck]`.
    pub stribeck: Option<ModelTable>,
    /// `[friction.dahl]`.
    pub dahl: Option<ModelTable>,
    /// `[friction.lugre]`.
    pub lugre: Option<ModelTable>,
    /// `[friction.elastic-coulomb]`.
    #[serde(rename = "elastic-coulomb")]
    pub elastic_coulomb: Option<ModelTable>,
    /// `[friction.maxwell-slip]`.
    #[serde(rename = "maxwell-slip")]
    pub maxwell_slip: Option<ModelTable>,
}

/// Parameters of a model. A rule of the model replaces a parameter that is left out.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    /// Half width D_v of Karnopp's velocity band, m/s or rad/s.
    #[serde(alias = "band_rad_per_s")]
    pub band_m_per_s: Option<Vec<f64>>,
    /// Stiffness of the bristle (K_r, sigma0 or K), N/m or N m/rad.
    #[serde(alias = "stiffness_nm_per_rad")]
    pub stiffness_n_per_m: Option<Vec<f64>>,
    /// Damping of the bristle (beta, sigma1 or D), N s/m or N m s/rad.
    #[serde(alias = "damping_nm_s_per_rad")]
    pub damping_n_s_per_m: Option<Vec<f64>>,
    /// Gradient a of the Reset Integrator.
    pub gradient: Option<Vec<f64>>,
    /// Stribeck velocity v_s, or the break-away speed of `tanh`, m/s or rad/s.
    #[serde(alias = "speed_rad_per_s")]
    pub speed_m_per_s: Option<Vec<f64>>,
    /// Exponent d of Stribeck's curve.
    pub exponent: Option<Vec<f64>>,
    /// Viscous coefficient sigma2, N s/m or N m s/rad.
    #[serde(alias = "viscous_nm_s_per_rad")]
    pub viscous_n_s_per_m: Option<Vec<f64>>,
    /// Attraction C of the generalized Maxwell-slip model, N/s or N m/s.
    #[serde(alias = "attraction_nm_per_s")]
    pub attraction_n_per_s: Option<Vec<f64>>,
}

/// Friction model, by its name in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionModel {
    /// Stick and slip at exactly zero velocity (thesis Fig. 1a).
    Classical,
    /// Karnopp's model with velocity zero while stuck: a computable form of the classical model.
    Karnopp,
    /// Karnopp's model with the thesis's velocity band.
    KarnoppBanded,
    /// Haessig and Friedland's Reset Integrator (thesis eqs. 2-5).
    ResetIntegrator,
    /// Friction smoothed by a hyperbolic tangent (thesis section 4.2).
    Tanh,
    /// Set-valued friction that falls from F_s to F_d with the speed.
    Stribeck,
    /// One bristle without F_s.
    Dahl,
    /// One damped bristle with Stribeck's curve.
    #[serde(rename = "lugre")]
    LuGre,
    /// One damped spring whose force is limited by Stribeck's curve.
    ElasticCoulomb,
    /// Several springs side by side, each with its share of the friction.
    MaxwellSlip,
}

/// Solver, by its name in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// With error control. Every switch of set-valued friction and of the Reset Integrator is
    /// located; the other models have no sharp switches, and their events are reported at the ends
    /// of steps.
    #[default]
    Exact,
    /// Runge-Kutta method with a fixed step.
    Rk4,
    /// Runge-Kutta method with a variable step, by step doubling.
    Rk4Adaptive,
    /// Backward Euler with the convex stick problem.
    Nonsmooth,
}

/// `[run]`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunTable {
    /// Duration of a run, s.
    pub duration_s: f64,
    /// Friction models; each is a run.
    pub friction: Vec<FrictionModel>,
    /// Solver of all runs.
    #[serde(default)]
    pub solver: SolverName,
    /// Coupling between the velocity bands of several bodies (`karnopp-banded`).
    #[serde(default)]
    pub coupling: BandCoupling,
    /// Largest error of a step of `exact`, relative to the largest value so far.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Step of `rk4` and `nonsmooth`, s.
    #[serde(default = "default_step_s")]
    pub step_s: f64,
    /// Relative error eps of a step of `rk4-adaptive`.
    #[serde(default = "thesis_eps")]
    pub eps: f64,
}

const fn default_tolerance() -> f64 {
    1e-8
}

const fn default_step_s() -> f64 {
    1e-5
}

/// Default of `eps`: thesis section 2.2.1.
const fn thesis_eps() -> f64 {
    2e-4
}

/// Returns the name of a value in a file.
pub fn name_of<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}
