//! Tables of a data sheet in a file.
//!
//! Angles, speeds, stiffnesses and viscous coefficients are in degrees or in radians; the name of
//! the key has the unit. [`super::DataSheet`] converts both to SI.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiction::control::encoder::{Direction, EncoderOutput};
use stiction::control::motor_encoder;

/// What drives the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum DrivenBy {
    /// A bridge that sets the motor's voltage.
    #[default]
    Voltage,
    /// A servo amplifier that sets the motor's current.
    Current,
}

/// `[motor]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    // One line of the schema.
    #[doc = "What the output of the controller sets: the motor's voltage (a bridge), or its \
             current (a servo amplifier)."]
    #[serde(default)]
    pub driven_by: DrivenBy,
    /// Torque constant K_t at the motor's shaft, N m/A; in SI also that of the back-EMF, V s/rad.
    pub kt_nm_per_a: f64,
    /// Resistance of the winding R, ohm; needed if driven by a voltage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistance_ohm: Option<f64>,
    /// Inductance L of the winding, H; an amplifier that sets the current makes up for it.
    #[serde(default)]
    pub inductance_h: f64,
    /// Inertia of the rotor at the motor's shaft, kg m^2.
    #[serde(default)]
    pub rotor_inertia_kg_m2: f64,
    /// Largest current, A; left out: what the drive can give.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Current that the winding bears forever, A; left out: a tenth of the stall current.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rated_current_a: Option<f64>,
    /// Current of the amplifier for each volt of its input, A/V; needed if driven by a current.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplifier_a_per_v: Option<f64>,
    /// Speed of the motor without load at the supply's voltage, 1/min: a check of K_t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_load_rpm: Option<f64>,
    /// `no_load_rpm` in rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_load_rad_per_s: Option<f64>,
    // One line of the schema.
    #[doc = "Dead time of the bridge in locked antiphase, s: it costs 2 dead_time pwm_hz of the \
             supply against the current. `device.dead_time_s` follows it."]
    #[serde(default)]
    pub dead_time_s: f64,
    // One line of the schema.
    #[doc = "Thermal resistance from winding to case (data sheet: winding-housing), K/W. With the \
             three other thermal keys, a simulated winding heats up by its current; \
             `resistance_ohm` is then that at 20 deg C."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal_resistance_winding_k_per_w: Option<f64>,
    /// Thermal resistance from case to ambient air (data sheet: housing-ambient), K/W.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal_resistance_case_k_per_w: Option<f64>,
    /// Thermal time constant of the winding (data sheet), s; 0.1 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal_time_winding_s: Option<f64>,
    /// Thermal time constant of the motor, that of its case (data sheet), s; 0.1 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal_time_motor_s: Option<f64>,
    // One line of the schema.
    #[doc = "Temperature of the ambient air, and of the whole motor at the start, deg C from -60 \
             to 150; left out: 20."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient_c: Option<f64>,
}

/// `[gear]`; left out: the motor sits on the joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gear {
    /// Turns of the motor for a turn of the joint.
    pub ratio: f64,
    /// Efficiency, from above 0 to 1, taken as that of a motor that drives the load.
    pub efficiency: f64,
    /// Whole width of the backlash at the joint, deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_deg: Option<f64>,
    /// `backlash_deg` in rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_rad: Option<f64>,
    /// Torsional stiffness at the joint, N m/rad; left out: the gear is rigid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness_nm_per_rad: Option<f64>,
    /// `stiffness_nm_per_rad` in N m/deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness_nm_per_deg: Option<f64>,
    /// Torsional damping at the joint, N m s/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_nm_s_per_rad: Option<f64>,
    /// `damping_nm_s_per_rad` in N m s/deg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_nm_s_per_deg: Option<f64>,
}

impl Default for Gear {
    fn default() -> Self {
        Self {
            ratio: 1.0,
            efficiency: 1.0,
            backlash_deg: None,
            backlash_rad: None,
            stiffness_nm_per_rad: None,
            stiffness_nm_per_deg: None,
            damping_nm_s_per_rad: None,
            damping_nm_s_per_deg: None,
        }
    }
}

/// `[load]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Load")]
pub struct LoadTable {
    /// Inertia at the joint without the rotor's, kg m^2.
    pub inertia_kg_m2: f64,
    /// Constant torque on the joint, N m; positive drives it the positive way.
    #[serde(default)]
    pub constant_nm: f64,
    /// Largest torque of gravity on an unbalanced load, N m.
    #[serde(default)]
    pub unbalance_nm: f64,
    /// Position of the joint at which the load hangs down, deg; left out: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hangs_at_deg: Option<f64>,
    /// `hangs_at_deg` in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hangs_at_rad: Option<f64>,
    // One line of the schema.
    #[doc = "Lower hard stop of the joint, deg from where it is at power-on; below 0. Left out: \
             there is none."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_min_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Upper hard stop of the joint, deg from where it is at power-on; above 0. Left out: \
             there is none."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_max_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Edge of a homing switch (`device.home_switch`), deg from where the joint is at \
             power-on: the joint is at the switch from there on, away from power-on. Left out: it \
             never comes to one."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home_switch_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Hysteresis of the homing switch, deg: the joint leaves it so far behind its edge. \
             Left out: 0."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home_switch_hysteresis_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Time for which the contact of the homing switch bounces after a change, s. Left out: \
             0."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home_switch_bounce_s: Option<f64>,
}

/// `[friction]` of a data sheet, at the joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFriction {
    /// Static friction: the torque at which the joint breaks away, N m. Not below `slip_nm`.
    pub stick_nm: f64,
    /// Dynamic friction: the torque that keeps it moving slowly, N m.
    pub slip_nm: f64,
    /// Static friction the negative way, N m; left out: as the positive way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stick_reverse_nm: Option<f64>,
    /// Dynamic friction the negative way, N m; left out: as the positive way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slip_reverse_nm: Option<f64>,
    // One line of the schema.
    #[doc = "Stribeck velocity, deg/s: over it the friction falls from `stick_nm` to `slip_nm`. \
             Left out: it falls at once."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_deg_per_s: Option<f64>,
    /// `stribeck_deg_per_s` in rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_rad_per_s: Option<f64>,
    /// Viscous friction without that of the back-EMF, N m s/rad; left out: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscous_nm_s_per_rad: Option<f64>,
    /// `viscous_nm_s_per_rad` in N m s/deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscous_nm_s_per_deg: Option<f64>,
    /// Stiffness of LuGre's bristles (sigma0), N m/rad; left out: the friction is rigid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bristle_stiffness_nm_per_rad: Option<f64>,
    /// `bristle_stiffness_nm_per_rad` in N m/deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bristle_stiffness_nm_per_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Damping of the bristles (sigma1), N m s/rad; left out: 1.4 sqrt(sigma0 J), 0.7 of \
             critical."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bristle_damping_nm_s_per_rad: Option<f64>,
    /// `bristle_damping_nm_s_per_rad` in N m s/deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bristle_damping_nm_s_per_deg: Option<f64>,
    /// Part by which both levels rise and fall with the gear's angle, from 0 to below 1.
    #[serde(default)]
    pub ripple: f64,
    /// Periods of that in a turn of the joint; two a turn of the wave generator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ripple_per_turn: Option<f64>,
    /// Phase of that at position zero, deg.
    #[serde(default)]
    pub ripple_phase_deg: f64,
    // One line of the schema.
    #[doc = "Motor's part of the friction if the gear has a stiffness, from 0 to 1; the load has \
             the rest. Left out: 0.7."]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_share: Option<f64>,
}

/// `[supply]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Supply")]
pub struct SupplyTable {
    /// Voltage without load, V.
    pub voltage_v: f64,
    /// Internal resistance, ohm.
    #[serde(default)]
    pub internal_resistance_ohm: f64,
    /// Whether it takes current back that a braking motor gives.
    #[serde(default = "yes")]
    pub takes_current_back: bool,
    // One line of the schema.
    #[doc = "Capacitance at the bridge, F: a braking motor charges it, if the supply does not take \
             current back. A simulated device alone has it; 0: its supply is constant."]
    #[serde(default)]
    pub capacitance_f: f64,
}

const fn yes() -> bool {
    true
}

/// Where the encoder sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Side")]
pub enum EncoderPlace {
    /// On the motor's shaft: the gear divides its counts.
    Motor,
    /// On the joint.
    Load,
}

/// `[load_encoder]`: an encoder on the load, beside that of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LoadEncoder")]
pub struct LoadEncoder {
    /// Kind of the encoder: `as5047p` is a chip on SPI that reports the angle within a turn.
    #[serde(default, skip_serializing_if = "is_default")]
    pub kind: LoadEncoderKind,
    /// Counts in a turn of the joint; 16384 for an `as5047p`, whose magnet is on the joint.
    pub counts_per_turn: u32,
    /// Reading of an `as5047p` where the joint's position is zero, counts from 0 to 16383. Needed
    /// for that kind, and for no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_counts: Option<u32>,
    /// Noise of a reading, 0 or 1 counts.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub noise_counts: u32,
    /// Which way its counter runs when the joint moves the positive way.
    #[serde(default, skip_serializing_if = "is_default")]
    pub direction: LoadEncoderDirection,
    /// Output stage of the lines of an incremental encoder. The test for open lines at rest needs
    /// `push-pull`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub output: LoadEncoderOutput,
}

/// Kind of the load's encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadEncoderKind {
    /// It has two lines whose edges a timer counts.
    #[default]
    Incremental,
    /// It is a chip on SPI that reports the angle within a turn of the joint.
    As5047p,
}

impl From<LoadEncoderKind> for motor_encoder::LoadEncoderKind {
    fn from(kind: LoadEncoderKind) -> Self {
        match kind {
            LoadEncoderKind::Incremental => Self::Incremental,
            LoadEncoderKind::As5047p => Self::As5047p,
        }
    }
}

/// Which way the counter of the load's encoder runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadEncoderDirection {
    /// It counts up.
    #[default]
    Forward,
    /// It counts down.
    Reverse,
}

impl From<LoadEncoderDirection> for Direction {
    fn from(direction: LoadEncoderDirection) -> Self {
        match direction {
            LoadEncoderDirection::Forward => Self::Forward,
            LoadEncoderDirection::Reverse => Self::Reverse,
        }
    }
}

/// What drives the lines of the load's encoder at the input of the chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadEncoderOutput {
    /// Undeclared: the test for open lines is off.
    #[default]
    Unknown,
    /// The lines are driven up and down, without resistors that hold them: the test is on.
    PushPull,
    /// The lines are driven down, and a resistor pulls them up: the test is off.
    OpenCollector,
    /// A line receiver stands between cable and chip, and hides an open cable: the test is off.
    Receiver,
}

impl From<LoadEncoderOutput> for EncoderOutput {
    fn from(output: LoadEncoderOutput) -> Self {
        match output {
            LoadEncoderOutput::Unknown => Self::Unknown,
            LoadEncoderOutput::PushPull => Self::PushPull,
            LoadEncoderOutput::OpenCollector => Self::OpenCollector,
            LoadEncoderOutput::Receiver => Self::Receiver,
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

const fn is_zero(counts: &u32) -> bool {
    *counts == 0
}

impl LoadEncoder {
    /// Returns the angle of a count, deg.
    pub fn count_deg(&self) -> f64 {
        360.0 / f64::from(self.counts_per_turn)
    }
}
