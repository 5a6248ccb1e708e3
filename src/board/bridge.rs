//! The bridge on TIM1: PA8 and its complement PB13, enable PB0, direction PB1, break input PB12.
//!
//! The PWM is centre-aligned: the counter runs up to the top and down again, so that a change of
//! duty moves both edges and current is best sampled at the ends. The compare value is taken over
//! where the counter turns, at either end. The direction pin changes at once, so that on a reversal
//! the old magnitude has the new sign for half a period. Off means three things at once: both
//! outputs at their inactive level (`OSSI`), the enable pin low, and a neutral duty in waiting. The
//! break input is active low with a pull-up, which is what the open-drain fault output of a bridge
//! driver wants. It turns the outputs off in hardware, without a clock, and they stay off. A wire
//! that is cut goes unnoticed.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stiction::Parameters;
use stiction::drive::{Drive, Duty};
use stm32f4xx_hal::gpio::{Alternate, Output, PA8, PB0, PB1, PB12, PB13, PushPull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::HARDWARE;
use super::traits::Bridge;

/// The pins of the bridge.
pub struct Pins {
    /// Output of the PWM.
    pub high: PA8<Alternate<1>>,
    /// Complementary output of the PWM.
    pub low: PB13<Alternate<1>>,
    /// Break input, from the fault output of the bridge's driver.
    pub fault: PB12<Alternate<1>>,
    /// Enable output, which turns the bridge on.
    pub enable: PB0<Output<PushPull>>,
    /// Direction output: the sign, for a sign-magnitude bridge.
    pub direction: PB1<Output<PushPull>>,
}

/// The bridge: the PWM of TIM1 and the pins around it.
pub struct TimerBridge {
    pwm: Pwm,
    pins: Pins,
    neutral: Duty,
    on: bool,
}

/// The PWM on TIM1's first channel.
pub struct Pwm {
    timer: pac::TIM1,
    top: u16,
}

impl TimerBridge {
    /// Sets the PWM and the pins up with a neutral duty and the outputs off.
    pub fn new(timer: pac::TIM1, pins: Pins, settings: &Settings, rcc: &mut Rcc) -> Self {
        pac::TIM1::enable(rcc);
        pac::TIM1::reset(rcc);
        timer.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc1pe().enabled());
        timer.ccer().write(|w| w.cc1e().set_bit().cc1ne().set_bit());
        let pwm = Pwm { timer, top: settings.top };
        let mut bridge = Self { pwm, pins, neutral: settings.neutral, on: false };
        bridge.reconfigure(settings);
        let timer = &bridge.pwm.timer;
        timer.sr().write(|w| w.bif().clear_bit());
        timer.dier().write(|w| w.bie().set_bit());
        timer.cr1().write(|w| w.cms().center_aligned1().arpe().set_bit().cen().enabled());
        bridge
    }

    /// Sets another PWM and dead time, with a neutral duty and the outputs off.
    pub fn reconfigure(&mut self, settings: &Settings) {
        let Settings { top, neutral, dead_time } = *settings;
        // The top is taken over where the counter turns, as the compare value is.
        self.pwm.timer.arr().write(|w| w.arr().set(top));
        // Compare 0 would be full negative effort in locked antiphase, from the enabling of the
        // outputs to the first tick.
        self.off(neutral);
        (self.pwm.top, self.neutral) = (top, neutral);
        let timer = &self.pwm.timer;
        let dead_time = dead_time_code(dead_time);
        timer.bdtr().write(|w| {
            w.dtg()
                .set(dead_time)
                .ossi()
                .idle_level()
                .ossr()
                .idle_level()
                .bke()
                .enabled()
                .bkp()
                .clear_bit()
        });
        timer.egr().write(|w| w.ug().set_bit());
    }

    /// Turns the outputs off, whatever the last tick has said.
    pub fn rest(&mut self) {
        self.off(self.neutral);
    }

    /// Returns whether the break input has been let go. Its flag cannot be cleared while it is
    /// active.
    pub fn break_is_over(&self) -> bool {
        let timer = &self.pwm.timer;
        timer.sr().write(|w| w.bif().clear_bit());
        timer.sr().read().bif().bit_is_clear()
    }
}

/// The settings of a bridge.
#[derive(Clone, Copy)]
pub struct Settings {
    /// Compare value of full duty.
    pub top: u16,
    /// Duty of no effort.
    pub neutral: Duty,
    /// Time between the switching of complementary outputs, s.
    pub dead_time: f32,
}

impl Settings {
    /// The settings of a part without parameters: 22 kHz that nobody will see.
    pub const IDLE: Self =
        Self { top: 3818, neutral: Duty { compare: 1909, reverse: false }, dead_time: 1e-6 };

    /// Returns the settings that parameters ask for. The drive has been validated with everything
    /// else.
    pub fn of(parameters: &Parameters) -> Self {
        let drive = &parameters.controller.drive;
        let neutral =
            Drive::new(drive, &HARDWARE).map_or(Self::IDLE.neutral, |drive| drive.duty(0));
        Self {
            top: HARDWARE.pwm_top(drive.pwm_hz).unwrap_or(Self::IDLE.top),
            neutral,
            dead_time: parameters.device.dead_time,
        }
    }
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        self.top
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.timer.ccr1().write(|w| w.ccr().set(duty));
        Ok(())
    }
}

impl Bridge for TimerBridge {
    #[inline]
    fn drive(&mut self, duty: Duty) {
        self.pins.direction.set_state(duty.reverse.into());
        let Ok(()) = self.pwm.set_duty_cycle(duty.compare);
        if !self.on {
            self.on = true;
            self.pwm.timer.bdtr().modify(|_, w| w.moe().enabled());
            self.pins.enable.set_high();
        }
    }

    #[inline]
    fn off(&mut self, neutral: Duty) {
        self.pins.enable.set_low();
        self.pwm.timer.bdtr().modify(|_, w| w.moe().disabled_idle());
        self.pins.direction.set_low();
        let Ok(()) = self.pwm.set_duty_cycle(neutral.compare);
        self.on = false;
    }
}

/// Returns the code of a dead time (s), `DTG` of RM0090: four ranges at 168 MHz. It is rounded up,
/// since too short a dead time burns the bridge.
fn dead_time_code(dead_time: f32) -> u8 {
    let clocks = libm::ceilf(dead_time * HARDWARE.pwm_clock_hz) as u32;
    let code = match clocks {
        0..=127 => clocks,
        128..=254 => 0x80 | (clocks.div_ceil(2) - 64),
        255..=504 => 0xC0 | (clocks.div_ceil(8) - 32),
        _ => 0xE0 | (clocks.div_ceil(16).min(63) - 32),
    };
    code as u8
}

/// Turns the bridge off from anywhere, whatever state the program is in.
pub fn off_now() {
    // SAFETY: one write to a set/reset register, which cannot disturb another pin, and one that
    // only clears MOE; neither depends on anything that the program owns.
    unsafe {
        (*pac::GPIOB::ptr()).bsrr().write(|w| w.br0().set_bit());
        (*pac::TIM1::ptr()).bdtr().modify(|_, w| w.moe().disabled_idle());
    }
}

/// Silences the break interrupt: the input may stay active for ever, and its flag with it.
pub fn silence_break() {
    // SAFETY: this register is touched by the task of that interrupt, and by others that have
    // locked it out.
    unsafe { (*pac::TIM1::ptr()).dier().modify(|_, w| w.bie().clear_bit()) };
}

/// Lets the break interrupt come again. Its task has to be locked out.
pub fn hear_break() {
    // SAFETY: as above.
    unsafe { (*pac::TIM1::ptr()).dier().modify(|_, w| w.bie().set_bit()) };
}
