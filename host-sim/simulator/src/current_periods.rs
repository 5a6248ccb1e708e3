//! A current loop with its plant, period by period of the PWM.
//!
//! ```text
//! count    /\      /\        top: the current is sampled, and the loop computes the next duty
//!         /  \    /  \
//! tick -> |---|--|---|--     bottom: the duty of the last sample takes effect
//! ```
//!
//! A control tick is at the lower end of the count: it reads the current of the last upper end, and
//! its target counts from the next one on.

use stiction::control::current_loop::{CurrentLoop, CurrentLoopState, CurrentTarget, periods};
use stiction::servo::{Output, Servo};

use crate::plant::{EffortState, Plant};
use crate::shunt::Shunt;
use dynamics::joint::RunJoint;
use files::hardware::STM32F405;

/// A motor on a bridge, with a sensor of its current.
pub trait SensedMotor {
    /// Holds the duty of a code for a time (s), and returns the current at its end, A.
    fn hold(&mut self, code: i16, is_on: bool, duration_s: f64) -> f64;

    /// Returns the converter's reading of a current, A.
    fn read(&mut self, current_a: f64) -> u16;
}

/// The motor of a plant, with its shunt.
#[derive(Debug)]
pub struct PlantMotor<'a> {
    /// The plant.
    pub plant: &'a mut Plant<RunJoint>,
    /// Its shunt.
    pub shunt: &'a Shunt,
}

impl SensedMotor for PlantMotor<'_> {
    fn hold(&mut self, code: i16, is_on: bool, duration_s: f64) -> f64 {
        let effort = EffortState { volts: self.plant.volts(code), is_on };
        self.plant.hold_driven(effort, duration_s);
        self.plant.current_a()
    }

    fn read(&mut self, current_a: f64) -> u16 {
        self.shunt.reading(current_a)
    }
}

/// What a tick of the servo commands its current loop.
#[derive(Clone, Copy, Debug)]
pub struct RegulatedTick {
    /// The loop.
    pub of: CurrentLoop,
    /// Target until the next tick; `None` with the bridge off.
    pub target: Option<CurrentTarget>,
    /// Limits of the converter's watchdog.
    pub window: Option<[u16; 2]>,
}

impl RegulatedTick {
    /// Returns the command of a tick; `None` if the effort is a voltage. `voltage` is the code that
    /// the loop has put out last.
    pub fn of(servo: &mut Servo, output: &Output, voltage: i16) -> Option<Self> {
        let of = servo.current_loop()?;
        let target = output.enable.then(|| servo.regulate(&output.tick, voltage));
        Some(Self { of, target, window: servo.current_window() })
    }
}

/// The periods of the PWM between two ticks.
#[derive(Clone, Debug, Default)]
pub struct CurrentPeriods {
    /// The loop of the present motion; none with the bridge off.
    running: Option<(CurrentLoop, CurrentLoopState)>,
    /// Code of the duty that has effect.
    code: i16,
    /// Last reading of the current.
    reading: u16,
    /// Current at the upper ends of the count since the last tick, A.
    currents_a: Vec<f64>,
    /// Reading beyond the limits of the converter's watchdog, if there was one.
    tripped: Option<u16>,
}

impl CurrentPeriods {
    /// Returns the last reading of the current.
    pub const fn reading(&self) -> u16 {
        self.reading
    }

    /// Returns the current at the upper ends of the count between the last two ticks, A.
    pub fn currents_a(&self) -> &[f64] {
        &self.currents_a
    }

    /// Returns the code of the voltage of the last period.
    pub const fn voltage(&self) -> i16 {
        self.code
    }

    /// Returns the reading that has turned the bridge off since the last tick, if one has.
    pub const fn take_trip(&mut self) -> Option<u16> {
        self.tripped.take()
    }

    /// Drives a motor from a tick to the next one, `sample_time_s` later.
    pub fn pass(
        &mut self,
        motor: &mut impl SensedMotor,
        sample_time_s: f64,
        RegulatedTick { of, target, window }: RegulatedTick,
    ) {
        let clocks = sample_time_s * f64::from(STM32F405.pwm_clock_hz);
        let number = periods(clocks.round() as u32, of.top()).unwrap_or(1);
        let half_s = 0.5 * sample_time_s / f64::from(number);
        self.currents_a.clear();
        for _ in 0..number {
            let is_on = target.is_some() && self.tripped.is_none();
            let running = is_on.then(|| self.running.take().unwrap_or((of, Default::default())));
            if running.is_none() {
                self.code = 0;
            }
            let current_a = motor.hold(self.code, is_on, half_s);
            self.currents_a.push(current_a);
            self.reading = motor.read(current_a);
            motor.hold(self.code, is_on, half_s);
            self.running = running;
            let (Some((running, state)), Some(target)) = (&mut self.running, target) else {
                continue;
            };
            if window.is_some_and(|[low, high]| !(low..=high).contains(&self.reading)) {
                self.tripped = Some(self.reading);
            }
            self.code = running.step(state, target, self.reading);
        }
    }
}
