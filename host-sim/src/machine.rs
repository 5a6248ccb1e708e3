//! A machine's TOML: the joint, its encoder, its drive, its controllers, and what is asked of them.
//!
//! Every key carries its unit. A key that is not known is refused, and so is a value out of its range; only keys that
//! have an obvious neutral value may be left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::device::Device;
use crate::encoder::Rounding;
use crate::limits::LimitsTable;

/// A whole file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// One line for `stiction list`.
    #[serde(default)]
    pub title: String,
    /// Where it comes from: a table or section of the thesis.
    #[serde(default)]
    pub source: String,
    /// Its figures in the thesis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<FigureSource>,
    /// What is positioned.
    pub joint: Joint,
    /// Its encoder.
    pub encoder: Encoder,
    /// What moves it.
    pub drive: Drive,
    /// The sampled loop.
    #[serde(rename = "loop")]
    pub sampling: Loop,
    /// Controllers by name.
    pub controller: BTreeMap<String, Controller>,
    /// What it is to do.
    #[serde(default)]
    pub reference: Reference,
    /// Friction identification by ramps, instead of a reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identification: Option<Identification>,
    /// What only the controller board has; the simulator does not look at it.
    #[serde(default)]
    pub device: Device,
    /// Thresholds of the board's faults; the simulator does not look at them, either.
    #[serde(default)]
    pub limits: LimitsTable,
    /// How it is simulated.
    #[serde(default)]
    pub run: Run,
    /// Variants of all of the above.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variant: Vec<Variant>,
}

/// Which figures of the thesis a controller's result answers to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSource {
    /// A controller, a controller and its variant (`srnf/test-1`), or all variants in one figure (`pd/*`).
    pub of: String,
    /// "Figs. 38 and 58".
    pub thesis: String,
    /// The motions whose control signal is broken down (`step-5.0`); left out: the first one.
    #[serde(default)]
    pub breakdown: Vec<String>,
}

/// `[joint]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// kappa.
    pub gain_deg_per_s2_per_v: f64,
    /// b.
    pub viscous_v_per_deg_per_s: f64,
    /// `[joint.friction]`.
    pub friction: Friction,
}

/// `[joint.friction]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// T_s.
    pub stick_v: f64,
    /// T_d.
    pub slip_v: f64,
    /// Static velocity range D_v of the banded form (solver `rk4`).
    #[serde(default = "thesis_band")]
    pub band_deg_per_s: f64,
    /// Added to both levels.
    #[serde(default)]
    pub added_v: f64,
    /// When it is added; left out: always.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_during_s: Option<Vec<[f64; 2]>>,
}

/// Table 21.
const fn thesis_band() -> f64 {
    1e-4
}

/// `[encoder]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Joint angle of one count.
    pub resolution_deg: f64,
    /// 16 or 32.
    pub counter_bits: u8,
    /// Sense of counting.
    #[serde(default)]
    pub direction: Direction,
    /// How a position between two counts is read (simulator only).
    #[serde(default)]
    pub rounding: Rounding,
    /// Where the joint's zero lies between two counts, in counts (simulator only).
    #[serde(default)]
    pub phase: f64,
}

/// Sense of counting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Up when the joint moves the positive way.
    #[default]
    Forward,
    /// Down.
    Reverse,
}

/// `[drive]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Largest output.
    pub full_scale_v: f64,
    /// Volts of one code.
    pub lsb_v: f64,
    /// Frequency of the PWM.
    pub pwm_hz: f64,
    /// How the code reaches the bridge.
    pub mode: PwmMode,
}

/// How the code reaches the bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PwmMode {
    /// Half duty is zero.
    LockedAntiphase,
    /// Duty and a direction pin.
    SignMagnitude,
}

/// `[loop]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loop {
    /// Time between samples.
    pub sample_time_s: f64,
    /// Positions in the velocity regression.
    #[serde(default = "thesis_window")]
    pub velocity_window: usize,
    /// The controllers to run, in this order; a device runs the first.
    pub controller: Names,
}

/// Section 3.2.
const fn thesis_window() -> usize {
    5
}

/// One name or a list of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a controller's name or a list of names")]
pub enum Names {
    /// `controller = "srnf"`.
    One(String),
    /// `controller = ["pd", "srnf"]`.
    Several(Vec<String>),
}

impl Names {
    /// As a list.
    pub fn list(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// `[controller.NAME]`: the gains of PD and of the laws that are added to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Laws whose sum is the compensator. Left out: the law that has the controller's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laws: Option<Vec<LawName>>,
    /// Kp.
    pub kp_v_per_deg: f64,
    /// Kd.
    pub kd_v_per_deg_per_s: f64,
    /// Ki of RI or RVI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ki_v_per_deg_s: Option<f64>,
    /// Range of RI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub theta_ri_deg: Option<f64>,
    /// gamma of RVI, for 20 ms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma_deg2_per_s2: Option<f64>,
    /// T_roi of ROI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_roi_s: Option<f64>,
    /// V_roi of ROI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub v_roi_deg_per_s: Option<f64>,
    /// V_ff of the feedforward.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub v_ff_deg_per_s: Option<f64>,
    /// v_slip of the feedforward.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub v_slip_v: Option<f64>,
    /// theta_b of DNPF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub theta_b_deg: Option<f64>,
    /// v_ms of SRNF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub v_ms_v: Option<f64>,
    /// alpha of SRNF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alpha_per_deg: Option<f64>,
}

/// The thesis's laws by their short names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LawName {
    /// Nothing but PD.
    Pd,
    /// Reset integral.
    Ri,
    /// Rate variable integral.
    Rvi,
    /// Reset offset integral.
    Roi,
    /// Slip friction feedforward.
    Feedforward,
    /// Discontinuous nonlinear proportional feedback.
    Dnpf,
    /// Smooth robust nonlinear feedback.
    Srnf,
}

/// `[reference]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Step sizes; each is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps_deg: Vec<f64>,
    /// Motions through corners; each is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trajectories: Vec<Trajectory>,
}

/// `[[reference.trajectories]]`: straight lines between corners, with parabolic blends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    /// Times of the corners; taken to the nearest sample.
    pub corner_times_s: Vec<f64>,
    /// Positions of the corners.
    pub corner_positions_deg: Vec<f64>,
    /// Half the time of a blend.
    pub half_blend_s: f64,
}

/// `[identification]`: ramps that find the two friction levels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identification {
    /// Each is a run.
    pub ramp_rates_v_per_s: Vec<f64>,
    /// How long the effort is held between the ramp up and the ramp down.
    pub hold_s: f64,
}

/// `[run]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Run {
    /// Left out: 10 s for a step, 3 s past the last corner for a trajectory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Computation delay: 0 or 1.
    pub delay_samples: u8,
    /// How the axis is solved between samples.
    pub solver: Solver,
    /// Step of `rk4`; coarser ones jump over the velocity band (see [`crate::solver::Rk4Axis`]).
    pub step_s: f64,
}

impl Default for Run {
    fn default() -> Self {
        Self { duration_s: None, delay_samples: 0, solver: Solver::Exact, step_s: 1e-5 }
    }
}

/// How the axis is solved between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// Closed form with located switching; Karnopp's friction with velocity zero while stuck.
    #[default]
    Exact,
    /// Fixed-step Runge-Kutta with Karnopp's velocity band.
    Rk4,
}

/// `[[variant]]`: the same runs with some keys set otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Appended to the label; empty for the runs as they stand.
    pub slug: String,
    /// `"table.key" = value`.
    #[serde(default)]
    pub set: toml::Table,
}
