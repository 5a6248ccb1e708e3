//! Monitors for a firmware of your own: the monitors of a device that need no board, in one call.
//!
//! ```text
//! effort = positioner.tick(...)
//! monitors.check(counts, target, effort) -> none: apply it;  a fault: turn the output off
//! ```
//!
//! They are the monitors of the servo, with its thresholds: [`Limits::derived`] and
//! [`Limits::of_gain`] of the joint's configuration. Each has its page in
//! [`monitor`](crate::safety::monitor).
//!
//! | fault | seen |
//! |---|---|
//! | encoder jump, overspeed, encoder reversed | counts that no joint makes |
//! | following error | the joint is farther from its target than effort helps |
//! | stall | effort beyond friction without its counts: a dead or noisy encoder, a stop |
//! | oscillation | swings around a target that rests |
//! | position limit | outside the configured range |
//! | overheat | effort for longer than the motor tolerates, by a model of its winding |
//!
//! They do not detect an encoder that dies while the joint rests (until the law pushes hard), a
//! supply out of range, a current, a stuck output, or a tick that comes late or not at all. So your
//! firmware still needs a watchdog and a limit of the current. The monitors end a runaway after it
//! has begun. How far the joint moves until then was measured for a device, which also probes its
//! encoder, and not for these monitors.

use super::config::check;
use super::{PositionerConfig, Refused, Target};
use crate::control::controller::ControllerConfig;
use crate::control::device_config::DeviceConfig;
use crate::control::drive::DriveConfig;
use crate::control::encoder::{CounterBits, Encoder};
use crate::control::hardware::Hardware;
use crate::control::laws::Gains;
use crate::control::signal::Tick;
use crate::control::velocity::{Velocity, VelocityState};
use crate::safety::fault::Fault;
use crate::safety::monitor::limits::Limits;
use crate::safety::monitor::{MonitorState, Monitors, Seen, Standstill};
use crate::units::error::HUGE;
use crate::units::value::Table;

/// Configuration of the monitors, beside that of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorConfig {
    /// Range of positions from the counter's zero, rad. Both zero: no range.
    pub range: [f32; 2],
    /// Effort that the motor tolerates forever at standstill.
    pub continuous_effort: f32,
    /// Time constant of the motor's winding, s.
    pub thermal_time: f32,
}

/// A fault and the value that tripped it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runaway {
    /// Detected fault.
    pub fault: Fault,
    /// Value that tripped the monitor; angles are in degrees.
    pub value: f32,
}

/// Monitors of a joint, prepared.
#[derive(Clone, Debug)]
pub struct RunawayMonitors {
    monitors: Monitors,
    velocity: Velocity,
}

/// State of the monitors from tick to tick. The heat stays when the output is turned off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunawayState {
    watch: MonitorState,
    standstill: Standstill,
    velocity: VelocityState,
    counts: i32,
}

/// Farthest end of the range, rad: its degrees are within the bounds of the monitor's limits.
const FARTHEST: f32 = 1e4;

/// Positions in the regression of the velocity, as in the thesis.
const WINDOW: u32 = 5;

/// Returns the limits of a device's monitors for a joint with the gain `gain` (deg/s^2 for an
/// effort of 1), within the bounds of their declarations.
fn limits(
    joint: &PositionerConfig,
    config: &MonitorConfig,
    controller: &ControllerConfig,
    device: &DeviceConfig,
    gain: f32,
) -> Limits {
    let derived = Limits::derived(controller, device, joint.breakaway[1] + joint.load);
    let limits = derived.of_gain(gain, controller);
    let [low, high] = config.range.map(f32::to_degrees);
    Limits {
        position_min: low,
        position_max: high,
        supply_min: 0.0,
        supply_max: 0.0,
        continuous_effort: config.continuous_effort,
        thermal_time: config.thermal_time,
        link_timeout: 0.0,
        // The servo pushes a joint at rest to test its encoder; a positioner does not.
        breakaway_min: derived.breakaway_effort,
        stop_gain: limits.stop_gain.min(HUGE),
        progress_gain: limits.progress_gain.min(HUGE),
        ..limits
    }
}

impl RunawayMonitors {
    /// Validates both configurations and prepares the monitors.
    ///
    /// # Errors
    /// Returns the first field that is outside its range.
    pub fn new(joint: &PositionerConfig, config: &MonitorConfig) -> Result<Self, Refused> {
        let (gains, around) = joint.prepared()?;
        let [low, high] = config.range;
        check("range[0]", low, [-FARTHEST, FARTHEST])?;
        check("range[1]", high, [low, FARTHEST])?;
        let effort = [1e-6 * joint.largest_effort, joint.largest_effort];
        check("continuous_effort", config.continuous_effort, effort)?;
        check("thermal_time", config.thermal_time, [0.1, 100.0])?;
        let drive = DriveConfig {
            full_scale: around.full_scale,
            lsb: around.lsb,
            duty_max: 1.0,
            ..DriveConfig::EXAMPLE
        };
        let encoder = Encoder {
            resolution: around.resolution,
            counter_bits: CounterBits::ThirtyTwo,
            ..Encoder::EXAMPLE
        };
        let controller = ControllerConfig {
            sample_time: around.sample_time,
            velocity_window: WINDOW,
            encoder,
            drive,
            compensator: core::iter::once(Gains::Robust(gains)).collect(),
            ..ControllerConfig::EXAMPLE
        };
        // Supply and link have monitors that need a board.
        let device = DeviceConfig { nominal_supply: 0.0, ..DeviceConfig::EXAMPLE };
        let hardware = Hardware {
            pwm_clock_hz: 0.0,
            supply_top: 1,
            dead_time_max: 0.0,
            sample_time: [0.0, 1.0],
        };
        let limits = limits(joint, config, &controller, &device, 1.0 / gains.inertia);
        Ok(Self {
            monitors: Monitors::new(&limits, &controller, &device, &hardware),
            velocity: Velocity::new(WINDOW, around.resolution, around.sample_time),
        })
    }

    /// Returns the state of the monitors before the first tick with output: the motor is cold, and
    /// the encoder's counter is at `counts`.
    pub fn start(&self, counts: i32) -> RunawayState {
        self.armed(&RunawayState::default(), counts)
    }

    /// Returns the state for turning the output on again at `counts`. The heat of the motor is
    /// kept.
    pub fn armed(&self, before: &RunawayState, counts: i32) -> RunawayState {
        let range = self.monitors.range(Some(0));
        let watch = self.monitors.armed(&before.watch, false, range);
        RunawayState { watch, counts, ..RunawayState::default() }
    }

    /// Checks a tick with output: the counter, the target, and the effort that is about to be
    /// applied. On a fault, turn the output off in this tick.
    pub fn check(
        &self,
        state: &mut RunawayState,
        counts: i32,
        target: Target,
        effort: f32,
    ) -> Option<Runaway> {
        let (seen, velocity) = self.see(state, counts);
        let setpoint = target.setpoint();
        let tick = Tick {
            counts,
            reference_counts: setpoint.position.counts,
            reference_velocity: setpoint.velocity,
            velocity,
            v_applied: effort,
            v_c: effort,
            ..Tick::default()
        };
        let trip = self.monitors.check(&mut state.watch, &seen, &tick, 0)?;
        Some(Runaway { fault: trip.fault, value: trip.value })
    }

    /// Updates the state in a tick without output: the motor cools.
    pub fn idle(&self, state: &mut RunawayState, counts: i32) {
        let (seen, _) = self.see(state, counts);
        self.monitors.idle(&mut state.watch, &seen);
    }

    /// Updates the state with the counter, and returns the inputs of the monitors and the velocity,
    /// deg/s.
    fn see(&self, state: &mut RunawayState, counts: i32) -> (Seen, f32) {
        let travel = counts.wrapping_sub(state.counts);
        state.counts = counts;
        let standstill = state.standstill.update(counts);
        let velocity = self.velocity.update(&mut state.velocity, travel);
        let seen = Seen {
            travel,
            position: counts,
            standstill,
            #[cfg(feature = "two-encoders")]
            motor: None,
            #[cfg(feature = "two-encoders")]
            missed: 0,
        };
        (seen, velocity)
    }
}
