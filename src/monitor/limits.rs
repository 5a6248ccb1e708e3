//! Thresholds of the monitors: `[limits]` of a machine's file.

use serde::{Deserialize, Serialize};

use crate::controller::ControllerConfig;
use crate::error::{Error, HUGE, between};
use crate::parameters::Device;

/// Thresholds in a user's units. Zero turns a monitor off; nothing else does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Travel in one tick, deg.
    pub encoder_jump: f32,
    /// Effort beyond any friction, V.
    pub stall_effort: f32,
    /// Time without a count under that effort, s.
    pub stall_time: f32,
    /// Travel against the effort in the first move after arming, deg.
    pub reversal: f32,
    /// Error beyond a jump of the set point, deg.
    pub following_error: f32,
    /// Measured speed, deg/s.
    pub overspeed: f32,
    /// Lowest position, deg from where the joint stood at power-on. Both limits zero: there are none.
    pub position_min: f32,
    /// Highest position, deg.
    pub position_max: f32,
    /// Lowest supply, V.
    pub supply_min: f32,
    /// Highest supply, V.
    pub supply_max: f32,
    /// Effort that the motor bears for ever, V.
    pub continuous_effort: f32,
    /// Time constant of the motor's winding, s.
    pub thermal_time: f32,
    /// Silence of the link that armed the servo, s.
    pub link_timeout: f32,
    /// Effort of the compensator at standstill that is reported, V.
    pub wind_up_effort: f32,
    /// How long it has to last, s.
    pub wind_up_time: f32,
}

/// The longest time of a monitor, s: its ticks and their sums stay far within 32 bits.
const LONGEST: f32 = 600.0;

impl Limits {
    /// No monitor at all, for tests of what is around them.
    pub const OFF: Self = Self {
        encoder_jump: 0.0,
        stall_effort: 0.0,
        stall_time: 0.2,
        reversal: 0.0,
        following_error: 0.0,
        overspeed: 0.0,
        position_min: 0.0,
        position_max: 0.0,
        supply_min: 0.0,
        supply_max: 0.0,
        continuous_effort: 0.0,
        thermal_time: 10.0,
        link_timeout: 0.0,
        wind_up_effort: 0.0,
        wind_up_time: 1.0,
    };

    /// What can be derived from the loop itself, for machines that say nothing of it. `breakaway` is the effort that
    /// starts the joint (V), or zero if it is not known.
    ///
    /// | limit | default | why |
    /// |---|---|---|
    /// | `overspeed` | 2.5 full scale / Kd | the damping alone would take two and a half times the output. On the thesis's joint a step of 25 deg passes under every law, and an unstable loop is seen within a second; at half as much again, or at the motor's own bound, its speed without load, some are not (`tests/device/thesis.rs`). Never below 16 counts a tick |
    /// | `encoder_jump` | the travel of a tick at twice that speed, and 4 counts | no motor accelerates like that |
    /// | `following_error` | full scale / Kp | beyond it more error gives no more effort |
    /// | `stall_effort`, `stall_time` | 2 breakaway (else half of the full scale), 0.2 s | PD rests with less than the breakaway effort for ever; an effort of twice that moves a free joint by a count within a tick |
    /// | `reversal` | 8 counts | from rest a joint goes where it is pushed; twice the noise that standstill allows |
    /// | `position_min`, `position_max` | none | only the user knows |
    /// | `supply_min`, `supply_max` | 0.7 and 1.3 of the nominal supply, if that is measured | |
    /// | `continuous_effort`, `thermal_time` | three quarters of the full scale, 10 s | the full scale for 8.3 s; the thesis's most violent oscillation heats like 0.7 of it. Nobody but the motor's data sheet knows better |
    /// | `link_timeout` | 0.5 s | five polls of a client that polls ten times a second |
    /// | `wind_up_effort`, `wind_up_time` | half of `stall_effort`: the breakaway effort; 1 s | |
    pub fn derived(controller: &ControllerConfig, device: &Device, breakaway: f32) -> Self {
        let full_scale = controller.drive.full_scale;
        let (count, sample_time) = (controller.encoder.resolution, controller.sample_time);
        let overspeed = match controller.pd.kd {
            kd if kd > 0.0 => (2.5 * full_scale / kd).max(16.0 * count / sample_time).min(HUGE),
            _ => 0.0,
        };
        let encoder_jump = match overspeed {
            0.0 => 0.0,
            speed => (2.0 * speed * sample_time + 4.0 * count).min(HUGE),
        };
        let following_error = match controller.pd.kp {
            kp if kp > 0.0 => (full_scale / kp).min(HUGE),
            _ => 0.0,
        };
        let stall_effort = match breakaway {
            v if v > 0.0 => (2.0 * v).min(full_scale),
            _ => 0.5 * full_scale,
        };
        Self {
            encoder_jump,
            stall_effort,
            stall_time: 0.2,
            reversal: (8.0 * count).min(HUGE),
            following_error,
            overspeed,
            position_min: 0.0,
            position_max: 0.0,
            supply_min: 0.7 * device.nominal_supply,
            supply_max: 1.3 * device.nominal_supply,
            continuous_effort: 0.75 * full_scale,
            thermal_time: 10.0,
            link_timeout: 0.5,
            wind_up_effort: 0.5 * stall_effort,
            wind_up_time: 1.0,
        }
    }

    /// Refuses what is negative or not a number, times that are too long, and a lowest position above the highest.
    ///
    /// # Errors
    /// Names the key.
    pub fn validate(&self) -> Result<(), Error> {
        between("encoder_jump_deg", self.encoder_jump, 0.0, HUGE)?;
        between("stall_v", self.stall_effort, 0.0, HUGE)?;
        between("stall_s", self.stall_time, 0.0, LONGEST)?;
        between("reversal_deg", self.reversal, 0.0, HUGE)?;
        between("following_error_deg", self.following_error, 0.0, HUGE)?;
        between("overspeed_deg_per_s", self.overspeed, 0.0, HUGE)?;
        between("position_min_deg", self.position_min, -HUGE, HUGE)?;
        between("position_max_deg", self.position_max, self.position_min, HUGE)?;
        between("supply_min_v", self.supply_min, 0.0, HUGE)?;
        between("supply_max_v", self.supply_max, 0.0, HUGE)?;
        between("continuous_v", self.continuous_effort, 0.0, HUGE)?;
        // Slower windings would change by less than a rounding in a tick of 0.1 ms.
        between("thermal_s", self.thermal_time, 0.1, 100.0)?;
        between("link_timeout_s", self.link_timeout, 0.0, LONGEST)?;
        between("wind_up_v", self.wind_up_effort, 0.0, HUGE)?;
        between("wind_up_s", self.wind_up_time, 0.0, LONGEST)
    }
}

/// What turns a user's units into those of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Deg of a count.
    pub count: f32,
    /// V of a code.
    pub code: f32,
    /// S of a tick.
    pub tick: f32,
    /// V of the converter's unit; zero if the supply is not measured.
    pub supply: f32,
}

impl Units {
    /// Whole units in a positive amount, never none: a threshold that is on stays on.
    pub fn whole(amount: f32, unit: f32) -> u32 {
        (libm::roundf(amount / unit) as u32).max(1)
    }

    /// A threshold in whole units that is never reached if it is zero.
    pub fn threshold(amount: f32, unit: f32) -> u32 {
        if amount > 0.0 && unit > 0.0 { Self::whole(amount, unit) } else { u32::MAX }
    }
}
