//! The brake resistor's output on TIM8: PC6, a pulse in each tick.
//!
//! ```text
//! tick     |               |               |        a tick starts the count, which runs once
//! count    |    /|    /    |    /|    /    |        up to 15/16 of the tick (one-pulse mode)
//! PC6      ______####______|__##########___|        high from the compare value to the end
//! ```
//!
//! A resistor that stays on burns. So no output that repeats automatically drives it: each tick
//! commands one pulse, and a program that hangs, or that a probe halts, commands no further one.
//! TIM8 is the free timer with a main output enable, as the bridge's TIM1: a reset, a panic, a hard
//! fault and a halted core turn its output off at once. PC6 is low from the first instructions on,
//! by its pull-down in the set-up, and by a resistor of the board in reset.
//!
//! The count has 1024 steps in a tick. Its clock is rounded so that a pulse is not longer than
//! commanded; at 10 kHz it is 2 % shorter.
//!
//! Not measured on hardware.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stiction::Parameters;
use stiction::control::brake_resistor::{BrakeResistorLaw, STEPS};
use stm32f4xx_hal::gpio::{Alternate, PC6};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::HARDWARE;

/// Steps of the count until it ends: the output is off before the next tick. The core's largest
/// duty is less.
const WINDOW: u16 = STEPS / 16 * 15;

/// The settings of the output.
#[derive(Clone, Copy)]
pub struct BrakeResistorSettings {
    /// The law of the resistor; none without one. Its output stays low then.
    pub law: Option<BrakeResistorLaw>,
    /// Divider of the timer's clock.
    divider: u16,
}

impl BrakeResistorSettings {
    /// Settings of a board without parameters.
    pub const NONE: Self = Self { law: None, divider: 1 };

    /// Returns the settings that validated parameters define.
    pub fn of(parameters: &Parameters) -> Self {
        // The timer has the clock of the PWM.
        let clocks = parameters.controller.sample_time * HARDWARE.pwm_clock_hz;
        let divider = (clocks / f32::from(STEPS)) as u16;
        Self { law: parameters.brake_resistor_law(&HARDWARE), divider: divider.max(1) }
    }
}

/// The output of the brake resistor.
pub struct BrakeResistorOutput {
    timer: pac::TIM8,
    law: Option<BrakeResistorLaw>,
    _pin: PC6<Alternate<3>>,
}

impl BrakeResistorOutput {
    /// Sets the timer up, with the output off.
    pub fn start(timer: pac::TIM8, pin: PC6<Alternate<3>>, rcc: &mut Rcc) -> Self {
        pac::TIM8::enable(rcc);
        pac::TIM8::reset(rcc);
        // Mode 2: off below the compare value, and so off at a count that stands at zero.
        timer.ccmr1_output().write(|w| w.oc1m().pwm_mode2());
        timer.arr().write(|w| w.arr().set(WINDOW - 1));
        timer.ccer().write(|w| w.cc1e().set_bit());
        Self { timer, law: None, _pin: pin }
    }

    /// Sets another sample time and another resistor, with the output off until the next tick. The
    /// heat stays that of the former one.
    pub fn reconfigure(&mut self, settings: &BrakeResistorSettings) {
        let BrakeResistorSettings { law, divider } = *settings;
        self.law = law.map(|law| law.after(self.law.as_ref()));
        off_now();
        // A pulse that is cut short would leave the output high: the count starts again below it.
        self.timer.cr1().write(|w| w.opm().set_bit());
        self.timer.ccr1().write(|w| w.ccr().set(WINDOW));
        self.timer.psc().write(|w| w.psc().set(divider - 1));
        self.timer.egr().write(|w| w.ug().set_bit());
        // Without MOE the output is driven low (OSSI).
        self.timer.bdtr().write(|w| w.ossi().idle_level().moe().bit(law.is_some()));
    }
}

impl BrakeResistorOutput {
    /// Starts the pulse of this tick, for a reading of the supply.
    pub fn tick(&mut self, supply: u16) {
        if let Some(law) = &mut self.law {
            let duty = law.step(supply);
            let Ok(()) = self.set_duty_cycle(duty);
        }
    }
}

impl ErrorType for BrakeResistorOutput {
    type Error = Infallible;
}

impl SetDutyCycle for BrakeResistorOutput {
    fn max_duty_cycle(&self) -> u16 {
        STEPS
    }

    /// Starts the pulse of this tick.
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.timer.ccr1().write(|w| w.ccr().set(WINDOW.saturating_sub(duty)));
        // From zero, with the divider.
        self.timer.egr().write(|w| w.ug().set_bit());
        self.timer.cr1().write(|w| w.opm().set_bit().cen().enabled());
        Ok(())
    }
}

/// Turns the output off from anywhere, whatever state the program is in.
pub fn off_now() {
    // SAFETY: one write that only clears MOE, which depends on nothing that the program owns.
    unsafe { (*pac::TIM8::ptr()).bdtr().modify(|_, w| w.moe().disabled_idle()) };
}
