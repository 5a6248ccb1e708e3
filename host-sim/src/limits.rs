//! `[limits]` of a machine's file: thresholds of the faults. Keys that are left out are derived.

use serde::{Deserialize, Serialize};
use stiction::{ControllerConfig, Limits, parameters};

use crate::machine::Joint;

/// `[limits]`. Zero turns a monitor off; `docs/faults.md` has what each is derived from when it is left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LimitsTable {
    /// Travel in one tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder_jump_deg: Option<f64>,
    /// Effort beyond any friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stall_v: Option<f64>,
    /// Time without a count under that effort.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stall_s: Option<f64>,
    /// Travel against the effort in the first move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reversal_deg: Option<f64>,
    /// Error beyond a jump of the set point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub following_error_deg: Option<f64>,
    /// Measured speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overspeed_deg_per_s: Option<f64>,
    /// Lowest position, from where the joint stood at power-on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_min_deg: Option<f64>,
    /// Highest position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_max_deg: Option<f64>,
    /// Lowest supply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_min_v: Option<f64>,
    /// Highest supply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_max_v: Option<f64>,
    /// Effort that the motor bears for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub continuous_v: Option<f64>,
    /// Time constant of the motor's winding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thermal_s: Option<f64>,
    /// Silence of the link that armed the servo.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link_timeout_s: Option<f64>,
    /// Effort of the compensator at standstill that is reported.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind_up_v: Option<f64>,
    /// How long it has to last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind_up_s: Option<f64>,
}

impl LimitsTable {
    /// The keys, as a machine's file has them.
    pub const KEYS: [&str; 15] = [
        "encoder_jump_deg",
        "stall_v",
        "stall_s",
        "reversal_deg",
        "following_error_deg",
        "overspeed_deg_per_s",
        "position_min_deg",
        "position_max_deg",
        "supply_min_v",
        "supply_max_v",
        "continuous_v",
        "thermal_s",
        "link_timeout_s",
        "wind_up_v",
        "wind_up_s",
    ];

    /// Every key, as a device has it; `single` writes a number.
    pub fn written_out(limits: &Limits, single: impl Fn(f32) -> f64) -> Self {
        let written = |value: f32| Some(single(value));
        Self {
            encoder_jump_deg: written(limits.encoder_jump),
            stall_v: written(limits.stall_effort),
            stall_s: written(limits.stall_time),
            reversal_deg: written(limits.reversal),
            following_error_deg: written(limits.following_error),
            overspeed_deg_per_s: written(limits.overspeed),
            position_min_deg: written(limits.position_min),
            position_max_deg: written(limits.position_max),
            supply_min_v: written(limits.supply_min),
            supply_max_v: written(limits.supply_max),
            continuous_v: written(limits.continuous_effort),
            thermal_s: written(limits.thermal_time),
            link_timeout_s: written(limits.link_timeout),
            wind_up_v: written(limits.wind_up_effort),
            wind_up_s: written(limits.wind_up_time),
        }
    }

    /// The thresholds of a device. What is left out is derived from the loop, and the breakaway effort is that of the
    /// joint that the file describes.
    pub fn thresholds(
        &self,
        controller: &ControllerConfig,
        device: &parameters::Device,
        joint: &Joint,
    ) -> Limits {
        let breakaway = joint.friction.stick_v + joint.friction.added_v.max(0.0);
        let derived = Limits::derived(controller, device, breakaway as f32);
        let or = |written: Option<f64>, derived: f32| written.map_or(derived, |value| value as f32);
        Limits {
            encoder_jump: or(self.encoder_jump_deg, derived.encoder_jump),
            stall_effort: or(self.stall_v, derived.stall_effort),
            stall_time: or(self.stall_s, derived.stall_time),
            reversal: or(self.reversal_deg, derived.reversal),
            following_error: or(self.following_error_deg, derived.following_error),
            overspeed: or(self.overspeed_deg_per_s, derived.overspeed),
            position_min: or(self.position_min_deg, derived.position_min),
            position_max: or(self.position_max_deg, derived.position_max),
            supply_min: or(self.supply_min_v, derived.supply_min),
            supply_max: or(self.supply_max_v, derived.supply_max),
            continuous_effort: or(self.continuous_v, derived.continuous_effort),
            thermal_time: or(self.thermal_s, derived.thermal_time),
            link_timeout: or(self.link_timeout_s, derived.link_timeout),
            wind_up_effort: or(self.wind_up_v, derived.wind_up_effort),
            wind_up_time: or(self.wind_up_s, derived.wind_up_time),
        }
    }
}
