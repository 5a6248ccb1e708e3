//! The motor's current in the servo: its sensor, the limit of the effort by it, and its faults.
//!
//! ```text
//!                     +-> limit of the effort (control::current_limit) -> output stage
//! reading -> current -+-> open or shorted wire, sensor (safety::motor_current)
//!                     +-> heat of the winding (safety::monitor)
//! converter's watchdog -> over-current, within a period of the PWM
//! ```
//!
//! A board without a converter of the current, or parameters without `[current_sensor]`, have none
//! of this.

use super::Servo;
use crate::control::current_limit::{CurrentLimit, CurrentLimitState};
use crate::control::drive::PwmMode;
use crate::control::hardware::Hardware;
use crate::parameters::Parameters;
use crate::safety::fault::{Fault, LatchedFault};
use crate::safety::motor_current::{Driven, MotorCurrent, MotorCurrentState};

/// The sensor of the motor's current, with all that follows from it.
#[derive(Clone, Debug)]
pub(super) struct CurrentPath {
    sensor: MotorCurrent,
    state: MotorCurrentState,
    limit: Option<CurrentLimit>,
    limit_state: CurrentLimitState,
}

/// Lowest and highest effort that a current allows, V; none: the current does not limit the effort.
pub(super) type Bounds = Option<[f32; 2]>;

impl CurrentPath {
    /// Prepares the sensor of validated parameters; none without one.
    pub fn of(parameters: &Parameters, hardware: &Hardware) -> Option<Self> {
        let Parameters { current, controller, device, limits, .. } = parameters;
        // A leg that waits for its dead time twice a period costs that share of the supply, for
        // which the full scale stands.
        let dead_time = match controller.drive.mode {
            PwmMode::LockedAntiphase => {
                2.0 * device.dead_time * controller.drive.pwm_hz * controller.drive.full_scale
            }
            PwmMode::SignMagnitude | PwmMode::Analog => 0.0,
        };
        let sample_time = controller.sample_time;
        let of_motor = [limits.back_emf, dead_time, sample_time];
        Some(Self {
            sensor: MotorCurrent::of(
                current,
                hardware.supply_top,
                of_motor,
                controller.velocity_window,
            )?,
            state: MotorCurrentState::default(),
            limit: CurrentLimit::of(current, limits.back_emf, sample_time),
            limit_state: CurrentLimitState::default(),
        })
    }

    /// Takes a reading with the bridge off.
    // Out of line, as `ControlLoop::measure`.
    #[inline(never)]
    pub fn idle(&mut self, reading: u16, is_at_rest: bool) {
        self.sensor.idle(&mut self.state, reading, is_at_rest);
    }

    /// Returns whether the offset of the sensor is known.
    pub fn is_calibrated(&self) -> bool {
        self.sensor.is_calibrated(&self.state)
    }

    /// Returns whether the sensor is known to be faulty while no current flows.
    pub fn is_off(&self) -> bool {
        self.sensor.is_off(&self.state)
    }

    /// Begins a motion.
    pub fn arm(&mut self) {
        self.limit_state = CurrentLimitState::default();
    }

    /// Measures and checks the current of a tick. Returns the lowest and the highest effort that it
    /// allows, V, if the current limits the effort; or else the fault and the current, A.
    pub fn measure(&mut self, reading: u16, driven: &Driven) -> Result<Bounds, (Fault, f32)> {
        let current = self.sensor.measure(&mut self.state, reading);
        if let Some(trip) = self.sensor.check(&mut self.state, driven) {
            return Err(trip);
        }
        let limit = self.limit.as_ref();
        Ok(limit.map(|limit| limit.bounds(&mut self.limit_state, current, driven.speed)))
    }

    /// Returns the current of the last tick, A.
    pub const fn current(&self) -> f32 {
        self.state.current()
    }

    /// Returns the current that heats the winding, as the effort at standstill that causes it, V.
    pub fn heat_volts(&self) -> f32 {
        self.sensor.heat_volts(&self.state)
    }
}

impl Servo {
    /// Returns the lowest and the highest reading of the current that does not turn the bridge off,
    /// for the converter's watchdog; none without a sensor. It is fixed while the servo is armed.
    pub fn current_window(&self) -> Option<[u16; 2]> {
        let path = self.control_loop.as_ref()?.current.as_ref()?;
        Some(path.sensor.window(&path.state))
    }

    /// Latches the fault of a current beyond that window, which the converter's watchdog has seen.
    #[cold]
    #[inline(never)]
    pub fn over_current(&mut self, reading: u16) {
        let path = self.control_loop.as_ref().and_then(|running| running.current.as_ref());
        let value = path.map_or(0.0, |path| path.sensor.current(&path.state, reading));
        self.latch(LatchedFault { fault: Fault::OverCurrent, tick: self.clock, value });
    }
}
