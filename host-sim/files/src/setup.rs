//! The file of a friction experiment. Every key carries its unit; where a mechanism turns, `_n`
//! reads `_nm`, `_m` reads `_rad`.

use serde::{Deserialize, Serialize};

use friction_lab::mechanism::Shape;
use friction_lab::solver::banded::BandCoupling;

/// A whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// One line for `stiction list`.
    #[serde(default)]
    pub title: String,
    /// Where it comes from: a table of the thesis.
    #[serde(default)]
    pub source: String,
    /// Its figures in the thesis.
    #[serde(default)]
    pub figures: Vec<LabFigureSource>,
    /// Mechanism on which the friction acts.
    pub mechanism: MechanismTable,
    /// The levels of friction, and what each model adds to them.
    pub friction: FrictionTable,
    /// How it is run.
    pub run: RunTable,
}

/// Which figures of the thesis a model's result answers to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabFigureSource {
    /// The model.
    pub of: FrictionModel,
    /// "Fig. 9a".
    pub thesis: String,
}

/// What friction acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MechanismKind {
    /// A block under a wave of force.
    Block,
    /// A block on a spring.
    SpringMass,
    /// Two blocks, friction 1 between them.
    CoupledBlocks,
    /// Two blocks, both frictions to the floor.
    IndependentBlocks,
    /// One link.
    Pendulum,
    /// Two links.
    TwoLinkArm,
}

impl MechanismKind {
    /// How many bodies.
    pub const fn bodies(self) -> usize {
        match self {
            Self::Block | Self::SpringMass | Self::Pendulum => 1,
            Self::CoupledBlocks | Self::IndependentBlocks | Self::TwoLinkArm => 2,
        }
    }

    /// Whether coordinates are angles.
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
    /// m.
    pub mass_kg: Vec<f64>,
    /// K of blocks on springs.
    pub stiffness_n_per_m: Option<Vec<f64>>,
    /// The far end of the first spring.
    pub pull: Option<PullTable>,
    /// The force on a block.
    pub push: Option<PushTable>,
    /// l of links.
    pub length_m: Option<Vec<f64>>,
    /// T of links.
    pub torque_nm: Option<Vec<f64>>,
    /// Angles of links at the begin; left out: hanging down.
    pub start_rad: Option<Vec<f64>>,
}

/// `[mechanism.pull]`: V_o.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PullTable {
    /// Speed, or its largest value.
    pub speed_m_per_s: f64,
    /// When it stops; left out: never.
    pub until_s: Option<f64>,
    /// Of `V_o = speed cos(frequency t)`; left out: constant speed.
    pub frequency_rad_per_s: Option<f64>,
}

/// `[mechanism.push]`: F_i.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushTable {
    /// Its shape.
    pub shape: ShapeName,
    /// Largest force.
    pub amplitude_n: f64,
    /// Period.
    pub period_s: f64,
}

/// Shape of a wave.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShapeName {
    /// +1, 0, -1, 0.
    Square,
    /// 0, +1, -1, 0 with straight lines between.
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
    /// F_s or T_s of each body.
    #[serde(alias = "stick_nm")]
    pub stick_n: Option<Vec<f64>>,
    /// F_d or T_d of each body.
    #[serde(alias = "slip_nm")]
    pub slip_n: Option<Vec<f64>>,
    /// p_o: how far a bristle bends before it slides; of the models that have bristles.
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

/// What a model has of its own; a rule of the model stands in for what is left out.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    /// Half width D_v of Karnopp's band, m/s.
    #[serde(alias = "band_rad_per_s")]
    pub band_m_per_s: Option<Vec<f64>>,
    /// K_r, sigma0 or K of the bristle.
    #[serde(alias = "stiffness_nm_per_rad")]
    pub stiffness_n_per_m: Option<Vec<f64>>,
    /// beta, sigma1 or D of the bristle.
    #[serde(alias = "damping_nm_s_per_rad")]
    pub damping_n_s_per_m: Option<Vec<f64>>,
    /// a of the Reset Integrator.
    pub gradient: Option<Vec<f64>>,
    /// v_s, or the break-away speed of `tanh`.
    #[serde(alias = "speed_rad_per_s")]
    pub speed_m_per_s: Option<Vec<f64>>,
    /// d of Stribeck's curve.
    pub exponent: Option<Vec<f64>>,
    /// sigma2.
    #[serde(alias = "viscous_nm_s_per_rad")]
    pub viscous_n_s_per_m: Option<Vec<f64>>,
    /// C of the generalized Maxwell-slip model.
    #[serde(alias = "attraction_nm_per_s")]
    pub attraction_n_per_s: Option<Vec<f64>>,
}

/// Friction models by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionModel {
    /// Stick and slip at exactly zero velocity (thesis Fig. 1a).
    Classical,
    /// Karnopp's with velocity zero while stuck, which is the classical one made computable.
    Karnopp,
    /// Karnopp's with the thesis's velocity band.
    KarnoppBanded,
    /// Haessig and Friedland's (thesis eqs. 2-5).
    ResetIntegrator,
    /// Smoothed (thesis section 4.2).
    Tanh,
    /// Set-valued, falling from F_s to F_d with the speed.
    Stribeck,
    /// One bristle without F_s.
    Dahl,
    /// One damped bristle with Stribeck's curve.
    #[serde(rename = "lugre")]
    LuGre,
    /// One elastic element whose force is cut at Stribeck's curve.
    ElasticCoulomb,
    /// Several elements side by side.
    MaxwellSlip,
}

/// Solvers by their names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// Error-controlled. Every switch of set-valued friction and of the Reset Integrator is
    /// located; the other models have no sharp switches, and their events are reported at the ends
    /// of steps.
    #[default]
    Exact,
    /// Fixed step.
    Rk4,
    /// Step doubling.
    Rk4Adaptive,
    /// Backward Euler with the convex stick problem.
    Nonsmooth,
}

/// `[run]`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunTable {
    /// How long.
    pub duration_s: f64,
    /// The models, one run each.
    pub friction: Vec<FrictionModel>,
    /// How they are solved.
    #[serde(default)]
    pub solver: SolverName,
    /// How the bands of several bodies depend on each other (`karnopp-banded`).
    #[serde(default)]
    pub coupling: BandCoupling,
    /// Of `exact`: a step's error, relative to the largest value so far.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Step of `rk4` and `nonsmooth`, s.
    #[serde(default = "default_step_s")]
    pub step_s: f64,
    /// eps of `rk4-adaptive`.
    #[serde(default = "thesis_eps")]
    pub eps: f64,
}

const fn default_tolerance() -> f64 {
    1e-8
}

const fn default_step_s() -> f64 {
    1e-5
}

/// Section 2.2.1.
const fn thesis_eps() -> f64 {
    2e-4
}

/// The name that a file has for it.
pub fn name_of<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}
