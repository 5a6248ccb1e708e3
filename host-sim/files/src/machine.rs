//! Tables of a machine's file: joint, encoder, drive, controllers, references.
//!
//! The name of every key has its unit. Unknown keys and values out of range are refused; only keys
//! with an obvious neutral value have a default. `schemars(rename)` keeps the names of the tables
//! in the JSON schema (`stiction keys --schema`), which editors read.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, MapAccess, Unexpected};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use stiction::control::brake_resistor::BrakeResistor;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::drive::DriveConfig;
use stiction::control::encoder::Encoder;
use stiction::control::laws::{Gains, RobustGains};
use stiction::control::motor_encoder::MotorEncoder;
use stiction::control::motor_ntc::MotorNtc;
use stiction::motion::jog::JogBounds;
use stiction::parameters::DeviceConfig;
use stiction::units::value::Table as _;
use stiction::{ControllerConfig, Limits, ProfileLimits};

use crate::data_sheet::tables::{
    EncoderPlace, Gear, JointFriction, LoadEncoder, LoadTable, Motor, SupplyTable,
};
use crate::encoder::Rounding;
use crate::goal::PositionGoal;
use crate::written::{AllGains, Extras, ParameterTable};

/// A whole file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Machine")]
pub struct MachineFile {
    /// One line for `stiction list`.
    #[serde(default)]
    pub title: String,
    /// Where it comes from: a table or section of the thesis.
    #[serde(default)]
    pub source: String,
    /// Its figures in the thesis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<ThesisFigures>,
    /// The joint that is positioned (simulator only); a data sheet gives it.
    pub joint: JointTable,
    /// The motor of a data sheet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<Motor>,
    /// Its gear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gear: Option<Gear>,
    /// Its load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<LoadTable>,
    /// Its friction at the joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<JointFriction>,
    /// Its supply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<SupplyTable>,
    /// The encoder of the joint.
    pub encoder: ParameterTable<Encoder, Disc>,
    /// The load's encoder, if `[encoder]` is on the motor (data sheet).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_encoder: Option<LoadEncoder>,
    // One line of the schema.
    #[doc = "The motor's encoder in a file that was made from the parameters of a device with two \
             encoders: `[encoder]` is that of the load then. A data sheet has `[load_encoder]` \
             instead."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_encoder: Option<ParameterTable<MotorEncoder>>,
    /// The drive that moves it.
    pub drive: ParameterTable<DriveConfig>,
    /// The sampled loop.
    #[serde(rename = "loop")]
    pub sampling: ParameterTable<ControllerConfig, LoopExtras>,
    /// Controllers by name.
    pub controller: BTreeMap<String, ParameterTable<AllGains, Laws>>,
    /// What it is to do.
    #[serde(default)]
    pub reference: ReferenceTable,
    /// Friction identification by ramps, instead of a reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identification: Option<RampTable>,
    /// Tolerance and times by which its motions are judged.
    #[serde(default, skip_serializing_if = "PositionGoal::is_default")]
    pub goal: PositionGoal,
    /// What only the servo has; of the simulator, `--target servo` looks at it.
    #[serde(default)]
    pub device: ParameterTable<DeviceConfig>,
    /// Thresholds of the servo's faults; likewise.
    #[serde(default)]
    pub limits: ParameterTable<Limits>,
    /// Limits of a profiled move, as `device move` makes it; the experiments step.
    #[serde(default)]
    pub profile: ParameterTable<ProfileLimits>,
    /// Bounds of the guarded jog, which a device keeps; the simulator has no use for them.
    #[serde(default)]
    pub jog: ParameterTable<JogBounds>,
    /// The sensor of the motor's current, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_sensor: Option<ParameterTable<CurrentSensor>>,
    /// The brake resistor of the supply, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brake_resistor: Option<ParameterTable<BrakeResistor>>,
    /// The temperature sensor of the motor, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_ntc: Option<ParameterTable<MotorNtc>>,
    /// What an identification said of the joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identified: Option<IdentifiedTable>,
    // One line of the schema.
    #[doc = "How far the joint may be off, for `tune` and `device selftest`: by keys of the joint, \
             quoted, as in `\"joint.friction.stick_v\" = [0.3, 0.5]`, the lowest and the highest \
             value. `device identify --into` writes it."]
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub spread: BTreeMap<String, [f64; 2]>,
    /// How it is simulated.
    #[serde(default)]
    pub run: RunSettings,
    /// Variants of all of the above.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variant: Vec<Variant>,
}

impl MachineFile {
    /// Returns the encoder of the load if it closes the position loop. The motor's encoder then
    /// measures the velocity.
    pub fn load_encoder_in_loop(&self) -> Option<&LoadEncoder> {
        let position = self.sampling.extras.position;
        self.load_encoder.as_ref().filter(|_| position != Some(EncoderPlace::Motor))
    }

    /// Returns whether the loop has an encoder on the motor and one on the load.
    pub fn has_two_encoders(&self) -> bool {
        self.load_encoder_in_loop().is_some() || self.motor_encoder.is_some()
    }

    /// Returns the angle of a count of the encoder that closes the position loop, deg of the joint.
    pub fn count_deg(&self) -> f64 {
        self.load_encoder_in_loop()
            .map_or_else(|| self.encoder.resolution_deg(), LoadEncoder::count_deg)
    }
}

/// Which figures of the thesis a controller's result answers to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "FigureSource")]
pub struct ThesisFigures {
    // One line of the schema.
    #[doc = "A controller, a controller and its variant (`srnf/test-1`), or all variants in one \
             figure (`pd/*`)."]
    pub of: String,
    /// "Figs. 38 and 58".
    pub thesis: String,
    /// The motions whose control signal is broken down (`step-5.0`); left out: the first one.
    #[serde(default)]
    pub breakdown: Vec<String>,
}

/// `[joint]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Joint")]
pub struct JointTable {
    /// Acceleration of the joint for each volt of effort (kappa), deg/s^2 per V.
    pub gain_deg_per_s2_per_v: f64,
    /// Viscous friction (b), V s/deg.
    pub viscous_v_per_deg_per_s: f64,
    /// Friction levels of the joint, `[joint.friction]`.
    pub friction: JointFrictionLevels,
}

/// `[joint.friction]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Friction")]
pub struct JointFrictionLevels {
    /// Static friction: the effort at which the joint breaks away (T_s), V.
    pub stick_v: f64,
    /// Dynamic friction: the effort that keeps it moving slowly (T_d), V. Not above `stick_v`.
    pub slip_v: f64,
    /// Velocity below which the solver `rk4` takes the joint for stuck (D_v), deg/s.
    #[serde(default = "thesis_band")]
    pub band_deg_per_s: f64,
    /// Effort that is added to both friction levels, V.
    #[serde(default)]
    pub added_v: f64,
    /// Stretches of time in which it is added, s; left out: always.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_during_s: Option<Vec<[f64; 2]>>,
}

/// Default of `band_deg_per_s`: thesis Table 21.
const fn thesis_band() -> f64 {
    1e-4
}

/// Keys of `[encoder]` that only the simulator has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disc {
    /// Rounding of a position between two counts.
    pub rounding: Rounding,
    /// Place of the joint's zero between two counts, in counts.
    pub phase: f64,
    /// Lines of the disc, from a data sheet.
    pub lines: Option<u32>,
    /// Place of the disc, from a data sheet.
    pub at: Option<EncoderPlace>,
    /// Noise of a reading in counts, from a data sheet.
    pub noise_counts: u32,
    /// Time from the edge of the index to its capture, us.
    pub index_lag_us: f64,
}

impl Extras for Disc {
    const NAMES: &'static [&'static str] =
        &["rounding", "phase", "lines", "at", "noise_counts", "index_lag_us"];

    fn schema(generator: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        let rounding = "How a position between two counts is read (simulator only).";
        let phase = "Place of the joint's zero between two counts, -1 to 1 counts (simulator \
            only).";
        let lines = "Lines of the encoder's disc, a quarter of its counts in a turn (data sheet, \
            instead of `resolution_deg`).";
        let at = "Where the disc sits: on the motor, where the gear divides its counts, or on the \
            load (data sheet).";
        let noise = "Noise of a reading, 0 or 1 counts (data sheet).";
        let lag = "Time from the edge of the index (`device.index_counts`) to its capture, us, as \
            of an optocoupler or a filter: 0 to 10000 (simulator only).";
        vec![
            (generator.subschema_for::<Option<Rounding>>(), rounding),
            (generator.subschema_for::<Option<f64>>(), phase),
            (generator.subschema_for::<Option<u32>>(), lines),
            (generator.subschema_for::<Option<EncoderPlace>>(), at),
            (generator.subschema_for::<Option<u32>>(), noise),
            (generator.subschema_for::<Option<f64>>(), lag),
        ]
    }

    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<(), A::Error> {
        match name {
            "rounding" => self.rounding = map.next_value()?,
            "lines" => self.lines = map.next_value()?,
            "at" => self.at = map.next_value()?,
            "noise_counts" => self.noise_counts = map.next_value()?,
            "index_lag_us" => self.index_lag_us = map.next_value()?,
            _ => self.phase = map.next_value()?,
        }
        Ok(())
    }

    fn write<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("rounding", &self.rounding)?;
        map.serialize_entry("phase", &self.phase)?;
        self.lines.iter().try_for_each(|lines| map.serialize_entry("lines", lines))?;
        self.at.iter().try_for_each(|at| map.serialize_entry("at", at))?;
        if self.noise_counts > 0 {
            map.serialize_entry("noise_counts", &self.noise_counts)?;
        }
        if self.index_lag_us != 0.0 {
            map.serialize_entry("index_lag_us", &self.index_lag_us)?;
        }
        Ok(())
    }
}

/// Keys of `[loop]` beside those of the core.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopExtras {
    /// Names of the controllers to run, in this order; a device runs the first.
    pub controller: Option<Names>,
    /// Side of the gear whose encoder closes the position loop of a joint with two encoders.
    pub position: Option<EncoderPlace>,
}

impl LoopExtras {
    /// Returns the names of the controllers.
    pub fn list(&self) -> &[String] {
        self.controller.as_ref().map_or(&[], Names::list)
    }
}

impl Extras for LoopExtras {
    const NAMES: &'static [&'static str] = &["controller", "position"];

    fn schema(generator: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        let text = "The controllers to run, in this order; a device runs the first.";
        let position = "Side of the gear whose encoder closes the position loop, of a joint with \
            a `[load_encoder]`; the velocity is the motor's. Left out: `load`.";
        vec![
            (generator.subschema_for::<Names>(), text),
            (generator.subschema_for::<Option<EncoderPlace>>(), position),
        ]
    }

    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<(), A::Error> {
        match name {
            "position" => self.position = map.next_value()?,
            _ => self.controller = Some(map.next_value()?),
        }
        Ok(())
    }

    fn missing(&self) -> Option<&'static str> {
        self.controller.is_none().then_some("controller")
    }

    fn write<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        self.controller.iter().try_for_each(|names| map.serialize_entry("controller", names))?;
        self.position.iter().try_for_each(|side| map.serialize_entry("position", side))
    }
}

/// One name or a list of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a controller's name or a list of names")]
pub enum Names {
    /// `controller = "srnf"`.
    One(String),
    /// `controller = ["pd", "srnf"]`.
    Several(Vec<String>),
}

impl Names {
    /// Returns the names as a list.
    pub fn list(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// `laws` of `[controller.NAME]`: those whose sum is the compensator. Left out: the law that has
/// the controller's name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Laws {
    /// Names of the laws.
    pub laws: Option<Vec<LawName>>,
}

impl Extras for Laws {
    const NAMES: &'static [&'static str] = &["laws"];

    fn schema(generator: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        let text = "Laws whose sum is added to PD. Left out: the law that has the controller's \
            name.";
        vec![(generator.subschema_for::<Option<Vec<LawName>>>(), text)]
    }

    fn take<'de, A: MapAccess<'de>>(&mut self, _: &str, map: &mut A) -> Result<(), A::Error> {
        self.laws = map.next_value()?;
        Ok(())
    }

    fn write<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        self.laws.iter().try_for_each(|laws| map.serialize_entry("laws", laws))
    }
}

/// A law by its name in a file: one of the core's list, or `pd` for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawName(pub Option<Gains>);

/// Name of PD without a law.
pub const PD: &str = "pd";

impl LawName {
    /// Returns the law of a name; `None` if the name is unknown.
    pub fn find(name: &str) -> Option<Self> {
        if name == PD {
            return Some(Self(None));
        }
        let law = Gains::EXAMPLES.iter().find(|law| law.name() == name)?;
        Some(Self(Some(*law)))
    }

    /// Returns the name of the law in a file: `robust` is that of the law for one encoder and of
    /// the law for two.
    pub fn name(&self) -> &'static str {
        const ONE: Gains = Gains::Robust(RobustGains::EXAMPLE);
        match &self.0 {
            None => PD,
            Some(Gains::RobustDual(_)) => ONE.name(),
            Some(law) => law.name(),
        }
    }
}

impl<'de> Deserialize<'de> for LawName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let typed = String::deserialize(deserializer)?;
        Self::find(&typed).ok_or_else(|| {
            let all = [PD].iter().chain(Gains::NAMES).map(|name| format!("`{name}`"));
            let known = all.collect::<Vec<_>>().join(", ");
            D::Error::custom(format!("unknown variant `{typed}`, expected one of {known}"))
        })
    }
}

impl JsonSchema for LawName {
    fn schema_name() -> Cow<'static, str> {
        "LawName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = [PD].iter().chain(Gains::NAMES).copied().collect();
        json_schema!({ "enum": names })
    }
}

impl Serialize for LawName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// `[identified]`, as an identification has written it. Nothing is computed from it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Identified")]
pub struct IdentifiedTable {
    /// Its verdict in a word, such as "good".
    pub verdict: String,
    // One line of the schema.
    #[doc = "What was doubted, a sentence each. Commands that judge by the joint repeat it as \
             warnings."]
    #[serde(default)]
    pub doubts: Vec<String>,
}

/// `[reference]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Reference")]
pub struct ReferenceTable {
    /// Sizes of steps, deg; each is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps_deg: Vec<f64>,
    /// Motions through corners; each is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trajectories: Vec<TrajectoryTable>,
    /// Motions to and fro; each is a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sines: Vec<SineTable>,
}

/// `[[reference.trajectories]]`: straight lines between corners, with parabolic blends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Trajectory")]
pub struct TrajectoryTable {
    /// Times of the corners, s, taken to the nearest sample.
    pub corner_times_s: Vec<f64>,
    /// Positions of the corners, deg.
    pub corner_positions_deg: Vec<f64>,
    /// Half the time of a blend, s.
    pub half_blend_s: f64,
}

impl TrajectoryTable {
    /// Returns the speed of the first line on which the set point moves, deg/s; 0 if all are rests.
    pub fn speed(&self) -> f64 {
        let lines = self.corner_times_s.windows(2).zip(self.corner_positions_deg.windows(2));
        lines
            .map(|(t, p)| ((p[1] - p[0]) / (t[1] - t[0])).abs())
            .find(|speed| *speed > 0.0)
            .unwrap_or(0.0)
    }

    /// Returns the start of the first blend and the end of the last one, s.
    pub fn motion_s(&self) -> [f64; 2] {
        let [first, last] = [self.corner_times_s.first(), self.corner_times_s.last()]
            .map(|corner_s| corner_s.copied().unwrap_or(0.0));
        [first - self.half_blend_s, last + self.half_blend_s]
    }
}

/// `[[reference.sines]]`: `a (1 - cos 2 pi f t)`, from rest at zero to `2 a` and back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Sine")]
pub struct SineTable {
    /// Amplitude a, deg; below zero, the joint sets out backwards.
    pub amplitude_deg: f64,
    /// Frequency f, Hz.
    pub frequency_hz: f64,
}

/// `[identification]`: ramps that find the two friction levels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Identification")]
pub struct RampTable {
    /// Rates at which the effort rises and falls, V/s; each is a run.
    pub ramp_rates_v_per_s: Vec<f64>,
    /// Time for which the effort is held between the ramp up and the ramp down, s.
    pub hold_s: f64,
}

/// `[run]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Run")]
pub struct RunSettings {
    // One line of the schema.
    #[doc = "Time that a run lasts, s. Left out: 10 s for a step, 3 s past the last corner for a \
             trajectory, 3 periods but at least 10 s for a sine."]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Samples by which the output is late, 0 or 1.
    #[schemars(range(max = 1))]
    #[serde(deserialize_with = "zero_or_one")]
    pub delay_samples: u8,
    /// Method by which the axis is solved between samples.
    pub solver: AxisSolverName,
    /// Step of `rk4`, s; coarser ones jump over the velocity band.
    pub step_s: f64,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self { duration_s: None, delay_samples: 0, solver: AxisSolverName::Exact, step_s: 1e-5 }
    }
}

/// Reads the number of samples by which the output is late.
fn zero_or_one<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u8, D::Error> {
    const ALLOWED: &str = "the whole number 0 or 1";
    let found = toml::Value::deserialize(deserializer)?;
    match found {
        toml::Value::Integer(0) => Ok(0),
        toml::Value::Integer(1) => Ok(1),
        // The document adds the value, by its path.
        _ => Err(D::Error::invalid_value(Unexpected::Other("that"), &ALLOWED)),
    }
}

/// How the axis is solved between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Solver")]
pub enum AxisSolverName {
    /// Closed form with located switching; Karnopp's friction with velocity zero while stuck.
    #[default]
    Exact,
    /// Fixed-step Runge-Kutta with Karnopp's velocity band.
    Rk4,
}

/// `[[variant]]`: the same runs with some keys set otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Appended to the label; empty for the runs as they stand.
    pub slug: String,
    /// `"table.key" = value`.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: toml::Table,
}
