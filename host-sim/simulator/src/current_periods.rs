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

use crate::plant::{EffortState, Plant};
use crate::shunt::Shunt;
use dynamics::joint::RunJoint;
use files::hardware::STM32F405;

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

    /// Moves a plant from a tick to the next one. `of` is the loop of the servo, `command` that
    /// of the tick, and `window` the limits of the watchdog.
    pub fn pass(
        &mut self,
        plant: &mut Plant<RunJoint>,
        shunt: &Shunt,
        of: &CurrentLoop,
        command: BridgeCommand,
        window: Option<[u16; 2]>,
    ) {
        let clocks = plant.sample_time_s() * f64::from(STM32F405.pwm_clock_hz);
        let number = periods(clocks.round() as u32, of.top()).unwrap_or(1);
        let half_s = 0.5 * plant.sample_time_s() / f64::from(number);
        self.currents_a.clear();
        for _ in 0..number {
            let is_on = command != BridgeCommand::Off && self.tripped.is_none();
            let running = (is_on && command != BridgeCommand::ShortBrake)
                .then(|| self.running.take().unwrap_or((*of, Default::default())));
            if running.is_none() {
                self.code = 0;
            }
            let effort = EffortState { volts: plant.volts(self.code), is_on };
            plant.hold_driven(effort, half_s);
            self.currents_a.push(plant.current_a());
            self.reading = shunt.reading(plant.current_a());
            plant.hold_driven(effort, half_s);
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
