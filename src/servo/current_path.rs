//! The motor's current in the servo: its sensor, the limit of the effort by it, and its faults.
//!
//! ```text
//!                     +-> limit of the effort (control::current_limit) -> output stage
//! reading -> current -+-> open or shorted wire, sensor (safety::motor_current)
//!                     +-> heat of the winding (safety::monitor)
//! effort, speed -> target -> current loop of the board (control::current_loop), if configured
//! converter's watchdog -> over-current, within a period of the PWM
//! ```
//!
//! A board without a converter of the current, or parameters without `[current_sensor]`, have none
//! of this.

use super::Servo;
use crate::control::controller::EffortMode;
use crate::control::current_limit::{CurrentLimit, CurrentLimitState};
use crate::control::current_loop::{CurrentLoop, CurrentTarget};
use crate::control::current_sensor::Driven;
use crate::control::drive::{Drive, DriveConfig, PwmMode};
use crate::control::hardware::Hardware;
use crate::control::period_work::PeriodWork;
use crate::control::signal::Tick;
use crate::motion::Course;
use crate::parameters::Parameters;
use crate::safety::fault::{Fault, LatchedFault};
use crate::safety::motor_current::{MotorCurrent, MotorCurrentState};

/// The sensor of the motor's current, with all that follows from it.
#[derive(Clone, Debug)]
pub(super) struct CurrentPath {
    sensor: MotorCurrent,
    state: MotorCurrentState,
    limit: Option<CurrentLimit>,
    limit_state: CurrentLimitState,
    /// The current loop, if the effort is a current, and the back-EMF of a speed of one deg/s,
    /// codes.
    current_loop: Option<CurrentLoop>,
    back_emf: f32,
    /// Code of the voltage that this loop had put out at the last tick, and the ratio of the supply
    /// to the nominal one.
    voltage: i16,
    supply: f32,
    /// Nominal supply in the converter's units; zero: not known.
    nominal_supply: f32,
}

/// Lowest and highest effort that a current allows, V; none: the current does not limit the effort.
pub(super) type Bounds = Option<[f32; 2]>;

impl CurrentPath {
    /// Prepares the sensor of validated parameters; none without one.
    pub fn of(parameters: &Parameters, drive: Drive, hardware: &Hardware) -> Option<Self> {
        let Parameters { current, controller, device, limits, .. } = parameters;
        let is_regulated = controller.effort == EffortMode::Current;
        let DriveConfig { full_scale, lsb, duty_max, .. } = controller.drive;
        // A leg that waits for its dead time costs that share of the supply, for which the full
        // scale stands. In sign-magnitude one leg switches, with the dead time of the driver.
        let legs = match controller.drive.mode {
            PwmMode::LockedAntiphase => 2.0,
            PwmMode::SignMagnitude | PwmMode::Analog => 1.0,
        };
        let dead_time = legs * device.dead_time * controller.drive.pwm_hz * full_scale;
        let sample_time = controller.sample_time;
        let of_motor = [limits.back_emf, dead_time, sample_time];
        let sensor = MotorCurrent::of(
            current,
            hardware.supply_top,
            of_motor,
            controller.velocity_window,
            is_regulated.then_some(full_scale * duty_max),
        )?;
        let unit = sensor.unit();
        let limit = CurrentLimit::of(current, limits.back_emf, sample_time);
        Some(Self {
            sensor,
            state: MotorCurrentState::default(),
            limit: limit.map(|limit| if is_regulated { limit.of_target() } else { limit }),
            limit_state: CurrentLimitState::default(),
            current_loop: is_regulated
                .then(|| CurrentLoop::new(current, unit, &controller.drive, drive)),
            back_emf: limits.back_emf / lsb,
            voltage: 0,
            supply: 1.0,
            nominal_supply: parameters.nominal_supply(hardware),
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
        self.voltage = 0;
    }

    /// Measures and checks the current of a tick. Returns the lowest and the highest effort that it
    /// allows, V, if the current limits the effort; or else the fault and the current, A.
    pub fn measure(&mut self, reading: u16, driven: &Driven) -> Result<Bounds, (Fault, f32)> {
        let current = self.sensor.measure(&mut self.state, reading);
        if let Some(trip) = self.sensor.check(&mut self.state, driven) {
            return Err(trip);
        }
        let limit = self.limit.as_ref();
        Ok(limit.map(|limit| limit.bounds(&mut self.limit_state, current, driven)))
    }

    /// Measures the current of a tick in a short brake, and returns whether it is beyond
    /// `peak_a` by a quarter.
    #[cold]
    pub fn brakes_beyond(&mut self, reading: u16) -> bool {
        self.sensor.measure(&mut self.state, reading);
        self.is_beyond_limit()
    }

    /// Returns whether the current of the last tick is beyond `peak_a` by a quarter.
    #[cold]
    pub fn is_beyond_limit(&self) -> bool {
        self.limit.as_ref().is_some_and(|limit| limit.is_beyond(self.current()))
    }

    /// Returns what the last tick has done, with the effort that the controller has applied (V) and
    /// the speed of the joint (deg/s). The voltage of a current loop is that of the supply.
    pub fn driven(&self, target: f32, speed: f32, travel: i32) -> Driven {
        let (effort, supply) = match &self.current_loop {
            Some(of) => (of.volts(self.voltage) * self.supply, self.supply),
            None => (target, 1.0),
        };
        Driven { effort, target, speed, supply, travel }
    }

    /// Returns the current of the last tick, A.
    pub const fn current(&self) -> f32 {
        self.state.current()
    }

    /// Returns the current of a tick in a short brake, as the effort at standstill that causes it,
    /// V.
    pub fn brake_volts(&self) -> f32 {
        self.sensor.volts(&self.state)
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

    /// Returns whether the effort is a current, which a current loop of the board makes.
    #[inline]
    pub fn has_current_loop(&self) -> bool {
        let path = self.control_loop.as_ref().and_then(|running| running.current.as_ref());
        path.is_some_and(|path| path.current_loop.is_some())
    }

    /// Returns the work of the motion that begins in each period of the PWM: the current loop with
    /// the present offset of the sensor, or the pulses of a measurement of the winding; none if the
    /// effort is a voltage.
    pub fn period_work(&self) -> Option<PeriodWork> {
        let control_loop = self.control_loop.as_ref()?;
        let path = control_loop.current.as_ref()?;
        let of = path.current_loop?;
        Some(match &control_loop.course {
            Course::Winding(test) => PeriodWork::Pulse(test.pulses()),
            _ => PeriodWork::Regulate(of.with_offset(path.sensor.offset(&path.state))),
        })
    }

    /// Returns the command for the current loop until the next tick: the effort of a tick, and the
    /// back-EMF at its speed. `voltage` is the code that the loop has put out last.
    pub fn regulate(&mut self, tick: &Tick, voltage: i16) -> CurrentTarget {
        let supply = self.follower.supply;
        let path = self.control_loop.as_mut().and_then(|running| running.current.as_mut());
        let induced = path.map_or(0.0, |path| {
            path.voltage = voltage;
            if path.nominal_supply > 0.0 {
                path.supply = f32::from(supply) / path.nominal_supply;
            }
            path.back_emf * tick.velocity
        });
        CurrentTarget { effort: tick.code, induced: induced as i16 }
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
