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

use stiction::control::current_loop::{CurrentTarget, periods};
use stiction::control::period_work::{PeriodState, PeriodWork};
use stiction::control::winding_pulses::GroupSums;
use stiction::servo::{Boot, Output, Servo, State};
use stiction::{Parameters, Tick};

use crate::plant::{EffortState, Plant};
use crate::shunt::Shunt;
use dynamics::solver::{AxisSolver, Event};
use files::hardware::STM32F405;

/// Returns half a period of the PWM, s, for the number of periods in a sample time.
pub fn half_period_s(sample_time_s: f64, periods: u32) -> f64 {
    0.5 * sample_time_s / f64::from(periods)
}

/// A motor on a bridge, with a sensor of its current.
pub trait SensedMotor {
    /// Holds the duty of a code for a time (s), and returns the current at its end, A.
    fn hold(&mut self, code: i16, is_on: bool, duration_s: f64) -> f64;

    /// Returns the converter's reading of a current, A.
    fn read(&mut self, current_a: f64) -> u16;
}

/// The motor of a plant, with its shunt.
#[derive(Debug)]
pub struct PlantMotor<'a, S, F> {
    /// The plant.
    pub plant: &'a mut Plant<S>,
    /// Its shunt.
    pub shunt: &'a mut Shunt,
    /// Called with each event of the joint.
    pub on_event: F,
}

impl<S: AxisSolver, F: FnMut(Event)> SensedMotor for PlantMotor<'_, S, F> {
    fn hold(&mut self, code: i16, is_on: bool, duration_s: f64) -> f64 {
        let effort = EffortState { volts: self.plant.volts(code), is_on };
        self.plant.hold_driven_and_report(effort, duration_s, &mut self.on_event);
        self.plant.current_a()
    }

    fn read(&mut self, current_a: f64) -> u16 {
        self.shunt.reading(current_a)
    }
}

/// Command of a tick for the bridge of a current loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BridgeCommand {
    /// The bridge is off.
    Off,
    /// The bridge is at zero volts, and the loop does not run.
    ShortBrake,
    /// The loop regulates the current.
    Regulate(CurrentTarget),
}

/// What a tick of the servo commands its current loop.
#[derive(Clone, Copy, Debug)]
pub struct RegulatedTick {
    /// Work of the motion in each period.
    pub of: PeriodWork,
    /// Command until the next tick.
    pub command: BridgeCommand,
    /// Limits of the converter's watchdog.
    pub window: Option<[u16; 2]>,
}

impl RegulatedTick {
    /// Returns the command of a tick; `None` if the effort is a voltage. `voltage` is the code that
    /// the loop has put out last.
    pub fn of(servo: &mut Servo, output: &Output, voltage: i16) -> Option<Self> {
        let of = servo.period_work()?;
        let command = match (output.enable, output.state) {
            (false, _) => BridgeCommand::Off,
            (true, State::Armed) => BridgeCommand::Regulate(servo.regulate(&output.tick, voltage)),
            (true, _) => BridgeCommand::ShortBrake,
        };
        Some(Self { of, command, window: servo.current_window() })
    }
}

/// A current loop without a servo around it: no limit of the current, no faults.
#[derive(Clone, Debug)]
pub struct BareCurrentLoop {
    of: PeriodWork,
    /// Back-EMF of a speed of one deg/s, codes.
    back_emf: f32,
    /// Current of a step of the converter, A, and its reading without a current.
    unit_a: f32,
    zero: u16,
    shunt: Shunt,
    periods: CurrentPeriods,
}

impl BareCurrentLoop {
    /// Prepares the loop of validated parameters; `None` if the effort is a voltage.
    pub fn of(parameters: &Parameters) -> Option<Self> {
        let servo = Servo::new(Ok(parameters), Boot::at_zero(), &STM32F405);
        let mut shunt = Shunt::of(&parameters.current);
        let zero = shunt.reading(0.0);
        let of = match servo.period_work()? {
            PeriodWork::Regulate(of) => PeriodWork::Regulate(of.with_offset(zero.into())),
            pulses @ PeriodWork::Pulse(_) => pulses,
        };
        let back_emf = parameters.limits.back_emf / parameters.controller.drive.lsb;
        let unit_a = parameters.current.unit(STM32F405.supply_top);
        let periods = CurrentPeriods { reading: zero, ..CurrentPeriods::default() };
        Some(Self { of, back_emf, unit_a, zero, shunt, periods })
    }

    /// Returns the current that the sensor has measured last, A.
    pub fn current(&self) -> f32 {
        self.unit_a * (f32::from(self.periods.reading) - f32::from(self.zero))
    }

    /// Drives the motor of a plant from a tick to the next one, under the code that takes effect
    /// now.
    pub fn drive<S: AxisSolver>(
        &mut self,
        plant: &mut Plant<S>,
        tick: &Tick,
        code: i16,
        on_event: &mut impl FnMut(Event),
    ) {
        let induced = (self.back_emf * tick.velocity) as i16;
        let command = BridgeCommand::Regulate(CurrentTarget { effort: code, induced });
        let sample_time_s = plant.sample_time_s();
        let mut motor = PlantMotor { plant, shunt: &mut self.shunt, on_event };
        let regulated = RegulatedTick { of: self.of, command, window: None };
        self.periods.pass(&mut motor, sample_time_s, regulated);
    }
}

/// The periods of the PWM between two ticks.
#[derive(Clone, Debug, Default)]
pub struct CurrentPeriods {
    /// The work of the present motion; none with the bridge off.
    running: Option<(PeriodWork, PeriodState)>,
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

    /// Returns the readings of the motion's pulses, once they are over.
    pub fn sums(&self) -> Option<GroupSums> {
        self.running.as_ref().and_then(|(of, state)| of.sums(state).copied())
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
        RegulatedTick { of, command, window }: RegulatedTick,
    ) {
        let clocks = sample_time_s * f64::from(STM32F405.pwm_clock_hz);
        let number = periods(clocks.round() as u32, of.top()).unwrap_or(1);
        let half_s = half_period_s(sample_time_s, number);
        self.currents_a.clear();
        for _ in 0..number {
            let is_on = command != BridgeCommand::Off && self.tripped.is_none();
            let running = (is_on && command != BridgeCommand::ShortBrake)
                .then(|| self.running.take().unwrap_or((of, PeriodState::NONE)));
            if running.is_none() {
                self.code = 0;
            }
            let current_a = motor.hold(self.code, is_on, half_s);
            self.currents_a.push(current_a);
            self.reading = motor.read(current_a);
            motor.hold(self.code, is_on, half_s);
            self.running = running;
            if is_on && window.is_some_and(|[low, high]| !(low..=high).contains(&self.reading)) {
                self.tripped = Some(self.reading);
            }
            let (Some((running, state)), BridgeCommand::Regulate(target)) =
                (&mut self.running, command)
            else {
                continue;
            };
            self.code = running.step(state, target, self.reading);
        }
    }
}
